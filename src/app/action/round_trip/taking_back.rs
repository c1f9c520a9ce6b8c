//! Undoing of the last import.

use super::importing::take_back_import;
use crate::action::decide::undo_step;
use crate::state::State;
use crate::work::Work;

/// Undoes the last import: by undo where it is the last step, otherwise without the history.
pub fn take_back_last(state: &mut State, work: &mut Work) {
    let Some(number) = state.round_trip.history.last().map(|import| import.number) else { return };
    let step = state.session.as_ref().and_then(|session| session.history.undoes_import());
    if step == Some(number) {
        return undo_step(state, work);
    }
    state.forget_import(number);
    take_back_import(state, work, number);
}
