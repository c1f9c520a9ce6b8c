//! The surroundings of the 3D view after a change of exposures, or of paint on them: they are compared and blended again
//! in the background, while the view shows the former ones.

use std::sync::Arc;

use crate::state::State;
use crate::state::quality::colour::GainInputs;
use crate::state::request::QualityRequest;
use crate::state::running::JobKind;
use crate::state::session::Session;
use crate::work::Work;
use crate::work::painter::PreviewChange;
use quadratura_base::scene::builder::SURROUNDINGS;
use quadratura_document::paint::{PaintBook, PaintEntry};
use quadratura_stacks::surroundings::SiteSurroundings;

/// Starts to make the surroundings of the present gains and paint for the 3D view, if a photo shows any.
pub fn renew_surroundings(state: &mut State, work: &mut Work) {
    let Some(session) = state.session.as_ref().filter(|_| work.painter.is_some()) else { return };
    let stacks: Vec<_> = session.photos.iter().map(|photo| photo.stack.clone()).collect();
    if stacks.iter().flatten().all(|stack| stack.surroundings().is_none()) {
        return;
    }
    let colour = &session.opened.project.colour;
    let known = &state.quality.colour;
    let is_former =
        known.estimate.as_ref().is_some_and(|(inputs, _)| *inputs != GainInputs::from_colour(colour));
    let is_estimating = known.estimating.as_ref().is_some_and(|(_, job)| state.running.is_running(*job));
    if is_former || is_estimating {
        // The surroundings follow the estimate.
        return;
    }
    let (folder, opened) = (session.folder.clone(), session.opened.clone());
    work.jobs.stop_kind(&mut state.running, JobKind::Surroundings);
    work.jobs.start(&mut state.running, JobKind::Surroundings, "Blending surroundings", move |task| {
        let stacks: Vec<_> = stacks.iter().map(Option::as_deref).collect();
        let surroundings =
            Box::new(SiteSurroundings::present(&folder, &opened.project, &opened.site, &stacks, task)?);
        Ok(Box::new(move |state| {
            let is_of = |session: &&Session| {
                session.folder == folder && Arc::ptr_eq(&session.opened.site.model, &opened.site.model)
            };
            match state.session.as_ref().filter(is_of) {
                Some(_) => vec![QualityRequest::ShowSurroundings(surroundings).into()],
                None => Vec::new(),
            }
        }))
    });
}

/// Shows surroundings in the 3D view.
pub fn show_surroundings(state: &mut State, work: &mut Work, surroundings: Box<SiteSurroundings>) {
    if let Some(painter) = &mut work.painter {
        painter.change(PreviewChange::Surroundings(surroundings));
        state.space.redraw();
    }
}

/// Returns whether paint on surroundings differs between two books; an unknown one is taken for empty.
pub fn is_repainted(before: Option<&PaintBook>, after: &PaintBook) -> bool {
    let entries = |book: &PaintBook| -> Vec<PaintEntry> {
        book.entries.iter().filter(|entry| entry.object == SURROUNDINGS).cloned().collect()
    };
    before.map_or_else(Vec::new, entries) != entries(after)
}
