//! The inspector: facts about the selection.

use eframe::egui::{Label, RichText, ScrollArea, Ui};

use super::{counted, grouped, layer_options, masks, percent, text_width};
use crate::app::command::{layers, paint, view};
use crate::app::editor::Editor;
use crate::app::inspect::{face_page, layer_page, object_page};
use crate::app::state::State;
use crate::app::state::ask::{Ask, DecideAsk};
use crate::app::state::selection::Selection;
use crate::app::state::session::Session;
use crate::document::Stack;
use crate::recipe::decide::decided;

/// Draws the inspector.
pub fn inspector_ui(editor: &mut Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    ui.add_space(4.0);
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| match editor.state.selection {
        Selection::Object(object) => object_page(editor, object, ui, asks),
        Selection::Face(face) => face_page(editor, face, ui, asks),
        Selection::Layer { photo, layer } => layer_page(editor, photo, layer, ui, asks),
        Selection::Nothing | Selection::Photo(_) => {
            let Some(session) = &editor.state.session else { return };
            match editor.state.selection {
                Selection::Photo(photo) => {
                    photo_ui(editor, session, photo, ui, asks);
                    masks::masks_ui(editor, photo, ui, asks);
                }
                _ => nothing(session, ui),
            }
        }
    });
}

/// Draws the title of the selection: its kind and its name.
pub fn title(ui: &mut Ui, kind: &str, name: &str) {
    ui.weak(kind);
    ui.label(RichText::new(name).heading());
    ui.add_space(4.0);
}

/// The greatest width of the names of facts, as a share of the page's.
const NAMES_MOST: f32 = 0.45;

/// Draws facts in two columns: names as wide as the widest, values wrapped.
pub fn rows(ui: &mut Ui, rows: &[(&str, String)]) {
    let gap = 12.0;
    let widest = rows.iter().map(|(name, _)| text_width(ui, name)).fold(0.0, f32::max);
    let names = (widest + 1.0).min(NAMES_MOST * ui.available_width());
    let values = ui.available_width() - names - gap;
    for (name, value) in rows {
        ui.horizontal_top(|ui| {
            ui.spacing_mut().item_spacing.x = gap;
            ui.scope(|ui| {
                ui.set_width(names);
                ui.add(Label::new(RichText::new(*name).weak()).wrap());
            });
            ui.scope(|ui| {
                ui.set_max_width(values);
                ui.add(Label::new(value).wrap());
            });
        });
    }
}

/// Draws a button for a command; its tooltip gives the reason where the command is not ready.
pub fn button(
    state: &State,
    ui: &mut Ui,
    command: &'static crate::app::command::Command,
    asks: &mut Vec<Ask>,
) {
    let ready = (command.ready)(state);
    let on = command.on.is_some_and(|on| on(state));
    let button = eframe::egui::Button::new(command.name).selected(on);
    let response = ui.add_enabled(ready.is_ok(), button);
    let response = response.on_hover_text(command.tooltip);
    if response.on_disabled_hover_text(ready.err().unwrap_or_default()).clicked() {
        asks.push(command.asked(state));
    }
}

fn nothing(session: &Session, ui: &mut Ui) {
    title(ui, "Project", &session.name());
    let model = session.model();
    let built = session.photos.iter().filter(|photo| photo.is_current()).count();
    let project = &session.opened.project;
    let facts = [
        ("Photos", format!("{} ({built} built)", session.photos.len())),
        ("Objects", grouped(model.objects.len() as u64)),
        ("Faces", grouped(model.faces.len() as u64)),
        ("Photos from", project.photos.clone()),
        ("Cameras from", project.cameras.clone()),
        ("Model from", project.model.clone()),
    ];
    rows(ui, &facts);
    ui.add_space(8.0);
    ui.weak("Click a photo, an object or a layer to see what is known of it.");
}

fn photo_ui(state: &State, session: &Session, index: usize, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let photo = &session.opened.site.photos[index];
    let status = &session.photos[index];
    title(ui, "Photo", &photo.name);
    let camera = &photo.camera;
    let field = 2.0 * (f64::from(camera.height) / 2.0 / camera.fy).atan().to_degrees();
    let mut facts = vec![
        ("Size", format!("{} × {} px", camera.width, camera.height)),
        ("Focal length", format!("{:.1} px", camera.fx)),
        ("Field of view", format!("{field:.1}° high")),
        ("State", status.word.to_owned()),
    ];
    if let Some(stack) = &status.stack {
        let own = u64::from(camera.width) * u64::from(camera.height);
        facts.push(("Visibility layers", stack.visibility_layers.len().to_string()));
        facts.push(("Image layers", image_layers(stack)));
        facts
            .push(("Texels", format!("{} ({:.2} × photo)", grouped(stack.texels), ratio(stack.texels, own))));
        facts.push(("Used", percent(stack.texels_used, stack.texels)));
        if let Some((hidden, filled)) = status.hidden() {
            facts.push(("Hidden", format!("{} ({})", grouped(hidden), percent(hidden, stack.texels_used))));
            facts.push(("Filled", percent(filled, hidden)));
        }
    }
    rows(ui, &facts);
    if let Some(problem) = &status.problem {
        ui.colored_label(ui.visuals().error_fg_color, problem);
    }
    ui.add_space(6.0);
    ui.horizontal_wrapped(|ui| {
        button(state, ui, &view::SNAP, asks);
        if !status.is_current() {
            button(state, ui, &layers::BUILD_PHOTO, asks);
        }
        if status.stack.is_some() {
            button(state, ui, &paint::EDIT, asks);
        }
    });
    decisions(session, &photo.name, ui, asks);
    ui.add_space(8.0);
    layer_options::photo_options_ui(state, session, &photo.name, ui, asks);
}

/// Formats the number of image layers and of depths. An image layer with surfaces of several visibility layers lies
/// behind all that occlude any of them, so there are more depths than visibility layers.
fn image_layers(stack: &Stack) -> String {
    let count = stack.image_layers.len();
    let depths = stack.image_layers.last().map_or(0, |deepest| u64::from(deepest.order) + 1);
    format!("{count}, at {}", counted(depths, "depth"))
}

fn ratio(part: u64, all: u64) -> f64 {
    part as f64 / all.max(1) as f64
}

/// Draws the decisions about a photo, each with a button to remove it.
fn decisions(session: &Session, name: &str, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let Some(decisions) = session.opened.project.decisions.photos.get(name) else { return };
    ui.add_space(8.0);
    ui.strong("Decided");
    for decision in decided(decisions) {
        ui.horizontal_wrapped(|ui| {
            if ui.small_button("Forget").on_hover_text("Takes this decision back.").clicked() {
                asks.push(Ask::Decide(DecideAsk::Forget(name.to_owned(), decision.number)));
            }
            ui.label(&decision.text);
        });
    }
}
