//! Draws the dialog for a picture of the view, or a video of the flight.

use eframe::egui::{Button, Context, DragValue, RichText, TextEdit, Ui, vec2};

use crate::state::flight::export::{Export, Rendering};
use crate::state::request::{FlightRequest, Request, RoundTripRequest};
use crate::state::round_trip::dialogs::DialogPurpose;
use crate::widget::dialog::{Dialog, Keys};
use quadratura_views::render::PictureFormat;

/// The width of the folder's path, in points.
const FOLDER: f32 = 280.0;

/// Draws the dialog while it is open. `open` holds what is typed; it is emptied when the dialog is left.
pub fn export_ui(context: &Context, open: &mut Option<Export>, requests: &mut Vec<Request>) {
    let Some(mut export) = open.take() else { return };
    let dialog = Dialog::new("export picture", 440.0);
    let asked = dialog.show(context, |ui, keys| questions(ui, keys, &mut export, requests));
    match asked.inner {
        Some(true) => requests.push(FlightRequest::Render(export).into()),
        Some(false) => (),
        None if asked.escaped => (),
        None => *open = Some(export),
    }
}

/// Draws the dialog; returns true to export, false to cancel.
fn questions(ui: &mut Ui, keys: &mut Keys, export: &mut Export, requests: &mut Vec<Request>) -> Option<bool> {
    let is_view = export.what == Rendering::Picture;
    ui.label(RichText::new(if is_view { "Render picture of the view" } else { "Render flight" }).heading());
    ui.add_space(6.0);
    if !is_view {
        kinds_ui(ui, export);
    }
    ui.horizontal(|ui| {
        let label = ui.label("Folder");
        let folder = TextEdit::singleline(&mut export.folder).desired_width(FOLDER);
        ui.add(folder).labelled_by(label.id);
        if ui.button("Browse…").clicked() {
            requests.push(RoundTripRequest::ChoosePath(DialogPurpose::RenderFolder).into());
        }
    });
    ui.weak("Relative to the project folder, unless it begins with /. Changed files are never overwritten.");
    let label = ui.label(match export.what {
        Rendering::Picture => "Picture name",
        Rendering::Video if export.has_ffmpeg => "Video file (.mp4, .webm, .gif, .webp or .apng)",
        Rendering::Video => "Video file (.apng)",
        Rendering::Sequence => "Name of the pictures and of their folder",
    });
    let name = ui.add(TextEdit::singleline(&mut export.name).desired_width(f32::INFINITY));
    keys.begin_at(&name.labelled_by(label.id));
    if export.what != Rendering::Video {
        formats_ui(ui, &mut export.format);
    }
    ui.horizontal(|ui| {
        ui.add(DragValue::new(&mut export.size[0]).range(16..=16_384).suffix(" px wide"));
        ui.add(DragValue::new(&mut export.size[1]).range(16..=16_384).suffix(" px high"));
    });
    let is_video = export.what == Rendering::Video && !export.name.to_lowercase().ends_with(".apng");
    if is_video && export.size.iter().any(|side| side % 2 == 1) {
        let [width, height] = export.size.map(|side| side & !1);
        ui.weak(format!("A video in this format has even sides: {width} × {height} px."));
    }
    let problem = export.problem();
    if let Some(problem) = &problem {
        ui.colored_label(ui.visuals().warn_fg_color, problem);
    }
    let is_there = !export.name.trim().is_empty() && export.file().exists();
    if is_there {
        let text = format!(
            "{} already exists. Files that have not changed since they were rendered are replaced; others are kept, and \
             the new ones get a number. Choose another name to keep both.",
            export.file().display()
        );
        ui.colored_label(ui.visuals().warn_fg_color, text);
    }
    ui.add_space(10.0);
    ui.horizontal(|ui| {
        let word = if is_there { "Render anyway" } else { "Render" };
        let make = Button::new(RichText::new(word).strong()).min_size(vec2(96.0, 28.0));
        let make = ui.add_enabled(problem.is_none(), make);
        // A key alone never replaces an existing file.
        let pressed = if is_there { make.clicked() } else { keys.press(&make) };
        if pressed {
            return Some(true);
        }
        ui.add(Button::new("Cancel").min_size(vec2(96.0, 28.0))).clicked().then_some(false)
    })
    .inner
}

/// Draws the choice between a video and a sequence, and says why there are no videos.
fn kinds_ui(ui: &mut Ui, export: &mut Export) {
    let mut what = export.what;
    ui.horizontal(|ui| {
        ui.radio_value(&mut what, Rendering::Video, "Video");
        ui.radio_value(&mut what, Rendering::Sequence, "Sequence of pictures");
    });
    if what != export.what {
        export.make(what);
    }
    if !export.has_ffmpeg {
        ui.weak(
            "ffmpeg is not installed: videos are animated PNG (.apng) only. Install ffmpeg for .mp4, .webm, .gif and .webp, \
             or render pictures and join them in another program.",
        );
    }
}

/// Draws the choice of the format of pictures.
fn formats_ui(ui: &mut Ui, format: &mut PictureFormat) {
    ui.horizontal(|ui| {
        for other in PictureFormat::ALL {
            let (name, tooltip) = match other {
                PictureFormat::Png => ("PNG", "sRGB, 8 bits a channel, with alpha."),
                PictureFormat::Png16 => ("PNG, 16 bits", "sRGB, 16 bits a channel, with alpha."),
                PictureFormat::Exr => (
                    "OpenEXR",
                    "For compositing: linear light as 16-bit floats, multiplied by alpha, and the depth Z along the \
                     camera's axis, in units of the world.",
                ),
            };
            ui.radio_value(format, other, name).on_hover_text(tooltip);
        }
    });
}
