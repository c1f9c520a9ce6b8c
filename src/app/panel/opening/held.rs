//! Draws the dialog of a project that is open elsewhere.

use eframe::egui::Context;

use super::view::OpeningView;
use crate::state::opening::DialogRequest;
use crate::widget::dialog::Dialog;
use crate::widget::spinner::Spinner;
use quadratura_files::lock::holder_message;

/// Draws the dialog.
pub fn held_ui(view: &OpeningView<'_>, context: &Context, requests: &mut Vec<DialogRequest>) {
    let Some(held) = &view.opening.held else { return };
    let answer = Dialog::new("held", 460.0).show(context, |ui, keys| {
        ui.heading("Project is already open");
        ui.label(format!("{}: {}.", held.folder.display(), holder_message(&held.holder)));
        ui.horizontal(|ui| {
            ui.add(Spinner::new().size(16.0));
            ui.label("It opens here automatically as soon as it is free.");
        });
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            if keys.press_first(&ui.button("Try again")) {
                requests.push(DialogRequest::TryAgain(held.folder.clone()));
            }
            if ui.button("Do not open").clicked() {
                requests.push(DialogRequest::Cancel);
            }
        });
    });
    if answer.is_left() {
        requests.push(DialogRequest::Cancel);
    }
}
