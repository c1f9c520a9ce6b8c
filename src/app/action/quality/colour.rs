//! Decisions about the photos' exposures: visible at once, and one step of the history for each gesture.

use std::sync::Arc;

use super::surroundings::renew_surroundings;
use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::state::quality::colour::GainInputs;
use crate::state::request::{JobRequest, QualityRequest};
use crate::state::running::JobKind;
use crate::work::Work;
use crate::work::painter::PreviewChange;
use quadratura_document::Project;
use quadratura_document::history::Gesture;
use quadratura_stacks::gains::decided_gains;
use quadratura_views::colour::{ColourEdit, edited, estimate, factors, usual_exposure};

/// The gesture of a slider: each drag ends its own.
const DRAG: Gesture = Gesture(0xc0_10_0f);

impl State {
    /// Shows the decided exposure in the 3D view.
    pub fn show_exposure(&mut self) {
        if let Some(session) = &self.session {
            self.space.look.exposure = usual_exposure(&session.opened.project, &session.opened.site);
        }
    }
}

/// Starts an estimate for the current decisions, unless it exists.
pub fn want_estimate(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let colour = session.opened.project.colour.clone();
    let asked = GainInputs::from_colour(&colour);
    if state.quality.colour.is_asked(&asked) {
        return;
    }
    let sought = asked.clone();
    let (folder, opened) = (session.folder.clone(), session.opened.clone());
    let job = work.jobs.start(&mut state.running, JobKind::Colour, "Comparing exposures", move |task| {
        let estimate = Arc::new(estimate(&folder, &opened.site, &colour, task)?);
        Ok(Box::new(move |state| {
            if state.session.as_ref().is_none_or(|session| session.folder != folder) {
                return Vec::new();
            }
            let groups = estimate.gains.light.groups.clone();
            let before = state.quality.colour.estimate.replace((asked, estimate));
            let mut requests = vec![QualityRequest::ShowGains.into()];
            // Photos of other groups do not contradict each other: photos are compared again, while the current 3D view
            // keeps drawing.
            if before.is_some_and(|(_, before)| before.gains.light.groups != groups) {
                requests.push(JobRequest::PreparePainter.into());
            }
            requests
        }))
    });
    state.quality.colour.estimating = Some((sought, job));
}

/// Edits decisions about colour. `goes_on`: the gesture continues, and all of it is one step.
pub fn edit_colour(state: &mut State, work: &mut Work, edits: &[ColourEdit], goes_on: bool) {
    let Some(session) = &state.session else { return };
    let project = session.history.present();
    let colour = match edited(&project.colour, edits, &session.opened.site) {
        Ok(colour) => colour,
        Err(error) => return state.notify(Note::new(Weight::Problem, error.message())),
    };
    let project = Project { colour, ..Project::clone(project) };
    state.edit(name_of(edits), project, Some(DRAG));
    if !goes_on {
        state.end_gesture();
    }
    show_gains(state, work);
}

/// Updates the exposures after decisions about colour, also where these were undone or redone.
pub fn follow_colour(state: &mut State, work: &mut Work) {
    state.show_exposure();
    want_estimate(state, work);
    show_gains(state, work);
    renew_surroundings(state, work);
}

/// Applies the decided exposures to the 3D view, as far as they are known.
pub fn show_gains(state: &mut State, work: &mut Work) {
    state.show_exposure();
    let Some((_, estimate)) = state.quality.colour.estimate.clone() else { return };
    let Some(session) = &mut state.session else { return };
    let colour = session.opened.project.colour.clone();
    let gains = decided_gains(&estimate, &colour, &session.opened.site);
    state.quality.colour.factors = factors(&gains.of_photo, &colour, &session.opened.site);
    if let Some(painter) = &mut work.painter {
        painter.change(PreviewChange::Gains(Box::new(gains)));
        state.space.redraw();
    }
}

/// Returns the name of the step.
fn name_of(edits: &[ColourEdit]) -> String {
    match edits.first() {
        Some(ColourEdit::Fix(photo, _)) => format!("exposure of {photo}"),
        Some(ColourEdit::LeaveOut(photo)) => format!("leaving out {photo}"),
        Some(ColourEdit::Free(photo)) => format!("exposure of {photo} as estimated"),
        Some(ColourEdit::Reference(Some(photo))) => format!("{photo} as reference"),
        Some(ColourEdit::Reference(None)) => "no reference".into(),
        Some(ColourEdit::Rule(_)) => "exposure of views".into(),
        Some(ColourEdit::Group(..) | ColourEdit::OneGroup | ColourEdit::FindGroups) => {
            "groups of light".into()
        }
        Some(ColourEdit::Even(_)) => "matching of exposures".into(),
        Some(ColourEdit::Vignetting(_)) => "vignetting correction".into(),
        Some(ColourEdit::Offset(_)) => "haze correction".into(),
        Some(ColourEdit::Reset) | None => "reset of colour".into(),
    }
}
