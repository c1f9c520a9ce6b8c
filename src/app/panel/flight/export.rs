//! Draws the dialog for a picture of the view, or a video of the flight.

use eframe::egui::{Button, Context, DragValue, RichText, TextEdit, Ui, vec2};

use crate::app::state::ask::{Ask, FlightAsk, RoundTripAsk};
use crate::app::state::flight::export::Export;
use crate::app::state::round_trip::dialogs::DialogPurpose;
use crate::app::widget::dialog::{Dialog, Keys};

/// The width of the folder's path, in points.
const FOLDER: f32 = 280.0;

/// Draws the dialog while it is open. `open` holds what is typed; it is emptied when the dialog is left.
pub fn export_ui(context: &Context, open: &mut Option<Export>, asks: &mut Vec<Ask>) {
    let Some(mut export) = open.take() else { return };
    let dialog = Dialog::new("export picture", 440.0);
    let asked = dialog.show(context, |ui, keys| questions(ui, keys, &mut export, asks));
    match asked.inner {
        Some(true) => asks.push(FlightAsk::Render(export).into()),
        Some(false) => (),
        None if asked.escaped => (),
        None => *open = Some(export),
    }
}

/// Draws the dialog; returns true to export, false to cancel.
fn questions(ui: &mut Ui, keys: &mut Keys, export: &mut Export, asks: &mut Vec<Ask>) -> Option<bool> {
    let title = if export.film { "Render video of the flight" } else { "Render picture of the view" };
    ui.label(RichText::new(title).heading());
    ui.add_space(6.0);
    ui.horizontal(|ui| {
        let label = ui.label("Folder");
        let folder = TextEdit::singleline(&mut export.folder).desired_width(FOLDER);
        ui.add(folder).labelled_by(label.id);
        if ui.button("Choose…").clicked() {
            asks.push(RoundTripAsk::ChoosePath(DialogPurpose::RenderFolder).into());
        }
    });
    ui.weak("Relative to the project folder, unless it begins with /. Changed files are never overwritten.");
    let label =
        ui.label(if export.film { "Video file (.apng, .mp4, .webm, .gif or .webp)" } else { "Picture name" });
    let name = ui.add(TextEdit::singleline(&mut export.name).desired_width(f32::INFINITY));
    keys.begin_at(&name.labelled_by(label.id));
    ui.horizontal(|ui| {
        ui.add(DragValue::new(&mut export.size[0]).range(16..=16_384).suffix(" px wide"));
        ui.add(DragValue::new(&mut export.size[1]).range(16..=16_384).suffix(" px high"));
    });
    let is_video = export.film && !export.name.to_lowercase().ends_with(".apng");
    if is_video && export.size.iter().any(|side| side % 2 == 1) {
        let [width, height] = export.size.map(|side| side & !1);
        ui.weak(format!("A video in this format has even sides: {width} × {height} px."));
    }
    let is_there = !export.name.trim().is_empty() && export.file().exists();
    if is_there {
        let text = format!(
            "{} already exists. If it has not changed since it was rendered, it is replaced; otherwise it is kept, \
             and the new file gets a number. Choose another name to keep both.",
            export.file().display()
        );
        ui.colored_label(ui.visuals().warn_fg_color, text);
    }
    ui.add_space(10.0);
    ui.horizontal(|ui| {
        let ready = !export.folder.trim().is_empty() && !export.name.trim().is_empty();
        let word = if is_there { "Render anyway" } else { "Render" };
        let make = Button::new(RichText::new(word).strong()).min_size(vec2(96.0, 28.0));
        let make = ui.add_enabled(ready, make);
        // A key alone never replaces an existing file.
        let pressed = if is_there { make.clicked() } else { keys.press(&make) };
        if pressed {
            return Some(true);
        }
        ui.add(Button::new("Cancel").min_size(vec2(96.0, 28.0))).clicked().then_some(false)
    })
    .inner
}
