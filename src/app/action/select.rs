//! Actions on the selection, and on where it is shown.

use crate::state::State;
use crate::state::ask::SelectAsk;

/// Applies an ask about the selection.
pub fn apply(state: &mut State, ask: SelectAsk) {
    match ask {
        SelectAsk::Only(selection) => state.select(selection),
        SelectAsk::Toggle(photo, layer) => state.toggle_layer(photo, layer),
        SelectAsk::Layers(photo, layers) => state.select_layers(photo, layers),
        SelectAsk::ShowInPhoto(photo, face, at) => state.show_in_photo(photo, face, at),
        SelectAsk::ShowRect(photo, rect) => state.show_rect(photo, rect),
        SelectAsk::StepPhoto(by) => state.step_photo(by),
    }
}
