//! Exposures of the photos: the estimate, and what the decisions make of it.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::app::state::State;
use crate::app::state::running::{JobId, Running};
use crate::document::ColourDecisions;
use crate::projection::exposure::Estimate;
use crate::recipe::colour::{ColourReport, report_from_estimate, usual_exposure};

/// The state of exposures: the estimate, and the decision in progress.
#[derive(Default)]
pub struct ColourSession {
    /// The estimate from the photos, and the decisions that it was made for.
    pub estimate: Option<(GainInputs, Arc<Estimate>)>,
    /// The factors of the photos' linear light that match their exposures, R, G, B, in the site's order; empty until
    /// they are known.
    pub factors: Vec<[f64; 3]>,
    /// The estimate that is being made, or that failed.
    pub estimating: Option<(GainInputs, JobId)>,
}

impl ColourSession {
    /// Returns whether the estimate for these decisions was made, is being made, or failed.
    pub fn is_asked(&self, inputs: &GainInputs) -> bool {
        let made = self.estimate.as_ref().map(|(of, _)| of);
        let asked = self.estimating.as_ref().map(|(of, _)| of);
        made == Some(inputs) || asked == Some(inputs)
    }

    /// Returns whether the job ended without an estimate; the error is in the messages.
    pub fn failed(&self, running: &Running) -> bool {
        self.estimate.is_none() && self.estimating.as_ref().is_some_and(|(_, job)| !running.is_running(*job))
    }
}

/// The decisions that an estimate depends on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GainInputs {
    left_out: BTreeSet<String>,
    vignetting: bool,
    offset: bool,
}

impl GainInputs {
    /// Returns those of a project's decisions.
    pub fn from_colour(colour: &ColourDecisions) -> Self {
        Self { left_out: colour.left_out.clone(), vignetting: colour.vignetting, offset: colour.offset }
    }
}

impl State {
    /// Returns the decisions about colour.
    pub fn colour(&self) -> Option<&ColourDecisions> {
        Some(&self.session.as_ref()?.opened.project.colour)
    }

    /// Returns the exposures of all photos; none until they are estimated.
    pub fn colour_report(&self) -> Option<ColourReport> {
        let (_, estimate) = self.quality.colour.estimate.as_ref()?;
        Some(report_from_estimate(estimate, self.colour()?, &self.session.as_ref()?.opened.site))
    }

    /// Returns the factors of a photo's linear light that match the others, R, G, B; none until they are known.
    pub fn even_factors(&self, photo: usize) -> Option<[f64; 3]> {
        self.quality.colour.factors.get(photo).copied()
    }

    /// Shows the decided exposure in the 3D view.
    pub fn show_exposure(&mut self) {
        if let Some(session) = &self.session {
            self.space.look.exposure = usual_exposure(&session.opened);
        }
    }
}
