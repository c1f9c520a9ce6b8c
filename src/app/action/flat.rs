//! Actions of the flat views: zoom, and the number of visibility layers that are hidden.

use crate::app::flat::PlacedView;
use crate::app::state::State;
use crate::app::state::ask::FlatAsk;
use crate::app::state::panes::Pane;
use crate::app::work::Work;

/// Applies an ask about the flat views.
pub fn apply(state: &mut State, work: &mut Work, ask: FlatAsk) {
    match ask {
        FlatAsk::Fit => state.flat_view().fit(),
        FlatAsk::ShowPixels => {
            let density = state.window.density;
            state.flat_view().show_pixels(density);
        }
        FlatAsk::Zoom(factor) => state.flat_view().zoom(factor),
        FlatAsk::Peel(by) => state.peel(by),
        FlatAsk::ListUntextured => {
            state.flat.photo.reasons_shown ^= true;
            if state.flat.photo.reasons_shown {
                state.panes.show(Pane::Photo);
            }
        }
        FlatAsk::WantLargePicture(photo) => want_large_picture(state, work, photo),
    }
}

fn want_large_picture(state: &mut State, work: &mut Work, photo: usize) {
    let Some(session) = &state.session else { return };
    work.pictures.want_large(photo, &session.opened, &mut work.jobs, &mut state.running);
}

impl State {
    /// Returns the flat view in use; the photo's where the 3D view is.
    fn flat_view(&mut self) -> &mut PlacedView {
        match self.panes.used() {
            Pane::Layer => &mut self.flat.layer.view,
            Pane::Space | Pane::Photo => &mut self.flat.photo.view,
        }
    }

    /// Hides `by` more visibility layers of the photo; negative numbers show them again.
    fn peel(&mut self, by: i32) {
        let depth = self.selected_stack().map_or(0, |stack| stack.visibility_layers.len() as u32);
        let hidden_layers = &mut self.flat.photo.hidden_layers;
        *hidden_layers = hidden_layers.saturating_add_signed(by).min(depth);
        self.panes.show(Pane::Photo);
    }
}
