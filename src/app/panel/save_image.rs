//! Draws the dialog that saves a photo as a layered depth image, or as a page that shows it.

use eframe::egui::{Button, Context, RichText, TextEdit, Ui, vec2};

use crate::state::request::{ImagesRequest, Request, RoundTripRequest};
use crate::state::round_trip::dialogs::DialogPurpose;
use crate::state::save_image::{ImageFormat, ImageSource, SaveImage};
use crate::widget::dialog::{Dialog, Keys};

/// The width of the path, in points.
const PATH: f32 = 290.0;

/// Draws the dialog while it is open. `open` holds what is typed; it is emptied when the dialog is left.
pub fn save_image_ui(
    context: &Context,
    has_project: bool,
    open: &mut Option<SaveImage>,
    requests: &mut Vec<Request>,
) {
    let Some(mut dialog) = open.take() else { return };
    if !has_project {
        return;
    }
    let answer =
        Dialog::new("save image", 460.0).show(context, |ui, keys| questions(ui, keys, &mut dialog, requests));
    match answer.inner {
        Some(true) => requests.push(ImagesRequest::Save(dialog).into()),
        Some(false) => (),
        None if answer.escaped => (),
        None => *open = Some(dialog),
    }
}

/// Draws the dialog; returns true to save, false to cancel.
fn questions(
    ui: &mut Ui,
    keys: &mut Keys,
    dialog: &mut SaveImage,
    requests: &mut Vec<Request>,
) -> Option<bool> {
    let (title, what, path, purpose) = match dialog.format {
        ImageFormat::Ldi => (
            "Export layered depth image",
            "A file that keeps all surfaces behind each pixel: for other programs, and for the commands “quadratura ldi”.",
            "File",
            DialogPurpose::ImageFile,
        ),
        ImageFormat::Page => (
            "Export page of the photo",
            "A folder with a page for browsers, in which one leans into the photo. It needs no network.",
            "Folder",
            DialogPurpose::PageFolder,
        ),
    };
    ui.label(RichText::new(title).heading());
    ui.label(RichText::new(&dialog.name).strong());
    ui.weak(what);
    ui.add_space(6.0);
    for source in ImageSource::ALL {
        ui.radio_value(&mut dialog.source, source, source.name());
    }
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        let label = ui.label(path);
        let line = ui.add(TextEdit::singleline(&mut dialog.path).desired_width(PATH));
        keys.begin_at(&line.labelled_by(label.id));
        if ui.button("Browse…").clicked() {
            requests.push(RoundTripRequest::ChoosePath(purpose).into());
        }
    });
    ui.weak("Relative to the project folder, unless it begins with /. Changed files are never overwritten.");
    if dialog.is_unfilled {
        let text = "Occluded areas of this photo are not filled: views from aside show holes. “Fill occluded areas” \
                    fills them.";
        ui.colored_label(ui.visuals().warn_fg_color, text);
    }
    let problem = dialog.problem();
    if let Some(problem) = problem {
        ui.colored_label(ui.visuals().warn_fg_color, problem);
    }
    ui.add_space(10.0);
    ui.horizontal(|ui| {
        let save = Button::new(RichText::new("Save").strong()).min_size(vec2(96.0, 28.0));
        if keys.press(&ui.add_enabled(problem.is_none(), save)) {
            return Some(true);
        }
        ui.add(Button::new("Cancel").min_size(vec2(96.0, 28.0))).clicked().then_some(false)
    })
    .inner
}
