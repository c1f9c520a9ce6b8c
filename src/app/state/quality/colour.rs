//! Exposures of the photos: the estimate, and what the decisions make of it.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::state::running::{JobId, Running};
use crate::state::session::Session;
use quadratura_document::ColourDecisions;
use quadratura_projection::exposure::Estimate;
use quadratura_views::colour::{ColourReport, report_from_estimate};

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
    /// Returns the exposures of all photos; none until they are estimated.
    pub fn report(&self, session: &Session) -> Option<ColourReport> {
        let (_, estimate) = self.estimate.as_ref()?;
        Some(report_from_estimate(estimate, &session.opened.project.colour, &session.opened.site))
    }

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
    groups: Option<BTreeMap<String, BTreeSet<String>>>,
    vignetting: Option<bool>,
    offset: bool,
}

impl GainInputs {
    /// Returns those of a project's decisions.
    pub fn from_colour(colour: &ColourDecisions) -> Self {
        let ColourDecisions { left_out, groups, vignetting, offset, .. } = colour.clone();
        Self { left_out, groups, vignetting, offset }
    }
}
