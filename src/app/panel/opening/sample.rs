//! Draws the dialog of the sample project.

use eframe::egui::{Button, Context, RichText};

use super::place::{line, wrongs};
use super::view::OpeningView;
use crate::state::opening::place::PathField;
use crate::state::opening::{DialogRequest, Purpose};
use crate::state::running::JobKind;
use crate::widget::dialog::Dialog;
use crate::widget::spinner::Spinner;

/// Draws the dialog that asks for the folder of the sample project.
pub fn sample_ui(
    view: &OpeningView<'_>,
    field: &mut PathField,
    context: &Context,
    requests: &mut Vec<DialogRequest>,
) {
    let writes = view.running.runs(JobKind::Open);
    let answer = Dialog::new("sample project", 560.0).show(context, |ui, keys| {
        ui.heading("Open sample project");
        ui.label(
            "A small invented square with a church, nine photos and a coarse model, to try everything with. It is \
             copied to this folder; what you do there changes only the copy.",
        );
        ui.add_space(6.0);
        ui.horizontal(|ui| {
            let typed = line(ui, &mut field.typed, "Folder of the sample project", 460.0);
            keys.begin_at(&typed);
            if typed.changed() {
                field.errors.clear();
            }
            if ui.button("Browse…").on_hover_text("Chooses a folder for the sample project.").clicked() {
                requests.push(DialogRequest::Choose(Purpose::Sample));
            }
        });
        wrongs(ui, &field.errors);
        ui.add_space(6.0);
        ui.horizontal(|ui| {
            let is_named = !field.typed.trim().is_empty();
            let open =
                ui.add_enabled(is_named && !writes, Button::new(RichText::new("Copy and open").strong()));
            if keys.press(&open) {
                requests.push(DialogRequest::OpenSample);
            }
            if ui.button("Cancel").clicked() {
                requests.push(DialogRequest::Cancel);
            }
            if writes {
                ui.add(Spinner::new().size(16.0));
            }
        });
    });
    if answer.escaped && !writes {
        requests.push(DialogRequest::Cancel);
    }
}
