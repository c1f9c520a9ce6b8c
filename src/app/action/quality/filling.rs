//! Facts about fillings that panels show, and paint that is projected to other photos: the jobs that find out.

use std::sync::Arc;

use crate::action::build::fill_hidden;
use crate::state::State;
use crate::state::panes::Pane;
use crate::state::quality::filling::{RankingInputs, Worst};
use crate::state::quality::lookup::ComputedValue;
use crate::state::running::JobKind;
use crate::state::session::{Session, stacks_of};
use crate::work::Work;
use crate::work::jobs::arrival;
use quadratura_base::scene::PhotoId;
use quadratura_document::{Project, Stack};
use quadratura_layers::fill::{FillOptions, Propagation};
use quadratura_sites::budget::default_memory;
use quadratura_stacks::fill::both_ways::both_ways;
use quadratura_stacks::fill::propagation::{PropagationToPhoto, most_disputed_first, painters, with_all};
use quadratura_stacks::fill::seen::{SeenEdit, edited};
use quadratura_stacks::fill::shares::layer_shares;
use quadratura_stacks::fill::viewpoints::RankedViewpoint;
use quadratura_stacks::fill::worst::hidden_layers_by_visibility;
use quadratura_stacks::fill::{FillRequest, stale_fillings, tell};
use quadratura_view::navigation::Viewpoint;

impl State {
    /// Flies to the viewpoint of a view; the selection is kept.
    pub fn look_from(&mut self, view: &RankedViewpoint) {
        let Some(session) = &self.session else { return };
        let ahead = view.pose.rotation.transpose() * glam::DVec3::Z;
        let eye = view.pose.center_in_world();
        let near =
            session.solid.nearest(eye, ahead).map_or(session.scene_frame.center, |hit| eye + ahead * hit.t);
        let there = Viewpoint::of_camera(&view.camera, &view.pose, near);
        self.panes.show(Pane::Space);
        self.fly_to_viewpoint(there);
    }

    /// Edits where paint is seen, which applies to the next filling.
    pub fn edit_seen(&mut self, edit: &SeenEdit) {
        let Some(session) = &self.session else { return };
        let options = edited(&session.history.present().fill, edit, session.model());
        self.edit_fill(options);
    }

    /// Sets the fill options, which apply to the next filling.
    pub fn edit_fill(&mut self, options: FillOptions) {
        let Some(session) = &self.session else { return };
        let before = session.history.present();
        let seen =
            |fill: &FillOptions| (fill.propagate.clone(), fill.only_here.clone(), fill.protected.clone());
        let step = match seen(&before.fill) == seen(&options) {
            true => "fill options",
            false => "choice of propagated paint",
        };
        self.quality.fill.stale = ComputedValue::default();
        let project = Project { fill: options, ..Project::clone(before) };
        self.edit(step, project, None);
    }
}

/// The longest side of the pictures of a question, in pixels.
const PICTURE: u32 = 512;

/// Starts making the pictures of the question where paint is seen, unless they are made.
pub fn want_both_ways(state: &mut State, work: &mut Work) {
    let built = |session: &&Session| session.photos.iter().any(|photo| photo.stack.is_some());
    let due = state.quality.fill.both_ways.is_due();
    let Some(session) = state.session.as_ref().filter(built).filter(|_| due) else { return };
    let (folder, opened) = (session.folder.clone(), session.opened.clone());
    let ticket = state.quality.fill.both_ways.ticket();
    let job =
        work.jobs.start(&mut state.running, JobKind::Look, "Previewing propagated paint", move |task| {
            let both = both_ways(&folder, &opened.project, &opened.site, PICTURE, task)?.map(Arc::new);
            Ok(arrival(move |state| state.quality.fill.both_ways.find(&ticket, both)))
        });
    state.quality.fill.both_ways.is_sought_by(job);
}

/// Starts finding the photos whose fillings are out of date, unless they are known.
pub fn want_stale(state: &mut State, work: &mut Work) {
    let Some(session) = state.session.as_ref().filter(|_| state.quality.fill.stale.is_due()) else { return };
    let (folder, opened) = (session.folder.clone(), session.opened.clone());
    let ticket = state.quality.fill.stale.ticket();
    let job = work.jobs.start(&mut state.running, JobKind::Look, "Checking fillings", move |_| {
        let stale = stale_fillings(&folder, &opened.project, &opened.site)?;
        Ok(arrival(move |state| state.quality.fill.stale.find(&ticket, stale)))
    });
    state.quality.fill.stale.is_sought_by(job);
}

/// Starts ranking layers by the visibility of their occluded areas, unless it is known.
pub fn want_worst(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let fill = &mut state.quality.fill;
    let viewpoints = fill.seen_from(&session.opened.project);
    let inputs = RankingInputs::new(viewpoints, &session.opened.project);
    let known = fill.asked.as_ref().is_some_and(|asked| asked.has_views_of(&inputs));
    // During a drag of a keyframe one ranking is finished before the next one starts.
    if !known && !fill.worst.is_sought(&state.running) {
        (fill.asked, fill.worst) = (Some(inputs), ComputedValue::default());
    }
    if !fill.worst.is_due() {
        return;
    }
    let (opened, up) = (session.opened.clone(), session.scene_frame.up);
    let stacks = stacks_of(&session.photos);
    let ticket = fill.worst.ticket();
    let job = work.jobs.start(&mut state.running, JobKind::Look, "Finding occluded areas", move |task| {
        let stacks: Vec<Option<&Stack>> = stacks.iter().map(Option::as_deref).collect();
        let views = Arc::new(viewpoints.views(&opened.project, &opened.site, up));
        let layers = hidden_layers_by_visibility(&opened.site, &stacks, &views, task)?;
        Ok(arrival(move |state| state.quality.fill.worst.find(&ticket, Worst { layers, views })))
    });
    state.quality.fill.worst.is_sought_by(job);
}

/// Starts computing the provenance of a photo's layers, unless it is known.
pub fn want_shares(state: &mut State, work: &mut Work, photo: PhotoId) {
    let Some(session) = &state.session else { return };
    let lookup = state.quality.fill.shares.entry(photo).or_default();
    if !lookup.is_due() {
        return;
    }
    let (folder, name) = (session.folder.clone(), session.opened.site.photo(photo).name.clone());
    let ticket = lookup.ticket();
    let job = work.jobs.start(
        &mut state.running,
        JobKind::Look,
        format!("Reading the filling of {name}"),
        move |task| {
            let shares = layer_shares(&folder, &name, task)?;
            Ok(arrival(move |state| {
                state.quality.fill.shares.entry(photo).or_default().find(&ticket, shares);
            }))
        },
    );
    lookup.is_sought_by(job);
}

/// Starts finding the photos that have paint, unless they are known.
pub fn want_painters(state: &mut State, work: &mut Work) {
    let Some(session) = state.session.as_ref().filter(|_| state.quality.fill.painters.is_due()) else {
        return;
    };
    let (folder, ticket) = (session.folder.clone(), state.quality.fill.painters.ticket());
    let job = work.jobs.start(&mut state.running, JobKind::Look, "Finding paint", move |_| {
        let painters = painters(&folder)?;
        Ok(arrival(move |state| state.quality.fill.painters.find(&ticket, painters)))
    });
    state.quality.fill.painters.is_sought_by(job);
}

/// Starts computing which paint would be projected to which photos; nothing is written.
pub fn look_at_propagation(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let (folder, opened) = (session.folder.clone(), session.opened.clone());
    let decided = &opened.project.fill;
    let options =
        if decided.propagate.patterns().is_empty() { with_all(decided, true) } else { decided.clone() };
    state.quality.fill.offered = ComputedValue::default();
    let ticket = state.quality.fill.offered.ticket();
    let job =
        work.jobs.start(&mut state.running, JobKind::Look, "Previewing propagated paint", move |task| {
            let (photos, memory) = (Vec::new(), default_memory());
            let request =
                FillRequest { options: options.clone(), photos, memory, force: false, keep_former: false };
            let message = tell(&folder, &opened.project, &opened.site, &request, task)?;
            let propagated = message
                .into_iter()
                .filter_map(|it| Some((opened.site.photo_named(&it.photo)?, it.propagated)));
            let propagated = propagated.flat_map(|(photo, all)| {
                all.into_iter().map(move |paint| PropagationToPhoto { photo, paint })
            });
            let propagated = most_disputed_first(propagated.collect());
            Ok(arrival(move |state| state.quality.fill.offered.find(&ticket, (options, propagated))))
        });
    state.quality.fill.offered.is_sought_by(job);
}

/// Projects paint to other photos, that of all photos where no choice was made, and fills.
pub fn propagate_paint(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let options = session.opened.project.fill.clone();
    if options.propagate.patterns().is_empty() {
        state.edit_fill(with_all(&options, true));
    }
    fill_hidden(state, work);
}

/// Removes all projected paint.
pub fn take_propagated_off(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let options = session.opened.project.fill.clone();
    if options.propagate != Propagation::None {
        state.edit_fill(with_all(&options, false));
    }
    fill_hidden(state, work);
}
