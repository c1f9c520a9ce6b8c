//! Commands that change decisions: undo and redo, and decisions about layers.

use eframe::egui::{Key, KeyboardShortcut, Modifiers};

use super::{Command, Menu, PLAIN, WhyNot, ctrl};
use crate::state::State;
use crate::state::request::{DecideRequest, Flag, MaskRequest, WindowRequest};
use crate::state::running::JobKind;
use crate::state::selection::Selection;

/// The commands in the order of their menus.
pub const COMMANDS: &[&Command] =
    &[&UNDO, &REDO, &HISTORY, &MERGE, &SPLIT, &PIN, &EXCLUDE, &RESET, &SWITCH_OFF, &ALL_ON];

const SHIFTED: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

/// Undoes the last step.
pub const UNDO: Command = Command {
    name: "Undo",
    tooltip: "Undoes the last step.",
    keys: &[ctrl(Key::Z)],
    menu: Menu::Edit,
    ready: |state| match state.masking.is_drawing() || state.space.brush.unpainted() > 0 {
        true => Ok(()),
        false => history(state, |history| history.undoes().is_some(), "nothing to undo"),
    },
    detail: Some(|state| match state.space.brush.unpainted() > 0 {
        true => Some("brush stroke".into()),
        false => Some(state.session.as_ref()?.history.undoes()?.to_owned()),
    }),
    // During a stroke, the stroke is the last step.
    request: |state| match state.masking.is_drawing() {
        true => MaskRequest::GiveUpStroke.into(),
        false => DecideRequest::Undo.into(),
    },
    ..PLAIN
};

/// Redoes the step that was undone last.
pub const REDO: Command = Command {
    name: "Redo",
    tooltip: "Redoes the step that was undone last.",
    keys: &[KeyboardShortcut::new(SHIFTED, Key::Z), ctrl(Key::Y)],
    menu: Menu::Edit,
    ready: |state| history(state, |history| history.redo_name().is_some(), "nothing to redo"),
    detail: Some(|state| Some(state.session.as_ref()?.history.redo_name()?.to_owned())),
    request: |_| DecideRequest::Redo.into(),
    ..PLAIN
};

/// Shows the list of the history.
pub const HISTORY: Command = Command {
    name: "History",
    tooltip: "Lists the steps of the history; a click undoes or redoes steps up to there.",
    menu: Menu::Edit,
    ready: |state| state.session.as_ref().map(|_| ()).ok_or("open a project first"),
    on: Some(|state| state.dialogs.history),
    request: |_| WindowRequest::Flip(Flag::History).into(),
    ..PLAIN
};

/// Merges the selected image layers into one.
pub const MERGE: Command = Command {
    name: "Merge layers",
    tooltip: "Merges the selected image layers of a photo into one, now and in all later builds.",
    keys: &[ctrl(Key::M)],
    menu: Menu::Edit,
    starts_group: true,
    ready: |state| match state.selection.layers().1.len() {
        0 | 1 => Err("select several image layers of one photo with Ctrl+click"),
        _ => Ok(()),
    },
    request: |_| DecideRequest::Merge.into(),
    ..PLAIN
};

/// Splits an image layer into one for each object.
pub const SPLIT: Command = Command {
    name: "Split layer",
    tooltip: "Gives every object of the selected image layer a layer of its own.",
    menu: Menu::Edit,
    ready: |state| match state.selection.main {
        Selection::Layer { .. } => Ok(()),
        _ => Err("select an image layer"),
    },
    request: |_| DecideRequest::Split.into(),
    ..PLAIN
};

/// Pins the selection to the selected photo.
pub const PIN: Command = Command {
    name: "Pin to this photo",
    tooltip: "Textures the selected object or face from this photo only, as far as the photo shows it.",
    menu: Menu::Edit,
    starts_group: true,
    ready: with_surface_and_photo,
    detail: Some(photo_in_brackets),
    request: |_| DecideRequest::Pin.into(),
    ..PLAIN
};

/// Excludes the selected photo from the selection.
pub const EXCLUDE: Command = Command {
    name: "Exclude this photo",
    tooltip: "Never textures the selected object or face from this photo.",
    menu: Menu::Edit,
    ready: with_surface_and_photo,
    detail: Some(photo_in_brackets),
    request: |_| DecideRequest::Exclude.into(),
    ..PLAIN
};

/// Removes the decisions about the photo.
pub const RESET: Command = Command {
    name: "Remove decisions about this photo",
    tooltip: "Removes all merges, splits, names, pins and exclusions of the selected photo, and its own options.",
    menu: Menu::Edit,
    ready: |state| {
        let name = state.selected_photo_name().ok_or("select a photo first")?;
        let session = state.session.as_ref().ok_or("open a project first")?;
        let decided = session.opened.project.decisions.photos.contains_key(&name);
        if decided { Ok(()) } else { Err("there are no decisions about this photo") }
    },
    request: |_| DecideRequest::Reset.into(),
    ..PLAIN
};

/// Removes the selected object from the model, in this project.
pub const SWITCH_OFF: Command = Command {
    name: "Remove object from model…",
    tooltip: "Asks first, then removes the selected object from the model in this project: photos, layers and views ignore it.",
    menu: Menu::Edit,
    starts_group: true,
    ready: |state| state.selected_object().map(|_| ()).ok_or("select an object or a face"),
    detail: Some(|state| Some(format!("({})", state.selected_object()?))),
    request: |state| DecideRequest::AskToRemove(state.selected_object().unwrap_or_default()).into(),
    ..PLAIN
};

/// Restores all removed objects.
pub const ALL_ON: Command = Command {
    name: "Restore all objects",
    tooltip: "Restores all objects that were removed from the model.",
    menu: Menu::Edit,
    ready: |state| {
        let session = state.session.as_ref().ok_or("open a project first")?;
        let any = !session.history.present().objects_off.is_empty();
        if any { Ok(()) } else { Err("no object is removed from the model") }
    },
    request: |_| DecideRequest::AllObjectsOn.into(),
    ..PLAIN
};

/// Returns the name of the selected photo, as it follows the name of a command.
fn photo_in_brackets(state: &State) -> Option<String> {
    Some(format!("({})", state.selected_photo_name()?))
}

fn history(
    state: &State,
    ready: fn(&quadratura_document::history::History) -> bool,
    why_not: WhyNot,
) -> Result<(), WhyNot> {
    let session = state.session.as_ref().ok_or("open a project first")?;
    // Imports are undone and redone one after the other.
    if state.running.runs(JobKind::Import) {
        return Err("wait until the import has ended");
    }
    if !state.masking.is_kept() {
        return Err("wait a moment: a mask is being saved");
    }
    if ready(&session.history) { Ok(()) } else { Err(why_not) }
}

fn with_surface_and_photo(state: &State) -> Result<(), WhyNot> {
    state.selected_photo().ok_or("select a photo first")?;
    match state.selection.main {
        Selection::Object(_) | Selection::Face(_) | Selection::Layer { .. } => Ok(()),
        Selection::Nothing | Selection::Photo(_) | Selection::Tree(_) | Selection::Trees => {
            Err("select an object, a face or an image layer")
        }
    }
}
