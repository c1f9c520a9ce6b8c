//! The pointer in the 3D view: the name of the face under it, and selecting by click.

use eframe::egui::{Rect, Response, Ui};

use super::overlay::seen_from;
use super::px_of;
use crate::command::Commands;
use crate::command::view;
use crate::panel::menu::{SURFACE, TREE, context_ui};
use crate::state::State;
use crate::state::request::{Request, SelectRequest};
use crate::state::selection::Selection;
use crate::state::space::memory::SpaceMemory;
use crate::state::space::picking::ViewPixel;
use quadratura_document::trees::TreeIndex;

/// Handles the pointer: hovering shows the name, a click selects the object and another one its face, a double click
/// frames it.
pub fn pick(
    ui: &Ui,
    state: &State,
    it: &mut SpaceMemory,
    response: &Response,
    rect: Rect,
    requests: &mut Vec<Request>,
) {
    let hovered = response.hover_pos().filter(|_| !response.dragged());
    let view = seen_from(state, it);
    let density = ui.ctx().pixels_per_point();
    // What is seen under the pointer is meant.
    let pixel = hovered.map(|at| ViewPixel { viewpoint: view, ..it.pixel_at(px_of(at - rect.min, density)) });
    let tree = pixel.and_then(|pixel| state.tree_at(&pixel));
    let face = pixel.and_then(|pixel| state.face_at(&pixel));
    it.hovered = face;
    if let Some(tree) = tree {
        return pick_tree(state, response, tree, requests);
    }
    let Some(session) = &state.session else { return };
    let model = session.model();
    if let Some(face) = face {
        let (name, object) = (model.face_name(face), model.face(face).object);
        response.clone().on_hover_text_at_pointer(name);
        if response.double_clicked() {
            requests.push(Request::Select(SelectRequest::Only(Selection::Face(face))));
            requests.push(view::FRAME.asked(state));
        } else if response.clicked() {
            let again = state.selection.main == Selection::Object(object);
            requests.push(Request::Select(SelectRequest::Only(if again {
                Selection::Face(face)
            } else {
                Selection::Object(object)
            })));
        }
        if response.secondary_clicked()
            && state.selected_object().as_ref() != Some(&model.object(object).name)
        {
            requests.push(Request::Select(SelectRequest::Only(Selection::Object(object))));
        }
    } else if response.clicked() {
        requests.push(Request::Select(SelectRequest::Only(Selection::Nothing)));
    }
    // The pointer has left the tree whose menu is open.
    let commands = if state.selected_tree().is_some() { TREE } else { SURFACE };
    response.context_menu(|ui| context_ui(Commands::of(state), ui, commands, requests));
}

/// Handles the pointer over a tree: hovering shows the name, a click selects it, a double click frames it.
fn pick_tree(state: &State, response: &Response, index: TreeIndex, requests: &mut Vec<Request>) {
    let Some(tree) = state.trees().and_then(|trees| trees.at(index)) else { return };
    response.clone().on_hover_text_at_pointer(&tree.name);
    let select = || Request::Select(SelectRequest::Only(Selection::Tree(index)));
    if response.double_clicked() {
        requests.extend([select(), view::FRAME.asked(state)]);
    } else if response.clicked() || response.secondary_clicked() {
        requests.push(select());
    }
    response.context_menu(|ui| context_ui(Commands::of(state), ui, TREE, requests));
}
