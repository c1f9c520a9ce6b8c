//! Draws the dialog that publishes the site as a web page.

use eframe::egui::{
    Button, ComboBox, Context, DragValue, Grid, Response, RichText, ScrollArea, TextEdit, Ui, vec2,
};

use crate::state::publish::{PublishDialog, SIDES, TypedText};
use crate::state::request::{PublishRequest, Request, RoundTripRequest};
use crate::state::round_trip::dialogs::DialogPurpose;
use crate::state::running::{JobKind, Running};
use crate::widget::dialog::{Dialog, Keys};
use crate::widget::spinner::Spinner;

/// The width of the dialog and of its fields, and the height of the list of photos, in points.
const WIDTH: f32 = 540.0;
const FIELD: f32 = 360.0;
const FOLDER: f32 = 270.0;
const PHOTOS: f32 = 110.0;

/// What a click in the dialog asks for.
enum PublishChoice {
    Close,
    Keep,
    Preview,
    Publish,
}

/// Draws the dialog while it is open. `open` holds what is typed; it is emptied when the dialog is left.
pub fn publish_ui(
    context: &Context,
    running: &Running,
    open: &mut Option<PublishDialog>,
    requests: &mut Vec<Request>,
) {
    let Some(mut dialog) = open.take() else { return };
    let runs = running.runs(JobKind::Export);
    let answer = Dialog::new("publish", WIDTH).show(context, |ui, keys| {
        ui.label(RichText::new("Publish as a web page").heading());
        ui.label(
            "One folder in which visitors walk through the site. It opens from disk and from any web server.",
        );
        said(ui, keys, &mut dialog);
        texts(ui, &mut dialog);
        photos(ui, &mut dialog);
        folder(ui, &mut dialog, requests);
        buttons(ui, keys, &dialog, runs, requests)
    });
    match answer.inner {
        Some(PublishChoice::Close) => return,
        _ if answer.escaped => return,
        Some(PublishChoice::Keep) => requests.push(PublishRequest::Keep(Box::new(dialog.clone())).into()),
        Some(PublishChoice::Preview) => {
            requests.push(PublishRequest::Preview(Box::new(dialog.clone())).into())
        }
        Some(PublishChoice::Publish) => {
            requests.push(PublishRequest::Publish(Box::new(dialog.clone())).into())
        }
        None => (),
    }
    *open = Some(dialog);
}

/// Title, credits, licence and start.
fn said(ui: &mut Ui, keys: &mut Keys, dialog: &mut PublishDialog) {
    Grid::new("said").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
        keys.begin_at(&row(ui, "Title", &mut dialog.title, "A photographed place"));
        let label = ui.label("Credits");
        let lines = TextEdit::multiline(&mut dialog.credits).desired_rows(2).desired_width(FIELD);
        ui.add(lines.hint_text("Photographers and others, one in each line")).labelled_by(label.id);
        ui.end_row();
        row(ui, "Licence of the photos", &mut dialog.licence, "CC-BY-4.0, or the address of a text");
        if !dialog.bookmarks.is_empty() {
            let label = ui.label("A visit starts at");
            bookmarks(ui, "start", &dialog.bookmarks, &mut dialog.viewpoint, "the first bookmark")
                .labelled_by(label.id);
            ui.end_row();
        }
    });
}

/// A line with a label.
fn row(ui: &mut Ui, name: &str, text: &mut String, hint: &str) -> Response {
    let label = ui.label(name);
    let field = ui.add(TextEdit::singleline(text).hint_text(hint).desired_width(FIELD)).labelled_by(label.id);
    ui.end_row();
    field
}

/// A choice of a bookmark; an empty one stands for `none`.
fn bookmarks(ui: &mut Ui, id: &str, names: &[String], chosen: &mut String, none: &str) -> Response {
    let shown = if chosen.is_empty() { none.to_owned() } else { chosen.clone() };
    let combo = ComboBox::from_id_salt(id).selected_text(shown).show_ui(ui, |ui| {
        ui.selectable_value(chosen, String::new(), none);
        for name in names {
            ui.selectable_value(chosen, name.clone(), name);
        }
    });
    combo.response
}

/// The texts: their titles, and the fields of one.
fn texts(ui: &mut Ui, dialog: &mut PublishDialog) {
    ui.separator();
    ui.horizontal_wrapped(|ui| {
        ui.label(RichText::new("Texts").strong());
        for (number, text) in dialog.texts.iter().enumerate() {
            let title = if text.title.trim().is_empty() { "(no title)" } else { text.title.trim() };
            let is_open = dialog.open_text == Some(number);
            if ui.selectable_label(is_open, format!("{}. {title}", number + 1)).clicked() {
                dialog.open_text = (!is_open).then_some(number);
            }
        }
        let add = ui.button("Add text").on_hover_text("Visitors open it by a numbered button at its place.");
        if add.clicked() {
            let at = dialog.measured.clone().unwrap_or_default();
            dialog.texts.push(TypedText { at, ..TypedText::default() });
            dialog.open_text = Some(dialog.texts.len() - 1);
        }
    });
    let Some(number) = dialog.open_text.filter(|number| *number < dialog.texts.len()) else { return };
    let (text, names) = (&mut dialog.texts[number], &dialog.bookmarks);
    Grid::new("text").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
        row(ui, "Title of the text", &mut text.title, "The fountain");
        let label = ui.label("Text");
        ui.add(TextEdit::multiline(&mut text.text).desired_rows(3).desired_width(FIELD))
            .labelled_by(label.id);
        ui.end_row();
        let place = row(ui, "Place", &mut text.at, "PHOTO:X,Y, OBJECT[FACE]:CORNER, or X,Y,Z");
        place.on_hover_text(
            "What a pixel of a photo shows, a corner of a face, or coordinates of the cameras' world.",
        );
        if let Some(measured) = &dialog.measured {
            ui.label("");
            let help = "The point at which the measuring tool was clicked last.";
            if ui.button("Use the measured point").on_hover_text(help).clicked() {
                text.at.clone_from(measured);
            }
            ui.end_row();
        }
        row(ui, "Link", &mut text.link, "https://…");
        if !names.is_empty() {
            let label = ui.label("Seen from");
            bookmarks(ui, "seen from", names, &mut text.view, "where the visitor is").labelled_by(label.id);
            ui.end_row();
        }
        row(ui, "Language", &mut text.language, "en");
    });
    if ui.button("Remove this text").clicked() {
        dialog.texts.remove(number);
        dialog.open_text = None;
    }
}

/// The photos that leave the house, with their sizes.
fn photos(ui: &mut Ui, dialog: &mut PublishDialog) {
    ui.separator();
    let count = dialog.chosen().count();
    ui.label(RichText::new(format!("{count} of {} photos are published", dialog.photos.len())).strong());
    ui.weak("All that a page shows can be copied. Masked pixels are not on it, nor is what cameras wrote into files.");
    ScrollArea::vertical().id_salt("published").max_height(PHOTOS).auto_shrink([false, true]).show(
        ui,
        |ui| {
            for number in 0..dialog.photos.len() {
                let photo = dialog.photos[number].clone();
                let [width, height] = dialog.published(photo.size);
                let mut on = !dialog.without.contains(&photo.id);
                if ui.checkbox(&mut on, format!("{}   {width} x {height}", photo.name)).changed() {
                    if on {
                        dialog.without.remove(&photo.id);
                    } else {
                        dialog.without.insert(photo.id);
                    }
                }
            }
        },
    );
    ui.horizontal(|ui| {
        let label = ui.label("Longest side");
        let shown = format!("{} pixels", dialog.longest);
        let combo = ComboBox::from_id_salt("longest").selected_text(shown).show_ui(ui, |ui| {
            for side in SIDES {
                ui.selectable_value(&mut dialog.longest, side, format!("{side} pixels"));
            }
        });
        combo.response.labelled_by(label.id);
        let label = ui.label("Quality");
        ui.add(DragValue::new(&mut dialog.quality).range(1..=100)).labelled_by(label.id);
        let label = ui.label("At most");
        let megabytes = DragValue::new(&mut dialog.budget).range(1..=100_000).suffix(" MB");
        ui.add(megabytes)
            .labelled_by(label.id)
            .on_hover_text("A larger page is written all the same, and said.");
    });
}

fn folder(ui: &mut Ui, dialog: &mut PublishDialog, requests: &mut Vec<Request>) {
    ui.separator();
    ui.horizontal(|ui| {
        let label = ui.label("Folder");
        ui.add(TextEdit::singleline(&mut dialog.folder).desired_width(FOLDER)).labelled_by(label.id);
        if ui.button("Browse…").clicked() {
            requests.push(RoundTripRequest::ChoosePath(DialogPurpose::PublishFolder).into());
        }
    });
    ui.weak("Relative to the project folder, unless it begins with /. A folder with other files is kept.");
}

/// Draws what there is to say, and the buttons.
fn buttons(
    ui: &mut Ui,
    keys: &mut Keys,
    dialog: &PublishDialog,
    runs: bool,
    requests: &mut Vec<Request>,
) -> Option<PublishChoice> {
    let missing = dialog.missing();
    if let Some(problem) = missing.or(dialog.problem.as_deref()) {
        ui.colored_label(ui.visuals().warn_fg_color, problem);
    }
    dialog.report.iter().for_each(|line| drop(ui.label(line)));
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        let size = vec2(96.0, 28.0);
        let publish = Button::new(RichText::new("Publish").strong()).min_size(size);
        let go = keys.press(&ui.add_enabled(missing.is_none() && !runs, publish));
        let preview = ui.add_enabled(missing.is_none() && !runs, Button::new("Preview").min_size(size));
        let preview = preview.on_hover_text("Makes the page with small photos, to be looked at in your browser. Nothing is kept in the project.");
        let keep = ui.add(Button::new("Keep texts").min_size(size));
        let keep = keep.on_hover_text(
            "Keeps title, credits, licence and texts in the project without writing the page.",
        );
        let close = ui.add(Button::new("Close").min_size(size)).clicked();
        if runs {
            ui.add(Spinner::new());
        }
        if let Some(done) = dialog.done.as_ref().filter(|_| !runs) {
            if ui.add(Button::new("Open page").min_size(size)).clicked() {
                requests.push(PublishRequest::Open(done.clone()).into());
            }
            if ui.add(Button::new("Show folder").min_size(size)).clicked() {
                requests.push(RoundTripRequest::ShowFolder(done.clone()).into());
            }
        }
        let choices = [
            (go, PublishChoice::Publish),
            (preview.clicked(), PublishChoice::Preview),
            (keep.clicked(), PublishChoice::Keep),
            (close, PublishChoice::Close),
        ];
        choices.into_iter().find_map(|(is_chosen, choice)| is_chosen.then_some(choice))
    })
    .inner
}
