//! The pixel and shape under the pointer in the photo view, and selecting by click.

use eframe::egui::{Color32, Label, Response, RichText, Sense, TextWrapMode, Ui, vec2};

use super::drawing::face_of;
use crate::app::editor::Editor;
use crate::app::flat::LayersVersion;
use crate::app::flat::placement::PlacedPicture;
use crate::app::masking::strip::hint;
use crate::app::state::State;
use crate::app::state::ask::{Ask, MaskAsk, SelectAsk};
use crate::app::state::selection::Selection;
use crate::app::state::session::Session;
use crate::recipe::peel::{PeelHit, PeelShape, PhotoLayers};

/// The pixel under the pointer, with its shapes.
pub struct Pointed {
    pixel: (i32, i32),
    colour: Option<Color32>,
    /// The shapes at the pixel from front to back, without hidden layers.
    hits: Vec<PeelHit>,
    version: Option<LayersVersion>,
}

impl Pointed {
    /// Returns the front shape.
    pub fn shape<'a>(&self, layers: &'a PhotoLayers) -> Option<&'a PeelShape> {
        layers.shapes.get(self.hits.first()?.shape)
    }
}

/// Finds the shape under the pointer; a click selects it.
pub fn point(
    editor: &mut Editor,
    response: &Response,
    seen: &PlacedPicture,
    photo: usize,
    asks: &mut Vec<Ask>,
) {
    let hovered = response.hover_pos().filter(|_| !response.dragged());
    let pointed = hovered.and_then(|at| pointed(editor, seen.pixel(at), photo));
    let suggestion = pointed.as_ref().and_then(|pointed| editor.state.suggestion_at(photo, pointed.pixel));
    editor.state.flat.photo.pointed = pointed;
    // A click with a mask tool selects nothing.
    let free = editor.state.masking.tool.is_none();
    editor.state.masking.suggested.pointed = suggestion.filter(|_| free);
    let Some(session) = &editor.state.session else { return };
    match suggestion {
        _ if !free || !response.clicked() => (),
        Some(number) => asks.push(Ask::Mask(MaskAsk::Accept(vec![number]))),
        None => select(editor, session, photo, asks),
    }
}

fn pointed(state: &State, pixel: (i32, i32), photo: usize) -> Option<Pointed> {
    let session = state.session.as_ref()?;
    let camera = &session.opened.site.photos[photo].camera;
    let inside = |at: i32, size: u32| at >= 0 && (at as u32) < size;
    if !inside(pixel.0, camera.width) || !inside(pixel.1, camera.height) {
        return None;
    }
    let (pane, switches) = (&state.flat.photo, &state.flat.switches);
    let version = LayersVersion::new(session, photo);
    let layers = version.as_ref().and_then(|version| pane.loading.layers(version));
    let hits = layers.map(|layers| layers.at(pixel.0, pixel.1, pane.hidden_layers)).unwrap_or_default();
    let colour = pane.loading.colour(session, photo, pane.hidden_layers, switches, pixel);
    Some(Pointed { pixel, colour, hits, version })
}

/// Selects the front image layer; further clicks select its object, its face, and the layer again. With Ctrl or Shift a
/// click adds a layer.
fn select(editor: &Editor, session: &Session, photo: usize, asks: &mut Vec<Ask>) {
    let pane = &editor.state.flat.photo;
    let pointed = pane.pointed.as_ref();
    let layers = pointed.and_then(|pointed| pane.loading.layers(pointed.version.as_ref()?));
    let shape = layers.as_ref().and_then(|layers| pointed?.shape(layers));
    let more = editor.context.input(|input| input.modifiers.command || input.modifiers.shift);
    asks.push(match shape {
        Some(shape) if more => Ask::Select(SelectAsk::Toggle(photo, shape.layer)),
        Some(shape) => Ask::Select(SelectAsk::Only(next(editor.state.selection, photo, shape, session))),
        None => Ask::Select(SelectAsk::Only(Selection::Photo(photo))),
    });
}

fn next(now: Selection, photo: usize, shape: &PeelShape, session: &Session) -> Selection {
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
pub fn status_ui(state: &State, ui: &mut Ui) {
    ui.style_mut().wrap_mode = Some(TextWrapMode::Truncate);
    if let Some(number) = state.masking.suggested.pointed {
        ui.strong(format!("Suggestion {number}: only this photo shows it."));
        ui.weak("A click masks it; the list beside the photo has it, too, to be masked or dismissed.");
        return;
    }
    let Some(pointed) = &state.flat.photo.pointed else {
        if let Some(hint) = hint(state, ui) {
            ui.weak(hint);
            return;
        }
        ui.weak("Point at the photo to see what is there.");
        ui.weak("A click selects the image layer, one more its object, one more its face.");
        return;
    };
    let layers = pointed.version.as_ref().and_then(|version| state.flat.photo.loading.layers(version));
    let front = pointed.hits.first();
    ui.horizontal(|ui| {
        ui.monospace(format!("{}, {}", pointed.pixel.0, pointed.pixel.1));
        ui.separator();
        if let Some(colour) = pointed.colour {
            let (rect, _) = ui.allocate_exact_size(vec2(14.0, 14.0), Sense::hover());
            ui.painter().rect_filled(rect, 2.0, colour);
            ui.monospace(format!("{} {} {}", colour.r(), colour.g(), colour.b()));
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
    if let Some(hint) = hint(state, ui) {
        ui.add(Label::new(RichText::new(hint).weak()).truncate());
    } else if let (Some(layers), Some(front)) = (&layers, front) {
        order(ui, layers, front, &pointed.hits[1..]);
    }
}

fn name(ui: &mut Ui, layers: &PhotoLayers, version: &LayersVersion, front: &PeelHit) {
    let shape = &layers.shapes[front.shape];
    ui.strong(format!("{}[{}]", shape.object, shape.face));
    let layer = version.stack.image_layers.get(shape.layer).map_or("", |layer| &layer.name);
    ui.add(Label::new(format!("in image layer “{layer}”")).truncate());
}

/// Draws the position of the surface among those at the pixel.
fn order(ui: &mut Ui, layers: &PhotoLayers, front: &PeelHit, behind: &[PeelHit]) {
    let shape = &layers.shapes[front.shape];
    let shown = if front.visible { "shown by the photo" } else { "hidden in the photo" };
    let mut text = format!("Visibility layer {}, {shown}, {:.2} away", shape.depth + 1, front.distance);
    let names: Vec<&str> = behind.iter().map(|hit| layers.shapes[hit.shape].object.as_str()).collect();
    if !names.is_empty() {
        text += &format!("; behind it {}", names.join(", "));
    }
    ui.add(Label::new(RichText::new(text).weak()).truncate());
}
