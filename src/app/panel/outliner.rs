//! Objects with their faces, and the selected photo's layers.

use eframe::egui::collapsing_header::CollapsingState;
use eframe::egui::{Button, Id, RichText, ScrollArea, Ui};

use super::percent;
use crate::app::command::flat::SHOW_LAYER;
use crate::app::command::view::FRAME;
use crate::app::editor::{Ask, Editor};
use crate::app::selection::Selection;
use crate::app::session::Session;
use crate::document::{ImageLayer, Stack};
use crate::scene::ObjectId;

/// Draws it.
pub fn outliner_ui(editor: &mut Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let Some(session) = &editor.session else { return };
    ui.add_space(4.0);
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        if let Some(photo) = editor.selected_photo() {
            layers(editor, session, photo, ui, asks);
        }
        objects(editor, session, ui, asks);
    });
}

/// A row that opens; what it is about can be selected.
fn branch(
    ui: &mut Ui,
    id: Id,
    open: bool,
    selected: bool,
    text: RichText,
    body: impl FnOnce(&mut Ui),
) -> bool {
    let state = CollapsingState::load_with_default_open(ui.ctx(), id, open);
    let header = state.show_header(ui, |ui| ui.add(Button::selectable(selected, text).truncate()));
    let (_, header, _) = header.body(body);
    header.inner.clicked()
}

fn objects(editor: &Editor, session: &Session, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let model = session.model();
    let title = RichText::new(format!("Objects ({})", model.objects.len())).strong();
    let id = ui.make_persistent_id("objects");
    branch(ui, id, true, false, title, |ui| {
        for (place, object) in model.objects.iter().enumerate() {
            let this = Selection::Object(ObjectId(place as u32));
            let text = RichText::new(format!("{}  ({})", object.name, object.faces.len()));
            let faces = |ui: &mut Ui| {
                for face in &object.faces {
                    let this = Selection::Face(*face);
                    let button = Button::selectable(editor.selection == this, model.face_name(*face));
                    let response = ui.add(button);
                    if response.double_clicked() {
                        asks.extend([Ask::Select(this), Ask::Run(&FRAME)]);
                    } else if response.clicked() {
                        asks.push(Ask::Select(this));
                    }
                }
            };
            let clicked = branch(ui, id.with(place), false, editor.selection == this, text, faces);
            if clicked {
                asks.push(Ask::Select(this));
            }
        }
    });
}

fn layers(editor: &Editor, session: &Session, photo: usize, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let name = &session.opened.site.photos[photo].name;
    let Some(stack) = &session.photos[photo].stack else {
        ui.strong(format!("Layers of {name}"));
        ui.weak("Not built yet: Layers › Build layers makes them.");
        return;
    };
    let title = RichText::new(format!("Layers of {name} ({})", stack.image_layers.len())).strong();
    let id = ui.make_persistent_id("layers");
    branch(ui, id, true, false, title, |ui| {
        let deepest = stack.image_layers.iter().map(|layer| layer.order).max().unwrap_or_default();
        for order in 0..=deepest {
            let text = RichText::new(depth_name(stack, order));
            branch(ui, id.with(order), true, false, text, |ui| {
                for (place, layer) in stack.image_layers.iter().enumerate().filter(|(_, l)| l.order == order)
                {
                    let this = Selection::Layer { photo, layer: place };
                    let selected = editor.selection == this || editor.more_layers.contains(&(photo, place));
                    let button = Button::selectable(selected, layer_text(layer)).truncate();
                    let response = ui.add(button).on_hover_text("A double click shows the layer alone.");
                    if response.clicked() {
                        let more = ui.input(|input| input.modifiers.command || input.modifiers.shift);
                        asks.push(if more { Ask::Toggle(photo, place) } else { Ask::Select(this) });
                    }
                    if response.double_clicked() {
                        asks.push(Ask::Run(&SHOW_LAYER));
                    }
                }
            });
        }
    });
}

/// How deep a layer lies, in words: 0 nearest.
fn depth_name(stack: &Stack, order: u32) -> String {
    let count = stack.image_layers.iter().filter(|layer| layer.order == order).count();
    match order {
        0 => format!("In front ({count})"),
        1 => format!("Behind 1 ({count})"),
        order => format!("Behind {order} ({count})"),
    }
}

fn layer_text(layer: &ImageLayer) -> String {
    let hidden = layer.texels_used - layer.texels_visible;
    match hidden {
        0 => layer.name.clone(),
        hidden => format!("{} – {} hidden", layer.name, percent(hidden, layer.texels_used)),
    }
}
