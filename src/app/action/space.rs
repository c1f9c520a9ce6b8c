//! Actions of the 3D view: its viewpoint, and its display options.

use crate::app::state::State;
use crate::app::state::ask::SpaceAsk;
use crate::app::state::panes::Pane;

/// Applies an ask about the 3D view.
pub fn apply(state: &mut State, ask: SpaceAsk) {
    match ask {
        SpaceAsk::FlyToPhoto(photo) => {
            state.panes.show(Pane::Space);
            state.fly_to_photo(photo);
        }
        SpaceAsk::LookFrom(view) => state.look_from(&view),
        SpaceAsk::Frame => state.frame(),
        SpaceAsk::ShowAll => state.show_all(),
        SpaceAsk::Snap => {
            state.panes.show(Pane::Space);
            state.snap();
        }
        // The view never leaves the photo here: confirming a text field with a second Enter must not leave it.
        SpaceAsk::FlyInto => {
            state.panes.show(Pane::Space);
            if state.space.through() != state.selected_photo() {
                state.snap();
            }
        }
        SpaceAsk::Level => state.level(),
        SpaceAsk::Display(shown) => state.space.look.display = shown,
        SpaceAsk::PullApart => state.toggle_exploded(),
    }
}

impl State {
    /// Frames the selection in the view that is in use.
    pub fn frame(&mut self) {
        let framed = match self.panes.used() {
            Pane::Space => false,
            Pane::Photo => self.frame_in_photo(),
            Pane::Layer => {
                self.flat.layer.view.fit();
                true
            }
        };
        if !framed {
            self.frame_selection();
        }
    }

    /// Frames everything in the view that is in use.
    pub fn show_all(&mut self) {
        match self.panes.used() {
            Pane::Space => self.show_everything(),
            Pane::Photo => self.flat.photo.view.fit(),
            Pane::Layer => self.flat.layer.view.fit(),
        }
    }
}
