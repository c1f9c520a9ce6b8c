//! The row above the photo: how many layers are taken off, what is drawn, how large.

use eframe::egui::{Button, RichText, Slider, Spinner, Ui};

use super::drawing::colour_of_depth;
use crate::app::command::flat;
use crate::app::editor::{Ask, Editor};
use crate::app::panel::{button_ui, toggle_ui};

/// Draws it.
pub fn tools_ui(editor: &mut Editor, ui: &mut Ui, photo: usize, asks: &mut Vec<Ask>) {
    let Some(session) = &editor.session else { return };
    let name = session.opened.site.photos[photo].name.clone();
    let stack = session.photos[photo].stack.clone();
    let depth = stack.as_ref().map_or(0, |stack| stack.visibility_layers.len() as u32);
    ui.horizontal_wrapped(|ui| {
        ui.label(RichText::new(name).strong());
        ui.separator();
        ui.add_enabled_ui(depth > 0, |ui| {
            let slider = Slider::new(&mut editor.flat.photo.taken_off, 0..=depth).text("layers taken off");
            let slider = slider.custom_formatter(move |value, _| format!("{value:.0} of {depth}"));
            ui.add(slider).on_hover_text(
                "Takes visibility layers off, from the front: what the layers behind have is seen then.",
            );
        });
        ui.separator();
        for command in [&flat::OUTLINES, &flat::HATCHING, &flat::RECTANGLES, &flat::FILLING, &flat::PAINT] {
            toggle_ui(editor, ui, command, asks);
        }
        ui.separator();
        let untextured = stack.as_ref().map_or(0, |stack| stack.untextured.len());
        let text = format!("{} ({untextured})", flat::UNTEXTURED.name);
        let list = ui.selectable_label(editor.flat.photo.reasons_shown, text);
        if list.on_hover_text(flat::UNTEXTURED.tooltip).clicked() {
            asks.push(Ask::Run(&flat::UNTEXTURED));
        }
        ui.separator();
        scale_ui(ui, editor.flat.photo.placement.magnification(ui.ctx().pixels_per_point()), asks);
        if editor.flat.photo.loading.is_busy() {
            ui.add(Spinner::new().size(14.0));
        }
    });
    if depth > 1 && editor.flat.switches.outlines {
        legend(editor, ui, depth);
    }
}

/// Fit, 1:1, and how large pixels are.
pub fn scale_ui(ui: &mut Ui, magnification: f64, asks: &mut Vec<Ask>) {
    for (command, text) in [(&flat::FIT, "Fit"), (&flat::PIXELS, "1:1")] {
        if button_ui(ui, command, Button::new(text).small()) {
            asks.push(Ask::Run(command));
        }
    }
    ui.monospace(format!("{:.0} %", 100.0 * magnification));
}

/// What the colours of outlines mean.
fn legend(editor: &Editor, ui: &mut Ui, depth: u32) {
    ui.horizontal_wrapped(|ui| {
        ui.weak("Outlines, from the front:");
        for layer in 0..depth {
            let gone = layer < editor.flat.photo.taken_off;
            let text = RichText::new(format!("{}", layer + 1)).color(colour_of_depth(layer)).strong();
            ui.label(if gone { text.strikethrough().weak() } else { text });
        }
    });
}
