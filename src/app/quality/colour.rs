//! Decisions about the photos' exposures: seen at once, and one step of the history a gesture.

use std::sync::Arc;

use crate::app::editor::Editor;
use crate::app::jobs::{JobId, Jobs, Kind};
use crate::app::notes::{Note, Weight};
use crate::app::painter::Change;
use crate::document::history::Gesture;
use crate::document::{Colour, Project};
use crate::projection::exposure::Estimate;
use crate::recipe::colour::{ColourEdit, ColourReport, edited, estimate, factors, told_of, usual_exposure};
use crate::recipe::gains::decided_gains;

/// What is known of exposures, and what is being decided.
#[derive(Default)]
pub struct ColourDesk {
    /// What photos themselves say, and for which decisions.
    pub estimate: Option<(Asked, Arc<Estimate>)>,
    /// What photos' linear colours are multiplied with to come out alike, R, G, B, in the site's order; empty until
    /// that is known.
    factors: Vec<[f64; 3]>,
    /// What is being estimated, or could not be.
    estimating: Option<(Asked, JobId)>,
}

impl ColourDesk {
    /// The job has ended without an estimate; why is in the notes.
    pub fn failed(&self, jobs: &Jobs) -> bool {
        self.estimate.is_none() && self.estimating.as_ref().is_some_and(|(_, job)| !jobs.is_running(*job))
    }
}

/// One drag of a slider after the other: each ends its own.
const DRAG: Gesture = Gesture(0xc0_10_0f);

/// The decisions that an estimate depends on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Asked {
    left_out: std::collections::BTreeSet<String>,
    vignetting: bool,
    offset: bool,
}

impl Asked {
    fn of(colour: &Colour) -> Self {
        Self { left_out: colour.left_out.clone(), vignetting: colour.vignetting, offset: colour.offset }
    }
}

impl Editor {
    /// What was decided about colour.
    pub fn colour(&self) -> Option<&Colour> {
        Some(&self.session.as_ref()?.opened.project.colour)
    }

    /// What holds for each photo; none until it was estimated.
    pub fn colour_report(&self) -> Option<ColourReport> {
        let (_, estimate) = self.quality.colour.estimate.as_ref()?;
        Some(told_of(estimate, self.colour()?, &self.session.as_ref()?.opened.site))
    }

    /// Sees to it that there is an estimate for what was decided.
    pub fn want_estimate(&mut self) {
        let (Some(colour), Some(session)) = (self.colour().cloned(), &self.session) else { return };
        let asked = Asked::of(&colour);
        let desk = &mut self.quality.colour;
        let known = desk.estimate.as_ref().is_some_and(|(of, _)| *of == asked);
        if known || desk.estimating.as_ref().is_some_and(|(of, _)| *of == asked) {
            return;
        }
        let sought = asked.clone();
        let (folder, opened) = (session.folder.clone(), session.opened.clone());
        let job = self.jobs.start(Kind::Colour, "Comparing exposures", move |task| {
            let estimate = Arc::new(estimate(&folder, &opened, &colour, task)?);
            Ok(Box::new(move |editor| {
                if editor.session.as_ref().is_some_and(|session| session.folder == folder) {
                    editor.quality.colour.estimate = Some((asked, estimate));
                    editor.show_gains();
                }
            }))
        });
        self.quality.colour.estimating = Some((sought, job));
    }

    /// What a photo's linear colours are multiplied with to look as the others, R, G, B; none until that is known.
    pub fn even_factors(&self, photo: usize) -> Option<[f64; 3]> {
        self.quality.colour.factors.get(photo).copied()
    }

    /// Decides something about colour. `goes_on`: the gesture has not ended; all of it is one step.
    pub fn edit_colour(&mut self, edits: &[ColourEdit], goes_on: bool) {
        let Some(session) = &self.session else { return };
        let project = session.history.present();
        let colour = match edited(&project.colour, edits, &session.opened.site) {
            Ok(colour) => colour,
            Err(error) => return self.tell(Note::new(Weight::Problem, error.to_string())),
        };
        let project = Project { colour, ..Project::clone(project) };
        self.edit(name_of(edits), project, Some(DRAG));
        if !goes_on {
            self.end_gesture();
        }
        self.show_gains();
    }

    /// Decisions about colour were undone or done again.
    pub(in crate::app) fn follow_colour(&mut self) {
        self.show_exposure();
        self.want_estimate();
        self.show_gains();
    }

    /// The 3D view comes out with the exposure that was decided.
    pub(in crate::app) fn show_exposure(&mut self) {
        if let Some(session) = &self.session {
            self.space.look.exposure = usual_exposure(&session.opened);
        }
    }

    /// The 3D view shows photos as it was decided, as far as that is known.
    fn show_gains(&mut self) {
        self.show_exposure();
        let Some((_, estimate)) = self.quality.colour.estimate.clone() else { return };
        let Some(colour) = self.colour().cloned() else { return };
        let Some(session) = &mut self.session else { return };
        let gains = decided_gains(&estimate, &colour, &session.opened.site);
        self.quality.colour.factors = factors(&gains.of_photo, &colour, &session.opened.site);
        if let Some(painter) = &mut session.painter {
            painter.change(Change::Gains(gains));
            self.space.redraw();
        }
    }
}

/// What a step is called.
fn name_of(edits: &[ColourEdit]) -> String {
    match edits.first() {
        Some(ColourEdit::Fix(photo, _)) => format!("exposure of {photo}"),
        Some(ColourEdit::LeaveOut(photo)) => format!("leaving out {photo}"),
        Some(ColourEdit::Free(photo)) => format!("exposure of {photo} as estimated"),
        Some(ColourEdit::Reference(Some(photo))) => format!("{photo} as reference"),
        Some(ColourEdit::Reference(None)) => "no reference".into(),
        Some(ColourEdit::Even(_)) => "evening out exposures".into(),
        Some(ColourEdit::Vignetting(_)) => "dark corners".into(),
        Some(ColourEdit::Offset(_)) => "haze".into(),
        Some(ColourEdit::Reset) | None => "reset of colour".into(),
    }
}
