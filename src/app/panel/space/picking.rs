//! The pointer in the 3D view: the name of the face under it, and selecting by click.

use eframe::egui::{Rect, Response, Ui};

use super::overlay::seen_from;
use super::px_of;
use super::view::SpacePaneView;
use crate::command::view;
use crate::panel::menu::{SURFACE, TREE, context_ui};
use crate::state::request::{Request, SelectRequest};
use crate::state::selection::Selection;
use crate::state::space::memory::SpaceMemory;
use crate::state::space::picking::ViewPixel;
use quadratura_document::trees::TreeIndex;

/// Handles the pointer: hovering shows the name, a click selects the object and another one its face, a double click
/// frames it.
pub fn pick(
    ui: &Ui,
    view: &SpacePaneView<'_>,
    it: &mut SpaceMemory,
    response: &Response,
    rect: Rect,
    requests: &mut Vec<Request>,
) {
    let hovered = response.hover_pos().filter(|_| !response.dragged());
    let seen = seen_from(view, it);
    let density = ui.ctx().pixels_per_point();
    // What is seen under the pointer is meant.
    let pixel = hovered.map(|at| ViewPixel { viewpoint: seen, ..it.pixel_at(px_of(at - rect.min, density)) });
    let tree = pixel.and_then(|pixel| view.scene.tree_at(&pixel));
    let face = pixel.and_then(|pixel| view.scene.face_at(&pixel));
    it.hovered = face;
    if let Some(tree) = tree {
        return pick_tree(view, response, tree, requests);
    }
    let session = view.scene.session;
    let model = session.model();
    if let Some(face) = face {
        let (name, object) = (model.face_name(face), model.face(face).object);
        response.clone().on_hover_text_at_pointer(name);
        if response.double_clicked() {
            requests.push(Request::Select(SelectRequest::Only(Selection::Face(face))));
            requests.push(view.commands.requested(&view::FRAME));
        } else if response.clicked() {
            let again = view.selection.main == Selection::Object(object);
            requests.push(Request::Select(SelectRequest::Only(if again {
                Selection::Face(face)
            } else {
                Selection::Object(object)
            })));
        }
        if response.secondary_clicked() && session.object_of(view.selection.main) != Some(object) {
            requests.push(Request::Select(SelectRequest::Only(Selection::Object(object))));
        }
    } else if response.clicked() {
        requests.push(Request::Select(SelectRequest::Only(Selection::Nothing)));
    }
    // The pointer has left the tree whose menu is open.
    let commands = if session.tree_of(view.selection.main).is_some() { TREE } else { SURFACE };
    response.context_menu(|ui| context_ui(view.commands, ui, commands, requests));
}

/// Handles the pointer over a tree: hovering shows the name, a click selects it, a double click frames it.
fn pick_tree(view: &SpacePaneView<'_>, response: &Response, index: TreeIndex, requests: &mut Vec<Request>) {
    let Some(tree) = view.scene.session.trees().at(index) else { return };
    response.clone().on_hover_text_at_pointer(&tree.name);
    let select = || Request::Select(SelectRequest::Only(Selection::Tree(index)));
    if response.double_clicked() {
        requests.extend([select(), view.commands.requested(&view::FRAME)]);
    } else if response.clicked() || response.secondary_clicked() {
        requests.push(select());
    }
    response.context_menu(|ui| context_ui(view.commands, ui, TREE, requests));
}
