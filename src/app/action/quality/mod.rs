//! Actions on filling and exposures.

pub mod colour;
pub mod filling;
pub mod surroundings;

use self::colour::{edit_colour, show_gains, want_estimate};
use self::filling::{
    look_at_propagation, propagate_paint, take_propagated_off, want_both_ways, want_painters, want_shares,
    want_stale, want_worst,
};
use self::surroundings::{renew_surroundings, show_surroundings};
use crate::state::State;
use crate::state::request::QualityRequest;
use crate::work::Work;

/// Applies a request about filling and exposures.
pub fn apply(state: &mut State, work: &mut Work, request: QualityRequest) {
    match request {
        QualityRequest::Fill(options) => state.edit_fill(options),
        QualityRequest::TypeWithout(text) => state.quality.fill.without = text,
        QualityRequest::SeeFrom(viewpoints) => state.quality.fill.viewpoints = Some(viewpoints),
        QualityRequest::WantWorst => want_worst(state, work),
        QualityRequest::WantShares(photo) => want_shares(state, work, photo),
        QualityRequest::WantPainters => want_painters(state, work),
        QualityRequest::WantEstimate => want_estimate(state, work),
        QualityRequest::EstimateAgain => state.quality.colour = Default::default(),
        QualityRequest::Colour { edits, goes_on } => edit_colour(state, work, &edits, goes_on),
        QualityRequest::LookAtPropagation => look_at_propagation(state, work),
        QualityRequest::See(edit) => state.edit_seen(&edit),
        QualityRequest::WantBothWays => want_both_ways(state, work),
        QualityRequest::ChooseLater => state.quality.fill.chooses_later = true,
        QualityRequest::WantStale => want_stale(state, work),
        QualityRequest::Propagate => propagate_paint(state, work),
        QualityRequest::TakePropagatedOff => take_propagated_off(state, work),
        QualityRequest::ShowGains => {
            show_gains(state, work);
            renew_surroundings(state, work);
        }
        QualityRequest::ShowSurroundings(surroundings) => show_surroundings(state, work, surroundings),
    }
}
