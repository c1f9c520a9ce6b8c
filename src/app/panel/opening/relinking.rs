//! Draws the missing parts of a project.

use eframe::egui::{Button, Context, RichText, ScrollArea, Ui};

use super::place::{part_found, part_line, wrongs};
use super::view::OpeningView;
use crate::state::opening::relinking::Relinking;
use crate::state::opening::{DialogRequest, Purpose};
use crate::state::running::JobKind;
use crate::widget::dialog::{Dialog, Keys, scrolled};

/// Draws the dialog.
pub fn relinking_ui(
    view: &OpeningView<'_>,
    relinking: &mut Relinking,
    context: &Context,
    requests: &mut Vec<DialogRequest>,
) {
    // Escape first leaves the text field.
    let types = context.text_edit_focused();
    let answer = Dialog::new("relink", 680.0).show(context, |ui, keys| {
        scrolled(ui, |ui| match relinking.photos.is_empty() {
            true => parts_ui(view, relinking, ui, requests),
            false => photos_ui(view, relinking, ui, requests),
        });
        wrongs(ui, &relinking.errors);
        ui.add_space(8.0);
        buttons(view, relinking, ui, keys, requests);
    });
    if answer.escaped && !types {
        requests.push(DialogRequest::Cancel);
    }
}

fn parts_ui(
    view: &OpeningView<'_>,
    relinking: &mut Relinking,
    ui: &mut Ui,
    requests: &mut Vec<DialogRequest>,
) {
    ui.heading("Project files have moved");
    ui.label(format!(
        "{} is intact, but some of its source files are no longer where they were. Choose where they are now; \
         related files are detected automatically.",
        relinking.folder.display()
    ));
    asked_ui(view, relinking, ui, requests);
}

fn asked_ui(
    view: &OpeningView<'_>,
    relinking: &mut Relinking,
    ui: &mut Ui,
    requests: &mut Vec<DialogRequest>,
) {
    for part in relinking.asked.clone() {
        ui.add_space(6.0);
        let place = &mut relinking.places[part as usize];
        let before = place.typed.clone();
        part_line(ui, part, place, requests);
        if place.typed != before {
            relinking.settled(part);
        }
        let place = &relinking.places[part as usize];
        ui.indent(("was", part.name()), |ui| {
            ui.weak(format!("Previously {}", relinking.was.path(part).display()));
            if relinking.guessed.contains(&part) {
                ui.weak("Guessed: check that it is the right one.");
            }
        });
        part_found(ui, part, place, view.opening.looking.look.as_ref());
    }
}

fn photos_ui(
    view: &OpeningView<'_>,
    relinking: &mut Relinking,
    ui: &mut Ui,
    requests: &mut Vec<DialogRequest>,
) {
    ui.heading("Photos are missing");
    ui.label(
        "The cameras refer to these photos, but they are not in the folder of the photos. Everything else works \
         without them.",
    );
    ui.add_space(4.0);
    ScrollArea::vertical().max_height(180.0).show(ui, |ui| {
        for photo in &relinking.photos {
            ui.horizontal(|ui| {
                ui.label(photo);
                let button = ui.button("Choose file…").on_hover_text(format!(
                    "Chooses the file of {photo}, and copies it to the folder of the photos."
                ));
                if button.clicked() {
                    requests.push(DialogRequest::Choose(Purpose::Photo(photo.clone())));
                }
            });
        }
    });
    ui.label("If all photos are in another folder now, choose it:");
    asked_ui(view, relinking, ui, requests);
}

fn buttons(
    view: &OpeningView<'_>,
    relinking: &Relinking,
    ui: &mut Ui,
    keys: &mut Keys,
    requests: &mut Vec<DialogRequest>,
) {
    ui.horizontal(|ui| {
        let whole = view.opening.looking.now().is_some_and(|look| look.is_whole());
        let moved = relinking.parts() != relinking.was;
        let button =
            Button::new(RichText::new("Use these locations").strong()).min_size([150.0, 30.0].into());
        let response = ui.add_enabled(whole && moved && !view.running.runs(JobKind::Open), button);
        let response = response.on_hover_text("Saves these locations in the project, and opens it.");
        let response =
            response.on_disabled_hover_text("A part is still missing, or no location has changed.");
        if keys.press(&response) {
            requests.push(DialogRequest::Relink);
        }
        let again = Button::new("Try again").min_size([90.0, 30.0].into());
        if ui.add(again).on_hover_text("Opens the project again, if the files are back.").clicked() {
            requests.push(DialogRequest::TryAgain(relinking.folder.clone()));
        }
        if ui.add(Button::new("Cancel").min_size([80.0, 30.0].into())).clicked() {
            requests.push(DialogRequest::Cancel);
        }
    });
}
