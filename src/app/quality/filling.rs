//! The filling of occluded areas: where it is most visible, its provenance, and the options.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::lookup::ComputedValue;
use crate::app::action::build::fill_hidden;
use crate::app::state::State;
use crate::app::state::panes::Pane;
use crate::app::state::running::JobKind;
use crate::app::work::Work;
use crate::app::work::jobs::arrival;
use crate::document::{Bookmark, CameraPath, Project, Stack};
use crate::layers::fill::FillOptions;
use crate::projection::navigation::Viewpoint;
use crate::recipe::budget::default_memory;
use crate::recipe::fill::lookouts::{LookoutView, Viewpoints};
use crate::recipe::fill::propagation::{
    PaintedPhoto, PropagationToPhoto, most_disputed_first, painters, with_all,
};
use crate::recipe::fill::shares::{LayerShares, layer_shares};
use crate::recipe::fill::worst::{HiddenLayer, hidden_layers_by_visibility};
use crate::recipe::fill::{FillRequest, tell};

/// The cached facts about fillings.
#[derive(Default)]
pub struct FillSession {
    /// The viewpoints chosen by the user; otherwise the default of the project is used.
    pub lookouts: Option<Viewpoints>,
    /// Layers ranked by how much of their occluded areas is visible.
    pub worst: ComputedValue<Worst>,
    /// The views that the ranking was requested for.
    asked: Option<LookoutInputs>,
    /// The provenance of hidden texels of a photo's layers, by index of the photo.
    pub shares: BTreeMap<usize, ComputedValue<Vec<LayerShares>>>,
    /// The photos that have paint.
    pub painters: ComputedValue<Vec<PaintedPhoto>>,
    /// The paint that would be projected to other photos, with the options that it was computed for.
    pub offered: ComputedValue<(FillOptions, Vec<PropagationToPhoto>)>,
    /// The names of excluded objects, while they are being typed.
    pub without: Option<String>,
}

/// Layers ranked by how much of their occluded areas is visible, with the views that see it.
pub struct Worst {
    /// The layers, the most visible area first.
    pub layers: Vec<HiddenLayer>,
    /// The views, indexed by [`HiddenLayer::view`].
    pub views: Arc<Vec<LookoutView>>,
}

/// The inputs of the views.
#[derive(PartialEq)]
struct LookoutInputs {
    lookouts: Viewpoints,
    kept: Vec<Bookmark>,
    flight: Option<CameraPath>,
}

impl FillSession {
    /// Drops facts that depend on fillings or paint.
    pub fn forget_fillings(&mut self) {
        self.shares.clear();
        (self.painters, self.offered) = Default::default();
    }

    /// Drops facts that depend on stacks; the user's choices are kept.
    pub fn forget_stacks(&mut self) {
        *self = Self { lookouts: self.lookouts, without: self.without.take(), ..Self::default() };
    }
}

impl State {
    /// Returns the viewpoints from which visibility is judged.
    pub fn lookouts(&self) -> Viewpoints {
        let usual =
            self.session.as_ref().map_or(Viewpoints::Photos, |s| Viewpoints::usual(&s.opened.project));
        self.quality.fill.lookouts.unwrap_or(usual)
    }

    /// Flies to the viewpoint of a view; the selection is kept.
    pub fn look_from(&mut self, view: &LookoutView) {
        let Some(session) = &self.session else { return };
        let ahead = view.pose.rotation.transpose() * glam::DVec3::Z;
        let eye = view.pose.center_in_world();
        let near =
            session.solid.nearest(eye, ahead).map_or(session.scene_frame.center, |hit| eye + ahead * hit.t);
        let there = Viewpoint::of_camera(&view.camera, &view.pose, near);
        self.panes.show(Pane::Space);
        self.fly_to_viewpoint(there);
    }

    /// Returns whether paint of some photo is projected to another one, or a decision asks for it.
    pub fn has_propagated(&self) -> bool {
        self.session.as_ref().is_some_and(|session| {
            let fills = session.photos.iter().filter_map(|photo| photo.stack.as_ref()?.fill.as_ref());
            let laid = fills.flat_map(|fill| &fill.propagated).any(|paint| paint.texels > 0);
            laid || !session.opened.project.fill.propagate.is_empty()
        })
    }

    /// Sets the fill options, which apply to the next filling.
    pub fn edit_fill(&mut self, options: FillOptions) {
        let Some(session) = &self.session else { return };
        let before = session.history.present();
        let step = match before.fill.propagate == options.propagate {
            true => "options of filling",
            false => "which paint is laid over other photos",
        };
        let project = Project { fill: options, ..Project::clone(before) };
        self.edit(step, project, None);
    }
}

/// Starts ranking layers by the visibility of their occluded areas, unless it is known.
pub fn want_worst(state: &mut State, work: &mut Work) {
    let lookouts = state.lookouts();
    let Some(session) = &state.session else { return };
    let project = &session.opened.project;
    let fill = &mut state.quality.fill;
    let is_asked = |asked: &LookoutInputs| {
        asked.lookouts == lookouts
            && (lookouts == Viewpoints::Photos
                || (asked.kept == project.views && asked.flight == project.flight))
    };
    let known = fill.asked.as_ref().is_some_and(is_asked);
    // During a drag of a keyframe one ranking is finished before the next one starts.
    if !known && !fill.worst.is_sought(&state.running) {
        let (kept, flight) = (project.views.clone(), project.flight.clone());
        fill.asked = Some(LookoutInputs { lookouts, kept, flight });
        fill.worst = ComputedValue::default();
    }
    if !fill.worst.is_due() {
        return;
    }
    let (opened, up) = (session.opened.clone(), session.scene_frame.up);
    let stacks: Vec<_> = session.photos.iter().map(|photo| photo.stack.clone()).collect();
    let ticket = fill.worst.ticket();
    let job = work.jobs.start(&mut state.running, JobKind::Look, "Looking for hidden parts", move |task| {
        let stacks: Vec<Option<&Stack>> = stacks.iter().map(Option::as_deref).collect();
        let views = Arc::new(lookouts.views(&opened.project, &opened.site, up));
        let layers = hidden_layers_by_visibility(&opened.site, &stacks, &views, task)?;
        Ok(arrival(move |state| state.quality.fill.worst.find(&ticket, Worst { layers, views })))
    });
    state.quality.fill.worst.is_sought_by(job);
}

/// Starts computing the provenance of a photo's layers, unless it is known.
pub fn want_shares(state: &mut State, work: &mut Work, photo: usize) {
    let Some(session) = &state.session else { return };
    let lookup = state.quality.fill.shares.entry(photo).or_default();
    if !lookup.is_due() {
        return;
    }
    let (folder, name) = (session.folder.clone(), session.opened.site.photos[photo].name.clone());
    let ticket = lookup.ticket();
    let job = work.jobs.start(
        &mut state.running,
        JobKind::Look,
        format!("Looking at fillings of {name}"),
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
    let job = work.jobs.start(&mut state.running, JobKind::Look, "Looking for paint", move |_| {
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
    let options = if decided.propagate.is_empty() { with_all(decided, true) } else { decided.clone() };
    state.quality.fill.offered = ComputedValue::default();
    let ticket = state.quality.fill.offered.ticket();
    let job =
        work.jobs.start(&mut state.running, JobKind::Look, "Looking where paint would go", move |task| {
            let (photos, memory) = (Vec::new(), default_memory());
            let request =
                FillRequest { options: options.clone(), photos, memory, force: false, keep_former: false };
            let message = tell(&folder, &opened, &request, task)?;
            let place = |name: &str| opened.site.photos.iter().position(|photo| photo.name == name);
            let propagated = message.into_iter().filter_map(|it| Some((place(&it.photo)?, it.propagated)));
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
    if options.propagate.is_empty() {
        state.edit_fill(with_all(&options, true));
    }
    fill_hidden(state, work);
}

/// Removes all projected paint.
pub fn take_propagated_off(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let options = session.opened.project.fill.clone();
    if !options.propagate.is_empty() {
        state.edit_fill(with_all(&options, false));
    }
    fill_hidden(state, work);
}
