//! Draws a path that is typed, chosen or suggested, with the result of checking it.

use std::path::PathBuf;

use eframe::egui::{Key, Response, RichText, Role, ScrollArea, TextEdit, Ui, WidgetInfo};

use crate::state::numbers::counted;
use crate::state::opening::place::PathField;
use crate::state::opening::{DialogRequest, PathKind, Purpose};
use quadratura_sites::discover::{DiscoveryReport, SitePart};

/// Draws a text field for a path; returns whether Enter was pressed in it.
pub fn typed_ui(ui: &mut Ui, typed: &mut String, name: &str, width: f32) -> bool {
    let line = line(ui, typed, name, width);
    is_entered(&line)
}

/// Returns whether Enter was pressed in a text field.
pub fn is_entered(line: &Response) -> bool {
    line.lost_focus() && line.ctx.input(|input| input.key_pressed(Key::Enter))
}

/// Draws the text field alone.
pub fn line(ui: &mut Ui, typed: &mut String, name: &str, width: f32) -> Response {
    let line = ui.add(TextEdit::singleline(typed).desired_width(width).hint_text(name));
    let value = typed.clone();
    line.widget_info(|| WidgetInfo {
        label: Some(name.to_owned()),
        current_text_value: Some(value.clone()),
        ..WidgetInfo::new(Role::TextInput)
    });
    line
}

/// Draws a part's name, its text field, alternatives and the button for a file dialog.
pub fn part_line(ui: &mut Ui, part: SitePart, place: &mut PathField, requests: &mut Vec<DialogRequest>) {
    ui.strong(part.name());
    ui.horizontal(|ui| {
        if line(ui, &mut place.typed, part.name(), 470.0).changed() {
            place.errors.clear();
        }
        let others: Vec<PathBuf> =
            place.offered.iter().filter(|path| **path != place.path()).cloned().collect();
        ui.add_enabled_ui(!others.is_empty(), |ui| {
            let menu = ui.menu_button("Alternatives", |ui| {
                for other in others {
                    if ui.button(other.display().to_string()).clicked() {
                        place.set(&other);
                    }
                }
            });
            let response =
                menu.response.on_hover_text(format!("{}: alternatives that were found.", part.name()));
            response.on_disabled_hover_text("No alternatives were found.");
        });
        requests.extend(browse_ui(ui, part).map(|kind| DialogRequest::Choose(Purpose::Part(part, kind))));
    });
}

/// Draws the button for a file dialog; it opens a menu where the part may be a file or a folder. Returns the kind of
/// path that is to be chosen.
fn browse_ui(ui: &mut Ui, part: SitePart) -> Option<PathKind> {
    let help = format!("Chooses {}.", part.accepted());
    if let &[kind] = PathKind::of_part(part) {
        return ui.button("Browse…").on_hover_text(help).clicked().then_some(kind);
    }
    let menu = ui.menu_button("Browse…", |ui| {
        let item = |ui: &mut Ui, kind: &PathKind| {
            let name = match kind {
                PathKind::File => "Choose a file…",
                PathKind::Folder => "Choose a folder…",
            };
            ui.button(name).clicked().then_some(*kind)
        };
        PathKind::of_part(part).iter().filter_map(|kind| item(ui, kind)).last()
    });
    menu.response.on_hover_text(help);
    menu.inner.flatten()
}

/// Draws the contents found at a path, or the error and what would be accepted.
pub fn part_found(ui: &mut Ui, part: SitePart, place: &PathField, look: Option<&DiscoveryReport>) {
    ui.indent(part.name(), |ui| {
        if !place.errors.is_empty() {
            wrongs(ui, &place.errors);
            return;
        }
        let path = place.path();
        if path.as_os_str().is_empty() {
            let found = if place.searched { "Not found. Choose" } else { "Needed:" };
            let text = RichText::new(format!("{found} {}.", part.accepted_shortly()));
            let label =
                ui.label(if place.searched { text.color(ui.visuals().warn_fg_color) } else { text.weak() });
            label.on_hover_text(format!("Choose {}.", part.accepted()));
            return;
        }
        match look.filter(|look| look.parts().path(part) == path) {
            None => drop(ui.weak("Checking…")),
            Some(look) => match look.error(part) {
                Some(error) => wrong(ui, &error.to_string()),
                None => discovery_ui(ui, part, look),
            },
        }
    });
}

/// Draws an error.
pub fn wrong(ui: &mut Ui, text: &str) {
    ui.colored_label(ui.visuals().error_fg_color, text);
}

/// The greatest height of a list of errors, as a share of the window's: its heading and buttons stay visible.
const WRONG_MOST: f32 = 0.2;

/// Draws a list of errors.
pub fn wrongs(ui: &mut Ui, errors: &[String]) {
    if errors.is_empty() {
        return;
    }
    let highest = WRONG_MOST * ui.ctx().content_rect().height();
    let list = ScrollArea::vertical().id_salt("wrong").max_height(highest).auto_shrink([false, true]);
    list.show(ui, |ui| errors.iter().for_each(|error| wrong(ui, error)));
}

fn discovery_ui(ui: &mut Ui, part: SitePart, look: &DiscoveryReport) {
    let good = |ui: &mut Ui, text: String| drop(ui.label(text));
    match part {
        SitePart::Photos => {
            let count = look.photos.good().map_or(0, |photos| photos.files.len());
            good(ui, counted(count as u64, "photo"));
        }
        SitePart::Model => {
            let Some(model) = look.model.good() else { return };
            good(
                ui,
                format!(
                    "{}, {}",
                    counted(model.objects as u64, "object"),
                    counted(model.faces as u64, "face")
                ),
            );
            notes(ui, "about the model", &model.notes);
        }
        SitePart::Cameras => cameras(ui, look),
    }
}

fn cameras(ui: &mut Ui, look: &DiscoveryReport) {
    let Some(cameras) = look.cameras.good() else { return };
    let points = match cameras.points {
        0 => "no sparse points".into(),
        points => counted(points as u64, "sparse point"),
    };
    let count =
        format!("From {}: {}, {points}", cameras.program, counted(cameras.names.len() as u64, "camera"));
    match &look.matched {
        None => drop(ui.label(count)),
        Some(matched) if matched.found == matched.of => {
            ui.label(format!("{count}; all cameras have photos"));
        }
        Some(matched) => {
            let more = if matched.of - matched.found > matched.missing.len() { ", …" } else { "" };
            let text = format!(
                "{count}; {} of {} have photos in the folder above. Missing: {}{more}",
                matched.found,
                matched.of,
                matched.missing.join(", ")
            );
            let none = matched.found == 0;
            let color = if none { ui.visuals().error_fg_color } else { ui.visuals().warn_fg_color };
            ui.colored_label(color, text);
        }
    }
    notes(ui, "about the cameras", &cameras.notes);
    notes(ui, "cameras that cannot be used", &cameras.left_out);
}

fn notes(ui: &mut Ui, about: &str, notes: &[String]) {
    if !notes.is_empty() {
        let shown: Vec<&str> = notes.iter().take(12).map(String::as_str).collect();
        let text = format!("{} {about}", counted(notes.len() as u64, "note"));
        ui.weak(text).on_hover_text(shown.join("\n"));
    }
}
