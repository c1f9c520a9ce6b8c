//! Actions on the selection, and on where it is shown.

use crate::state::State;
use crate::state::request::SelectRequest;

/// Applies a request about the selection.
pub fn apply(state: &mut State, request: SelectRequest) {
    match request {
        SelectRequest::Only(selection) => state.select(selection),
        SelectRequest::Toggle(photo, layer) => state.toggle_layer(photo, layer),
        SelectRequest::Layers(photo, layers) => state.select_layers(photo, layers),
        SelectRequest::ShowInPhoto(photo, face, at) => state.show_in_photo(photo, face, at),
        SelectRequest::ShowRect(photo, rect) => state.show_rect(photo, rect),
        SelectRequest::StepPhoto(by) => state.step_photo(by),
    }
}
