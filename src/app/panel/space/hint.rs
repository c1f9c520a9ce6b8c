//! The hint with the first steps in the 3D view, until the user closes it.

use eframe::egui::{Grid, Ui};

use crate::app::command::file;
use crate::app::panel::help::mouse;
use crate::app::state::State;
use crate::app::state::ask::Ask;

/// The number of lines of the help that are shown.
const FIRST: usize = 5;
/// The view width below which only the first words are shown, in points.
const ROOM: f32 = 440.0;
/// The longest line, in points.
const WORDS: f32 = 460.0;

/// Returns whether the hint is on and there is a model to navigate.
pub fn is_wanted(state: &State) -> bool {
    state.settings.hints && state.space.has_picture()
}

/// Draws the hint.
pub fn hint_ui(ui: &mut Ui, state: &State, hints: &mut bool, asks: &mut Vec<Ask>) {
    let room = ui.available_width();
    ui.set_max_width(room.min(WORDS));
    ui.strong("First steps");
    ui.label("The view shows the photos projected onto the model, blended for your viewpoint.");
    if room >= ROOM {
        ui.add_space(4.0);
        Grid::new("first steps").num_columns(2).striped(true).show(ui, |ui| {
            for (keys, what) in &mouse(state.settings.navigation)[..FIRST] {
                ui.strong(*keys);
                ui.label(*what);
                ui.end_row();
            }
        });
    }
    ui.add_space(6.0);
    ui.horizontal(|ui| {
        if ui.button("Got it").on_hover_text("Hides these hints permanently.").clicked() {
            *hints = false;
        }
        if ui.button("All keys").on_hover_text(file::KEYS.tooltip).clicked() {
            *hints = false;
            asks.push(file::KEYS.asked(state));
        }
    });
}
