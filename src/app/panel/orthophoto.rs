//! Draws the dialog for orthophotos.

use std::sync::Arc;

use eframe::egui::{
    Button, ColorImage, Context, Grid, RichText, TextEdit, TextureHandle, TextureOptions, Ui, vec2,
};

use crate::state::orthophoto::OrthophotoDialog;
use crate::state::request::{OrthoRequest, Request, RoundTripRequest};
use crate::state::round_trip::dialogs::DialogPurpose;
use crate::state::running::{JobKind, Running};
use crate::widget::dialog::{Dialog, Keys};
use crate::widget::spinner::Spinner;
use quadratura_view::Picture;
use quadratura_views::ortho::OrthoFormat;

/// The width of the dialog, of its fields and the largest side of the preview, in points.
const WIDTH: f32 = 480.0;
const NUMBER: f32 = 72.0;
const FOLDER: f32 = 250.0;
const PREVIEW: f32 = 300.0;

/// The texture of the preview.
#[derive(Default)]
pub struct OrthoTexture(Option<(Arc<Picture>, TextureHandle)>);

/// What a click in the dialog asks for.
enum Answered {
    Cancel,
    Preview,
    Draw,
}

/// Draws the dialog while it is open. `open` holds what is typed; it is emptied when the dialog is left.
pub fn orthophoto_ui(
    context: &Context,
    running: &Running,
    open: &mut Option<OrthophotoDialog>,
    texture: &mut OrthoTexture,
    requests: &mut Vec<Request>,
) {
    let Some(mut dialog) = open.take() else {
        texture.0 = None;
        return;
    };
    let runs = running.runs(JobKind::Export);
    let answer = Dialog::new("orthophoto", WIDTH).show(context, |ui, keys| {
        questions(ui, keys, &mut dialog, requests);
        texture.show(ui, dialog.preview.as_ref());
        buttons(ui, keys, &dialog, runs, requests)
    });
    match answer.inner {
        Some(Answered::Cancel) => return,
        _ if answer.escaped => return,
        Some(Answered::Preview) => requests.push(OrthoRequest::Preview(Box::new(dialog.clone())).into()),
        Some(Answered::Draw) => requests.push(OrthoRequest::Draw(Box::new(dialog.clone())).into()),
        None => (),
    }
    *open = Some(dialog);
}

fn questions(ui: &mut Ui, keys: &mut Keys, dialog: &mut OrthophotoDialog, requests: &mut Vec<Request>) {
    ui.label(RichText::new("Orthophoto").heading());
    ui.label(RichText::new(dialog.selected.as_deref().unwrap_or("The whole site")).strong());
    if dialog.selected.is_some() {
        ui.horizontal(|ui| {
            ui.radio_value(&mut dialog.is_plan, false, "From straight in front");
            ui.radio_value(&mut dialog.is_plan, true, "From above");
        });
    } else {
        ui.weak("From above. Select a face or an object for a facade.");
    }
    Grid::new("orthophoto").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
        let label = ui.label("Scale 1:");
        ui.horizontal(|ui| {
            let field = ui.add(TextEdit::singleline(&mut dialog.scale).desired_width(NUMBER));
            keys.begin_at(&field.labelled_by(label.id));
            let label = ui.label("at");
            ui.add(TextEdit::singleline(&mut dialog.dpi).desired_width(NUMBER)).labelled_by(label.id);
            ui.label("pixels per inch");
        });
        ui.end_row();
        let label = ui.label("Depth in front");
        ui.horizontal(|ui| {
            let field = TextEdit::singleline(&mut dialog.depth).desired_width(NUMBER);
            let hint = if dialog.is_plan { "all" } else { "1" };
            ui.add(field.hint_text(hint)).labelled_by(label.id);
            ui.label("m; what stands farther in front is left out");
        });
        ui.end_row();
        ui.label("Formats");
        ui.horizontal(|ui| {
            for (format, name) in
                [(OrthoFormat::Tiff, "TIFF"), (OrthoFormat::Png, "PNG"), (OrthoFormat::Pdf, "PDF page")]
            {
                let mut on = dialog.formats.contains(&format);
                if ui.checkbox(&mut on, name).changed() {
                    let chosen = |other: &OrthoFormat| {
                        if *other == format { on } else { dialog.formats.contains(other) }
                    };
                    dialog.formats = OrthoFormat::ALL.into_iter().filter(chosen).collect();
                }
            }
        });
        ui.end_row();
        let label = ui.label("Folder");
        ui.horizontal(|ui| {
            ui.add(TextEdit::singleline(&mut dialog.folder).desired_width(FOLDER)).labelled_by(label.id);
            if ui.button("Browse…").clicked() {
                requests.push(RoundTripRequest::ChoosePath(DialogPurpose::OrthoFolder).into());
            }
        });
        ui.end_row();
    });
    let help = "Otherwise surfaces continue where no photo shows them.";
    ui.checkbox(&mut dialog.holes, "Leave empty what no photo shows").on_hover_text(help);
}

impl OrthoTexture {
    fn show(&mut self, ui: &mut Ui, preview: Option<&Arc<Picture>>) {
        let Some(picture) = preview else {
            self.0 = None;
            return;
        };
        if !self.0.as_ref().is_some_and(|(known, _)| Arc::ptr_eq(known, picture)) {
            let size = [picture.width as usize, picture.height as usize];
            let image = ColorImage::from_rgba_unmultiplied(size, &picture.rgba);
            let texture = ui.ctx().load_texture("orthophoto", image, TextureOptions::LINEAR);
            self.0 = Some((picture.clone(), texture));
        }
        if let Some((_, texture)) = &self.0 {
            let size = texture.size_vec2();
            let by = (PREVIEW / size.max_elem()).min(1.0);
            ui.vertical_centered(|ui| ui.image((texture.id(), size * by)));
        }
    }
}

fn buttons(
    ui: &mut Ui,
    keys: &mut Keys,
    dialog: &OrthophotoDialog,
    runs: bool,
    requests: &mut Vec<Request>,
) -> Option<Answered> {
    for line in &dialog.report {
        ui.label(line);
    }
    let problem = dialog.problem();
    if let Some(problem) = &problem {
        ui.colored_label(ui.visuals().warn_fg_color, problem);
    }
    ui.add_space(8.0);
    let is_ready = problem.is_none() && !runs;
    ui.horizontal(|ui| {
        let size = vec2(96.0, 28.0);
        let draw = Button::new(RichText::new("Draw").strong()).min_size(size);
        if keys.press(&ui.add_enabled(is_ready, draw)) {
            return Some(Answered::Draw);
        }
        if ui.add_enabled(is_ready, Button::new("Preview").min_size(size)).clicked() {
            return Some(Answered::Preview);
        }
        let leave = if dialog.done.is_some() { "Close" } else { "Cancel" };
        if ui.add(Button::new(leave).min_size(size)).clicked() {
            return Some(Answered::Cancel);
        }
        if runs {
            ui.add(Spinner::new());
        }
        if let Some(done) = &dialog.done
            && ui.button("Open folder").on_hover_text(done.display().to_string()).clicked()
        {
            requests.push(RoundTripRequest::ShowFolder(done.clone()).into());
        }
        None
    })
    .inner
}
