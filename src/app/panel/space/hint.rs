//! The hint with the first steps in the 3D view, and the way to the first painted layer, until the user closes it.

use eframe::egui::{Grid, RichText, TextStyle, Ui};

use super::view::SpacePaneView;
use crate::command::{Command, file, layers, paint};
use crate::panel::button;
use crate::panel::help::mouse;
use crate::state::first_steps::FirstStep;
use crate::state::request::Request;
use crate::widget::look::good;

/// The number of lines of the help that are shown.
const FIRST: usize = 5;
/// The view width below which only the next step is shown, in points.
const ROOM: f32 = 440.0;
/// The longest line, in points.
const WORDS: f32 = 360.0;

/// Returns whether the hint is on and there is a model to navigate.
pub fn is_wanted(view: &SpacePaneView<'_>) -> bool {
    view.hints && view.scene.space.has_picture()
}

/// Draws the hint.
pub fn hint_ui(ui: &mut Ui, view: &SpacePaneView<'_>, hints: &mut bool, requests: &mut Vec<Request>) {
    let room = ui.available_width();
    ui.set_max_width(room.min(WORDS));
    // The view is what one wants to see.
    ui.style_mut().override_text_style = Some(TextStyle::Small);
    ui.spacing_mut().item_spacing.y = 2.0;
    ui.strong("First steps")
        .on_hover_text("The view shows the photos projected onto the model, blended for your viewpoint.");
    if room >= ROOM {
        Grid::new("first steps").num_columns(2).min_row_height(0.0).show(ui, |ui| {
            for (keys, what) in &mouse(view.navigation)[..FIRST] {
                ui.strong(*keys);
                ui.label(*what);
                ui.end_row();
            }
        });
    }
    step_ui(ui, view, requests);
    ui.horizontal(|ui| {
        if ui.button("Got it").on_hover_text("Hides these hints permanently.").clicked() {
            *hints = false;
        }
        if ui.button("All keys").on_hover_text(file::KEYS.tooltip).clicked() {
            *hints = false;
            requests.push(view.commands.requested(&file::KEYS));
        }
    });
}

/// Draws the next step of the way to the first painted layer, with its button.
fn step_ui(ui: &mut Ui, view: &SpacePaneView<'_>, requests: &mut Vec<Request>) {
    let steps = FirstStep::ALL;
    let Some(next) = view.scene.session.next_first_step(view.is_painted) else {
        ui.label(RichText::new("Your first layer is painted.").color(good(ui.visuals())));
        return;
    };
    let number = steps.iter().position(|step| *step == next).map_or(1, |before| before + 1);
    let (text, command) = words(next);
    ui.horizontal_wrapped(|ui| {
        let line = format!("To your first painted layer, step {number} of {}: {text}", steps.len());
        ui.label(RichText::new(line).strong()).on_hover_ui(|ui| {
            for (number, step) in (1..).zip(steps) {
                let done = if view.scene.session.is_done(step, view.is_painted) { " – done" } else { "" };
                ui.label(format!("{number}. {}{done}", words(step).0));
            }
        });
        command.into_iter().for_each(|command| button(view.commands, ui, command, requests));
    });
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
