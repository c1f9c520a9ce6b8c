//! Draws the dialog for a copy of the open project.

use eframe::egui::{Button, Context, RichText};

use super::place::{line, wrongs};
use super::view::OpeningView;
use crate::command::file::SAVE_COPY;
use crate::state::opening::place::PathField;
use crate::state::opening::{DialogRequest, Purpose};
use crate::widget::dialog::Dialog;

/// Draws the dialog that asks for the folder of a copy.
pub fn copy_ui(
    view: &OpeningView<'_>,
    field: &mut PathField,
    context: &Context,
    requests: &mut Vec<DialogRequest>,
) {
    let answer = Dialog::new("copy of the project", 560.0).show(context, |ui, keys| {
        ui.heading("Save a copy");
        ui.label(
            "Decisions, saved or not, masks, paint, layers and exports are copied to this folder. Photos, cameras and model \
             outside of the project folder are not: the copy uses the same files. This project stays open.",
        );
        ui.add_space(6.0);
        ui.horizontal(|ui| {
            let typed = line(ui, &mut field.typed, "Folder of the copy", 460.0);
            keys.begin_at(&typed);
            if typed.changed() {
                field.errors.clear();
            }
            if ui.button("Browse…").on_hover_text("Chooses a folder for the copy.").clicked() {
                requests.push(DialogRequest::Choose(Purpose::Copy));
            }
        });
        wrongs(ui, &field.errors);
        ui.add_space(6.0);
        ui.horizontal(|ui| {
            let is_named = !field.typed.trim().is_empty();
            // A job may have begun since the dialog was opened.
            let ready = view.commands.ready(&SAVE_COPY);
            let button = Button::new(RichText::new("Save copy").strong());
            let save = ui.add_enabled(is_named && ready.is_ok(), button);
            let why = ready.err().unwrap_or("type the folder of the copy");
            let save = save.on_disabled_hover_text(format!("Not available: {why}."));
            if keys.press(&save) {
                requests.push(DialogRequest::SaveCopy);
            }
            if ui.button("Cancel").clicked() {
                requests.push(DialogRequest::Cancel);
            }
        });
    });
    if answer.escaped {
        requests.push(DialogRequest::Cancel);
    }
}
