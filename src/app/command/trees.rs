//! Commands on trees.

use eframe::egui::Key;

use super::{Command, KeysIn, Menu, PLAIN, WhyNot, shift, with_project};
use crate::state::State;
use crate::state::request::{SelectRequest, TreeRequest};
use crate::state::selection::Selection;

/// The commands in the order of their menu.
pub const COMMANDS: &[&Command] =
    &[&PLACE, &DUPLICATE, &REMOVE, &HIDE, &SHOW_ALL, &LIGHT, &MASK, &CLEAR_MASKS];

const TREES: Command = Command { menu: Menu::Trees, ready: with_project, ..PLAIN };

/// Takes up the tool that places trees.
pub const PLACE: Command = Command {
    name: "Place tree",
    tooltip: "A click in the 3D view places a tree, a drag moves one, with Alt its height, with Shift its turn; Esc ends it.",
    keys: &[shift(Key::T)],
    keys_in: KeysIn::Space,
    on: Some(|state| state.trees.hand.on),
    request: |_| TreeRequest::Hand.into(),
    ..TREES
};

/// Places a copy of the selected tree.
pub const DUPLICATE: Command = Command {
    name: "Duplicate tree",
    tooltip: "Places a copy of the selected tree beside it.",
    starts_group: true,
    ready: with_tree,
    detail: Some(selected_in_brackets),
    request: |state| TreeRequest::Duplicate(selected(state)).into(),
    ..TREES
};

/// Removes the selected tree.
pub const REMOVE: Command = Command {
    name: "Remove tree",
    tooltip: "Removes the selected tree from the project; what it replaced is back.",
    ready: with_tree,
    detail: Some(selected_in_brackets),
    request: |state| TreeRequest::Remove(selected(state)).into(),
    ..TREES
};

/// Hides the selected tree.
pub const HIDE: Command = Command {
    name: "Hide tree",
    tooltip: "Hides the selected tree in the 3D view, as its eye in the list does; it remains in the project.",
    starts_group: true,
    ready: with_tree,
    request: |state| TreeRequest::Show(vec![selected(state)], false).into(),
    ..TREES
};

/// Shows all trees that are hidden.
pub const SHOW_ALL: Command = Command {
    name: "Show all trees",
    tooltip: "Shows all trees in the 3D view that are hidden by their eyes.",
    ready: |state| match state.trees.hidden.is_empty() {
        false => with_project(state),
        true => Err("no tree is hidden"),
    },
    request: |_| TreeRequest::ShowAll.into(),
    ..TREES
};

/// Shows the page of all trees.
pub const LIGHT: Command = Command {
    name: "Light on trees",
    tooltip: "Shows the page of all trees on the right: where the sun is, and how bright sun, sky and ground are.",
    starts_group: true,
    ready: with_trees,
    request: |_| SelectRequest::Only(Selection::Trees).into(),
    ..TREES
};

/// Masks the real trees.
pub const MASK: Command = Command {
    name: "Mask real trees",
    tooltip: "Masks the real trees in all photos, where trees of the project stand; the walls behind are filled from other photos.",
    starts_group: true,
    ready: with_trees,
    request: |_| TreeRequest::Mask.into(),
    ..TREES
};

/// Removes the masks of trees.
pub const CLEAR_MASKS: Command = Command {
    name: "Remove masks of trees",
    tooltip: "Removes the masks that `Mask real trees` has made, in all photos.",
    ready: |state| match state.masks_without_trees() {
        Some(_) => Ok(()),
        None => Err("no photo has a mask of a tree"),
    },
    request: |_| TreeRequest::ClearMasks.into(),
    ..TREES
};

fn with_tree(state: &State) -> Result<(), WhyNot> {
    state.selected_tree().map(|_| ()).ok_or("select a tree")
}

fn with_trees(state: &State) -> Result<(), WhyNot> {
    with_project(state)?;
    let any = state.trees().is_some_and(|trees| !trees.placed.is_empty());
    if any { Ok(()) } else { Err("place a tree first") }
}

fn selected(state: &State) -> String {
    state.selected_tree().map(|tree| tree.name.clone()).unwrap_or_default()
}

fn selected_in_brackets(state: &State) -> Option<String> {
    Some(format!("({})", state.selected_tree()?.name))
}
