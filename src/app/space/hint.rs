//! What to do first in the 3D view, until somebody has seen it.

use eframe::egui::{Align2, Context, Frame, Grid, Id, Window};

use super::help::mouse;
use crate::app::command::file;
use crate::app::editor::{Ask, Editor};

/// Beside the photos and above the status line, where it hides least of the view.
const FROM_CORNER: [f32; 2] = [290.0, -44.0];
/// So many lines of the help are enough to begin.
const FIRST: usize = 5;

/// Draws it over the view when it is wanted and there is something to move through.
pub fn hint_ui(editor: &mut Editor, context: &Context, asks: &mut Vec<Ask>) {
    if !editor.settings.hints || !editor.space.has_picture() {
        return;
    }
    let frame = Frame::window(&context.global_style());
    let window = Window::new("First steps").id(Id::unique("first steps")).frame(frame).collapsible(false);
    window.resizable(false).anchor(Align2::LEFT_BOTTOM, FROM_CORNER).show(context, |ui| {
        ui.label("The view shows the photos on the model, mixed for wherever you look from.");
        ui.add_space(4.0);
        Grid::new("first steps").num_columns(2).striped(true).show(ui, |ui| {
            for (keys, what) in &mouse(editor.settings.navigation)[..FIRST] {
                ui.strong(*keys);
                ui.label(*what);
                ui.end_row();
            }
        });
        ui.add_space(6.0);
        ui.horizontal(|ui| {
            if ui.button("Got it").on_hover_text("Does not show this again.").clicked() {
                editor.settings.hints = false;
            }
            if ui.button("All keys").on_hover_text(file::KEYS.tooltip).clicked() {
                editor.settings.hints = false;
                asks.push(Ask::Run(&file::KEYS));
            }
        });
    });
}
