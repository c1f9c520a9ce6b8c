//! Draws the dialog for the site's frame.

use eframe::egui::{Button, ComboBox, Context, Grid, Label, RichText, TextEdit, Ui, vec2};

use crate::state::request::{OrthoRequest, Request};
use crate::state::site_frame::{LevelChoice, ScaleChoice, SiteFrameDialog, UNITS};
use crate::widget::dialog::{Dialog, Keys};
use quadratura_document::frame::FramePart;

/// The width of the dialog and of its fields, in points.
const WIDTH: f32 = 560.0;
const POINT: f32 = 180.0;
const NUMBER: f32 = 84.0;
const TITLE: f32 = 52.0;

/// How points are written.
const POINTS: &str = "A point is OBJECT[FACE]:CORNER, PHOTO:X,Y for what a pixel shows of the model, point:PHOTO:X,Y for a sparse point, or \
                      X,Y,Z in the cameras' world.";

/// Draws the dialog while it is open. `open` holds what is typed; it is emptied when the dialog is left.
pub fn site_frame_ui(context: &Context, open: &mut Option<SiteFrameDialog>, requests: &mut Vec<Request>) {
    let Some(mut dialog) = open.take() else { return };
    let answer = Dialog::new("site frame", WIDTH).show(context, |ui, keys| {
        ui.label(RichText::new("Site frame").heading());
        ui.label("Makes the site level, metric and oriented. Exports, measurements and orthophotos use it.");
        known(ui, &dialog, requests);
        ui.separator();
        questions(ui, keys, &mut dialog);
        ui.weak(POINTS);
        buttons(ui, keys, &mut dialog, requests)
    });
    if !(answer.inner || answer.escaped) {
        *open = Some(dialog);
    }
}

/// Draws what is known, each part with a button that forgets it.
fn known(ui: &mut Ui, dialog: &SiteFrameDialog, requests: &mut Vec<Request>) {
    for (part, what) in &dialog.known {
        ui.horizontal(|ui| {
            ui.add_sized([TITLE, ui.spacing().interact_size.y], Label::new(title(*part)));
            let forget = ui.add_enabled(what.is_some(), Button::new("Forget").small());
            if forget.on_hover_text(format!("Forgets: {}", title(*part))).clicked() {
                requests.push(OrthoRequest::ForgetFrame(*part).into());
            }
            match what {
                // One line, all of it as a tooltip.
                Some(what) => ui.add(Label::new(what).truncate()),
                None => ui.weak("not set"),
            };
        });
    }
}

fn title(part: FramePart) -> &'static str {
    match part {
        FramePart::Level => "Up",
        FramePart::Scale => "Scale",
        FramePart::North => "North",
        FramePart::Origin => "Origin",
        FramePart::Crs => "Map",
    }
}

fn questions(ui: &mut Ui, keys: &mut Keys, dialog: &mut SiteFrameDialog) {
    Grid::new("new frame").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
        let label = ui.label("Level by");
        level(ui, dialog, label.id);
        ui.end_row();
        let label = ui.label("Scale by");
        scale(ui, dialog, label.id);
        ui.end_row();
        if dialog.scale == ScaleChoice::Length {
            ui.label("");
            ui.horizontal(|ui| {
                let [a, b, metres] = &mut dialog.length;
                keys.begin_at(&field(ui, a, "from A", POINT));
                field(ui, b, "to B", POINT);
                field(ui, metres, "m", NUMBER);
            });
            ui.end_row();
            if let Some(measured) = &dialog.measured {
                ui.label("");
                if ui.button("Use the measured points").clicked() {
                    let [a, b] = measured.clone();
                    (dialog.length[0], dialog.length[1]) = (a, b);
                }
                ui.end_row();
            }
        }
        ui.label("North");
        ui.horizontal(|ui| {
            let [a, b, degrees] = &mut dialog.north;
            field(ui, a, "north is from A", POINT);
            field(ui, b, "to B", POINT);
            field(ui, degrees, "or degrees", NUMBER).on_hover_text(
                "The direction from A to B is so many degrees from north, clockwise seen from above",
            );
        });
        ui.end_row();
        ui.label("Origin");
        field(ui, &mut dialog.origin, "the point that is 0, 0, 0", POINT);
        ui.end_row();
        ui.label("Map");
        ui.horizontal(|ui| {
            for (text, hint) in dialog.map.iter_mut().zip(["EPSG number", "east", "north", "height"]) {
                field(ui, text, hint, NUMBER);
            }
        });
        ui.end_row();
    });
}

fn level(ui: &mut Ui, dialog: &mut SiteFrameDialog, label: eframe::egui::Id) {
    let selected = dialog.selected.as_deref().map(|name| format!("the selection, {name}"));
    let name = |choice: LevelChoice| match choice {
        LevelChoice::Keep => "as it is".to_owned(),
        LevelChoice::Verticals => "the model's upright edges".into(),
        LevelChoice::Cameras => "the cameras".into(),
        LevelChoice::Selected => selected.clone().unwrap_or_else(|| "the selection".into()),
    };
    let mut choices = vec![LevelChoice::Keep, LevelChoice::Verticals, LevelChoice::Cameras];
    choices.extend(dialog.selected.as_ref().map(|_| LevelChoice::Selected));
    let shown = ComboBox::from_id_salt("level").selected_text(name(dialog.level)).show_ui(ui, |ui| {
        for choice in choices {
            ui.selectable_value(&mut dialog.level, choice, name(choice));
        }
    });
    shown.response.labelled_by(label);
}

fn scale(ui: &mut Ui, dialog: &mut SiteFrameDialog, label: eframe::egui::Id) {
    let name = |choice: ScaleChoice| match choice {
        ScaleChoice::Keep => "as it is".to_owned(),
        ScaleChoice::Length => "a known length".into(),
        ScaleChoice::Unit(_, unit) => format!("the model's unit, {unit}"),
    };
    let units = UNITS.map(|(metres, unit)| ScaleChoice::Unit(metres, unit));
    let shown = ComboBox::from_id_salt("scale").selected_text(name(dialog.scale)).show_ui(ui, |ui| {
        for choice in [ScaleChoice::Keep, ScaleChoice::Length].into_iter().chain(units) {
            ui.selectable_value(&mut dialog.scale, choice, name(choice));
        }
    });
    shown.response.labelled_by(label);
}

fn field(ui: &mut Ui, text: &mut String, hint: &str, width: f32) -> eframe::egui::Response {
    ui.add(TextEdit::singleline(text).hint_text(hint).desired_width(width))
}

/// Draws the buttons; returns whether the dialog is left.
fn buttons(ui: &mut Ui, keys: &mut Keys, dialog: &mut SiteFrameDialog, requests: &mut Vec<Request>) -> bool {
    let change = dialog.change();
    let problem = change.as_ref().err().or(dialog.problem.as_ref());
    if let Some(problem) = problem {
        ui.colored_label(ui.visuals().warn_fg_color, problem);
    }
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        let size = vec2(96.0, 28.0);
        let apply = Button::new(RichText::new("Set").strong()).min_size(size);
        let is_ready = change.is_ok_and(|change| !change.is_empty());
        if keys.press(&ui.add_enabled(is_ready, apply)) {
            requests.push(OrthoRequest::SetFrame(Box::new(dialog.clone())).into());
        }
        ui.add(Button::new("Close").min_size(size)).clicked()
    })
    .inner
}
