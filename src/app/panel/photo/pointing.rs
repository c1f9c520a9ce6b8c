//! The pixel and shape under the pointer in the photo view, and selecting by click.

use eframe::egui::{Color32, Label, Response, RichText, Sense, TextWrapMode, Ui, vec2};

use super::placed::PlacedPhoto;
use super::strip::hint;
use super::view::PhotoView;
use crate::state::flat::photo::PhotoPane;
use crate::state::flat::picked::face_of;
use crate::state::flat::version::LayersVersion;
use crate::state::request::{MaskRequest, Request, SelectRequest};
use crate::state::selection::Selection;
use crate::state::session::Session;
use quadratura_base::scene::PhotoId;
use quadratura_editing::peel::{PeelHit, PeelShape, PhotoLayers};

/// Finds the shape under the pointer; a click selects it.
pub fn point(
    ui: &Ui,
    view: &PhotoView<'_>,
    pane: &mut PhotoPane,
    response: &Response,
    placed: &PlacedPhoto,
    requests: &mut Vec<Request>,
) {
    let photo = placed.photo;
    let hovered = response.hover_pos().filter(|_| !response.dragged());
    let pixel = hovered.map(|at| placed.seen.pixel(at));
    let Some(session) = view.session else { return };
    let hidden = pane.hidden_layers;
    pane.pointed = pixel.and_then(|pixel| view.flat.pointed_in_photo(session, photo, pixel, hidden));
    let pixel = pane.pointed.as_ref().map(|pointed| pointed.pixel);
    let suggestion = pixel.and_then(|pixel| view.masking.suggestion_at(session, photo, pixel));
    // A click with a mask tool selects nothing.
    let free = view.masking.tool.is_none() && pane.grip.edge.is_none();
    let pointed = suggestion.filter(|_| free);
    if view.masking.suggested.pointed != pointed {
        requests.push(MaskRequest::PointAt(pointed).into());
    }
    match suggestion {
        _ if !free || !response.clicked() => (),
        Some(number) => requests.push(Request::Mask(MaskRequest::Accept(vec![number]))),
        None => requests.push(select(ui, view, pane, session, photo).into()),
    }
}

/// Selects the front image layer; further clicks select its object, its face, and the layer again. With Ctrl or Shift a
/// click adds a layer.
fn select(
    ui: &Ui,
    view: &PhotoView<'_>,
    pane: &PhotoPane,
    session: &Session,
    photo: PhotoId,
) -> SelectRequest {
    let pointed = pane.pointed.as_ref();
    let layers = pointed.and_then(|pointed| view.flat.loading.layers(pointed.version.as_ref()?));
    let shape = layers.as_ref().and_then(|layers| pointed?.shape(layers));
    let more = ui.input(|input| input.modifiers.command || input.modifiers.shift);
    match shape {
        Some(shape) if more => SelectRequest::Toggle(photo, shape.layer),
        Some(shape) => SelectRequest::Only(next(view.selection.main, photo, shape, session)),
        None => SelectRequest::Only(Selection::Photo(photo)),
    }
}

fn next(now: Selection, photo: PhotoId, shape: &PeelShape, session: &Session) -> Selection {
    let layer = Selection::Layer { photo, layer: shape.layer };
    let Some(face) = face_of(shape, session) else { return layer };
    let object = Selection::Object(session.model().face(face).object);
    match now {
        now if now == layer => object,
        now if now == object => Selection::Face(face),
        _ => layer,
    }
}

/// Draws the lines below the photo: pixel, colour and shape. Their height is fixed, so that the photo does not move;
/// longer text is truncated, and the tooltip has all of it.
pub fn status_ui(ui: &mut Ui, view: &PhotoView<'_>, pane: &PhotoPane) {
    ui.style_mut().wrap_mode = Some(TextWrapMode::Truncate);
    if let Some(number) = view.masking.suggested.pointed {
        ui.strong(format!("Suggestion {number}: only this photo shows it."));
        ui.weak("A click masks it; the list beside the photo has buttons to mask or dismiss it.");
        return;
    }
    let Some(pointed) = &pane.pointed else {
        if let Some(hint) = hint(view.masking, ui) {
            ui.weak(hint);
            return;
        }
        ui.weak("Point at the photo to see the surfaces there.");
        ui.weak("A click selects the image layer, a second click its object, a third its face.");
        return;
    };
    let layers = pointed.version.as_ref().and_then(|version| view.flat.loading.layers(version));
    let front = pointed.hits.first();
    ui.horizontal(|ui| {
        ui.monospace(format!("{}, {}", pointed.pixel.0, pointed.pixel.1));
        ui.separator();
        if let Some([r, g, b]) = pointed.colour {
            let (rect, _) = ui.allocate_exact_size(vec2(14.0, 14.0), Sense::hover());
            ui.painter().rect_filled(rect, 2.0, Color32::from_rgb(r, g, b));
            ui.monospace(format!("{r} {g} {b}"));
            ui.separator();
        }
        match (&layers, &pointed.version, front) {
            (Some(layers), Some(version), Some(front)) => name(ui, layers, version, front),
            (Some(_), ..) => {
                ui.weak("no surface of the model");
            }
            (None, Some(_), _) => {
                ui.weak("reading the layers…");
            }
            (None, None, _) => {
                ui.weak("no layers yet");
            }
        }
    });
    if let Some(hint) = hint(view.masking, ui) {
        ui.add(Label::new(RichText::new(hint).weak()).truncate());
    } else if let (Some(layers), Some(front)) = (&layers, front) {
        order(ui, layers, front, &pointed.hits[1..]);
    }
}

fn name(ui: &mut Ui, layers: &PhotoLayers, version: &LayersVersion, front: &PeelHit) {
    let shape = &layers.shapes[front.shape];
    ui.strong(match shape.face {
        Some(face) => format!("{}[{face}]", shape.object),
        None => "surroundings: no surface of the model".to_owned(),
    });
    let layer = version.stack.image_layers.get(shape.layer.index()).map_or("", |layer| &layer.name);
    ui.add(Label::new(format!("in image layer “{layer}”")).truncate());
}

/// Draws the position of the surface among those at the pixel.
fn order(ui: &mut Ui, layers: &PhotoLayers, front: &PeelHit, behind: &[PeelHit]) {
    let shape = &layers.shapes[front.shape];
    let shown = if front.visible { "shown by the photo" } else { "hidden in the photo" };
    let mut text = format!("Visibility layer {}, {shown}", shape.depth + 1);
    if front.distance.is_finite() {
        text += &format!(", {:.2} away", front.distance);
    }
    let behind = behind.iter().map(|hit| &layers.shapes[hit.shape]).filter(|shape| shape.face.is_some());
    let names: Vec<&str> = behind.map(|shape| shape.object.as_str()).collect();
    if !names.is_empty() {
        text += &format!("; behind it {}", names.join(", "));
    }
    ui.add(Label::new(RichText::new(text).weak()).truncate());
}
