//! The hint with the first steps in the 3D view, and the way to the first painted layer, until the user closes it.

use eframe::egui::{Grid, RichText, Ui};

use crate::app::command::{Command, file, layers, paint};
use crate::app::panel::button;
use crate::app::panel::help::mouse;
use crate::app::state::State;
use crate::app::state::ask::Ask;
use crate::app::state::first_steps::FirstStep;
use crate::app::widget::look::good;

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
    steps_ui(ui, state, asks);
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

/// Draws the way to the first painted layer: what is done, and the next step with its button.
fn steps_ui(ui: &mut Ui, state: &State, asks: &mut Vec<Ask>) {
    let next = state.next_first_step();
    ui.add_space(6.0);
    ui.strong("To your first painted layer");
    for (number, step) in (1..).zip(FirstStep::ALL) {
        let (text, command) = words(step);
        let line = format!("{number}. {text}");
        if state.is_done(step) {
            ui.label(RichText::new(format!("{line} – done")).color(good(ui.visuals())));
            continue;
        }
        ui.horizontal_wrapped(|ui| {
            ui.label(if next == Some(step) {
                RichText::new(line).strong()
            } else {
                RichText::new(line).weak()
            });
            if let Some(command) = command.filter(|_| next == Some(step)) {
                button(state, ui, command, asks);
            }
        });
    }
}

/// Returns what a step is called, and the command that does it.
fn words(step: FirstStep) -> (&'static str, Option<&'static Command>) {
    match step {
        FirstStep::Build => ("Build the layers of the photos", Some(&layers::BUILD)),
        FirstStep::Fill => ("Fill what the photos do not show", Some(&layers::FILL)),
        FirstStep::Edit => ("Open a photo's layers in the image editor", Some(&paint::EDIT)),
        FirstStep::Save => ("Paint on a layer and save there: the view shows the paint", None),
    }
}
