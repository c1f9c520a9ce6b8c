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
use crate::state::ask::QualityAsk;
use crate::work::Work;

/// Applies an ask about filling and exposures.
pub fn apply(state: &mut State, work: &mut Work, ask: QualityAsk) {
    match ask {
        QualityAsk::Fill(options) => state.edit_fill(options),
        QualityAsk::TypeWithout(text) => state.quality.fill.without = text,
        QualityAsk::SeeFrom(lookouts) => state.quality.fill.lookouts = Some(lookouts),
        QualityAsk::WantWorst => want_worst(state, work),
        QualityAsk::WantShares(photo) => want_shares(state, work, photo),
        QualityAsk::WantPainters => want_painters(state, work),
        QualityAsk::WantEstimate => want_estimate(state, work),
        QualityAsk::EstimateAgain => state.quality.colour = Default::default(),
        QualityAsk::Colour { edits, goes_on } => edit_colour(state, work, &edits, goes_on),
        QualityAsk::LookAtPropagation => look_at_propagation(state, work),
        QualityAsk::See(edit) => state.edit_seen(&edit),
        QualityAsk::WantBothWays => want_both_ways(state, work),
        QualityAsk::ChooseLater => state.quality.fill.chooses_later = true,
        QualityAsk::WantStale => want_stale(state, work),
        QualityAsk::Propagate => propagate_paint(state, work),
        QualityAsk::TakePropagatedOff => take_propagated_off(state, work),
        QualityAsk::ShowGains => {
            show_gains(state, work);
            renew_surroundings(state, work);
        }
        QualityAsk::ShowSurroundings(surroundings) => show_surroundings(state, work, surroundings),
    }
}
