//! What is shown when no project is open: what to do next.

use eframe::egui::{Button, RichText, Spinner, Ui, vec2};

use crate::app::command::{Command, file, first_keys};
use crate::app::editor::{Ask, Editor};
use crate::app::jobs::Kind;

/// Draws it.
pub fn welcome_ui(editor: &Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    ui.vertical_centered(|ui| {
        ui.add_space(ui.available_height() * 0.16);
        ui.label(RichText::new("Quadratura").size(40.0).strong());
        ui.label(
            RichText::new("Photos of a site become layers to paint on, and a place to walk through.")
                .size(16.0),
        );
        ui.add_space(24.0);
        if editor.jobs.runs(Kind::Open) {
            ui.add(Spinner::new().size(32.0));
            ui.label("Opening…");
            return;
        }
        large(editor, ui, &file::OPEN, asks);
        ui.add_space(6.0);
        ui.weak("or drop the folder of a project on this window");
        recent(editor, ui, asks);
    });
}

fn large(editor: &Editor, ui: &mut Ui, command: &'static Command, asks: &mut Vec<Ask>) {
    let keys = first_keys(ui.ctx(), command);
    let button =
        Button::new(RichText::new(command.name).size(16.0)).shortcut_text(keys).min_size(vec2(300.0, 38.0));
    let ready = (command.ready)(editor).is_ok();
    if ui.add_enabled(ready, button).on_hover_text(command.tooltip).clicked() {
        asks.push(Ask::Run(command));
    }
}

fn recent(editor: &Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    if editor.settings.recent.is_empty() {
        return;
    }
    ui.add_space(22.0);
    ui.strong("Opened last");
    for project in &editor.settings.recent {
        let there = project.is_dir();
        let name = project.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let button = Button::new(name).frame(false).min_size(vec2(300.0, 22.0));
        let response = ui.add_enabled(there, button).on_hover_text(project.display().to_string());
        let gone = format!("{} is gone; a right click forgets it", project.display());
        let response = response.on_disabled_hover_text(gone);
        if response.clicked() {
            asks.push(Ask::Open(project.clone()));
        }
        response.context_menu(|ui| {
            if ui.button("Forget").clicked() {
                asks.push(Ask::Forget(project.clone()));
            }
        });
    }
}
