//! Draws the dialog for typing the path of a project.

use eframe::egui::{Context, RichText};

use super::place::line;
use crate::state::opening::DialogRequest;
use crate::state::opening::place::typed_path;
use crate::widget::dialog::Dialog;

/// Draws the dialog for typing the path of a project, where there is no file dialog.
pub fn typing_ui(typed: &mut String, context: &Context, requests: &mut Vec<DialogRequest>) {
    let answer = Dialog::new("type a path", 520.0).show(context, |ui, keys| {
        ui.heading("Open a project");
        ui.label("This desktop has no folder dialog. Type the path of a project folder:");
        keys.begin_at(&line(ui, typed, "Folder of the project", 500.0));
        ui.add_space(6.0);
        ui.horizontal(|ui| {
            let path = typed_path(typed);
            let there = path.is_dir();
            let open = ui.add_enabled(there, eframe::egui::Button::new(RichText::new("Open").strong()));
            if keys.press(&open) {
                requests.extend([DialogRequest::Cancel, DialogRequest::Take(path)]);
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
