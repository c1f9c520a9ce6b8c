//! The face under the pointer in the 3D view, and selecting by click.

use eframe::egui::{Rect, Response, Ui, Vec2};
use glam::DVec3;

use super::{NewestPicture, px_of};
use crate::app::editor::Editor;
use crate::app::state::State;
use crate::app::state::ask::{Ask, SelectAsk};
use crate::app::state::selection::Selection;
use crate::app::state::session::Session;
use crate::scene::{FaceId, Model};

/// Handles the pointer: hovering shows the name, a click selects the object and another one its face, a double click
/// frames it.
pub fn pick(editor: &mut Editor, ui: &Ui, response: &Response, rect: Rect, asks: &mut Vec<Ask>) {
    let hovered = response.hover_pos().filter(|_| !response.dragged());
    let face = hovered.and_then(|at| face_at(editor, ui, at - rect.min));
    editor.state.space.hovered = face;
    let Some(session) = &editor.state.session else { return };
    let model = session.model();
    if let Some(face) = face {
        let (name, object) = (model.face_name(face), model.face(face).object);
        response.clone().on_hover_text_at_pointer(name);
        if response.double_clicked() {
            asks.push(Ask::Select(SelectAsk::Only(Selection::Face(face))));
            asks.push(crate::app::command::view::FRAME.asked(editor));
        } else if response.clicked() {
            let again = editor.state.selection == Selection::Object(object);
            asks.push(Ask::Select(SelectAsk::Only(if again {
                Selection::Face(face)
            } else {
                Selection::Object(object)
            })));
        }
    } else if response.clicked() {
        asks.push(Ask::Select(SelectAsk::Only(Selection::Nothing)));
    }
}

/// Returns the face at a position: from the item buffer where the picture shows this view, otherwise by a ray.
fn face_at(state: &State, ui: &Ui, offset: Vec2) -> Option<FaceId> {
    let space = &state.space;
    let session = state.session.as_ref()?;
    let px = px_of(offset, ui.ctx().pixels_per_point());
    let is_this =
        |shown: &&NewestPicture| shown.request.shot.pose == space.viewpoint.pose && !shown.faces.is_empty();
    let shown = space.shown.as_ref().filter(is_this);
    if let Some(shown) = shown {
        let camera = &shown.request.shot.camera;
        let place = |px: f64, of: u32, all: u32| ((px / f64::from(all) * f64::from(of)) as u32).min(of - 1);
        let (x, y) =
            (place(px.x, camera.width, space.size_px[0]), place(px.y, camera.height, space.size_px[1]));
        let face = shown.faces.get(y as usize * camera.width as usize + x as usize)?;
        return face.checked_sub(1).map(FaceId);
    }
    let ray = space.viewpoint.ray(px, space.size_px);
    session
        .solid
        .first_visible(space.viewpoint.position(), ray, !space.look.without_backs)
        .map(|hit| hit.face)
}

/// Returns the bounding sphere of a selection, in world space; none for photos and for nothing.
pub fn ball_of(selection: Selection, session: &Session) -> Option<(DVec3, f64)> {
    let model = session.model();
    let faces = faces_of(selection, session);
    let points: Vec<DVec3> = faces.into_iter().flat_map(|face| model.ring_points(face)).collect();
    if points.is_empty() {
        return None;
    }
    let (low, high) =
        points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
    let center = (low + high) / 2.0;
    let radius = points.iter().map(|point| point.distance(center)).fold(0.0, f64::max);
    Some((center, radius.max(session.scene_frame.radius * 1e-3)))
}

/// Returns the selected faces.
pub fn faces_of(selection: Selection, session: &Session) -> Vec<FaceId> {
    let model: &Model = session.model();
    match selection {
        Selection::Object(object) => model.object(object).faces.clone(),
        Selection::Face(face) => vec![face],
        Selection::Layer { photo, layer } => faces_of_layer(photo, layer, session).unwrap_or_default(),
        Selection::Photo(_) | Selection::Nothing => Vec::new(),
    }
}

fn faces_of_layer(photo: usize, layer: usize, session: &Session) -> Option<Vec<FaceId>> {
    let stack = session.photos.get(photo)?.stack.as_ref()?;
    let elements: Vec<_> = stack.visibility_layers.iter().flatten().collect();
    let model = session.model();
    let mut found = Vec::new();
    for element in &stack.image_layers.get(layer)?.elements {
        let element = elements.get(*element as usize)?;
        let object = model.objects.iter().find(|object| object.name == element.object)?;
        let pieces = element.pieces.iter().map(|piece| piece[0]);
        found
            .extend(element.faces.iter().copied().chain(pieces).filter_map(|i| object.faces.get(i as usize)));
    }
    found.sort_unstable();
    found.dedup();
    Some(found)
}
