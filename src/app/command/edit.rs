//! Commands that change what was decided: steps back and forth, and decisions about layers.

use eframe::egui::{Key, KeyboardShortcut, Modifiers};

use super::{Command, Menu, PLAIN, WhyNot, ctrl, with_project};
use crate::app::editor::Editor;
use crate::app::jobs::Kind;
use crate::app::selection::Selection;

/// In the order of their menus.
pub const COMMANDS: &[&Command] =
    &[&SAVE, &UNDO, &REDO, &MERGE, &SPLIT, &PIN, &EXCLUDE, &RESET, &SWITCH_OFF, &ALL_ON];

const SHIFTED: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

/// Saves the project.
pub const SAVE: Command = Command {
    name: "Save",
    tooltip: "Saves what was decided; layers, fillings and paint are on disk always.",
    keys: &[ctrl(Key::S)],
    ready: |editor| {
        with_project(editor)?;
        if editor.is_dirty() { Ok(()) } else { Err("everything is saved") }
    },
    run: |editor, _| {
        editor.save_project();
    },
    ..PLAIN
};

/// One step back.
pub const UNDO: Command = Command {
    name: "Undo",
    tooltip: "Takes the last step back.",
    keys: &[ctrl(Key::Z)],
    menu: Menu::Edit,
    ready: |editor| match editor.masking.is_drawing() {
        true => Ok(()),
        false => history(editor, |history| history.undoes().is_some(), "there is nothing to undo"),
    },
    detail: Some(|editor| Some(editor.session.as_ref()?.history.undoes()?.to_owned())),
    // In the middle of a stroke that is the last step.
    run: |editor, _| {
        if !editor.masking.give_up() {
            editor.undo();
        }
    },
    ..PLAIN
};

/// One step forth.
pub const REDO: Command = Command {
    name: "Redo",
    tooltip: "Does the step again that was undone.",
    keys: &[KeyboardShortcut::new(SHIFTED, Key::Z), ctrl(Key::Y)],
    menu: Menu::Edit,
    ready: |editor| history(editor, |history| history.redoes().is_some(), "there is nothing to do again"),
    detail: Some(|editor| Some(editor.session.as_ref()?.history.redoes()?.to_owned())),
    run: |editor, _| editor.redo(),
    ..PLAIN
};

/// One image layer of several.
pub const MERGE: Command = Command {
    name: "Merge layers",
    tooltip: "The selected image layers of a photo become one, now and whenever it is built again.",
    keys: &[ctrl(Key::M)],
    menu: Menu::Edit,
    starts_group: true,
    ready: |editor| match editor.selected_layers().1.len() {
        0 | 1 => Err("select several image layers of one photo, with Ctrl"),
        _ => Ok(()),
    },
    run: |editor, _| editor.merge_layers(),
    ..PLAIN
};

/// Image layers of their own for what shares one.
pub const SPLIT: Command = Command {
    name: "Split layer",
    tooltip: "Every object of the selected image layer gets one of its own.",
    menu: Menu::Edit,
    ready: |editor| match editor.selection {
        Selection::Layer { .. } => Ok(()),
        _ => Err("select an image layer"),
    },
    run: |editor, _| editor.split_layer(),
    ..PLAIN
};

/// One photo alone.
pub const PIN: Command = Command {
    name: "Pin to this photo",
    tooltip: "The selected object or face shows this photo alone, wherever it shows it.",
    menu: Menu::Edit,
    starts_group: true,
    ready: with_surface_and_photo,
    run: |editor, _| editor.pin(),
    ..PLAIN
};

/// Not this photo.
pub const EXCLUDE: Command = Command {
    name: "Exclude this photo",
    tooltip: "The selected object or face never shows this photo.",
    menu: Menu::Edit,
    ready: with_surface_and_photo,
    run: |editor, _| editor.exclude(),
    ..PLAIN
};

/// No decisions.
pub const RESET: Command = Command {
    name: "Forget decisions about this photo",
    tooltip: "Merges, splits, names, pins and exclusions of the selected photo are taken back.",
    menu: Menu::Edit,
    ready: |editor| {
        let name = editor.selected_photo_name().ok_or("select a photo first")?;
        let session = editor.session.as_ref().ok_or("open a project first")?;
        let decided = session.opened.project.decisions.photos.contains_key(&name);
        if decided { Ok(()) } else { Err("nothing was decided about this photo") }
    },
    run: |editor, _| editor.reset_decisions(),
    ..PLAIN
};

/// Without this object.
pub const SWITCH_OFF: Command = Command {
    name: "Switch object off",
    tooltip: "Photos, layers and views are made as if the model did not have the selected object.",
    menu: Menu::Edit,
    starts_group: true,
    ready: |editor| editor.selected_object().map(|_| ()).ok_or("select an object or a face"),
    detail: Some(Editor::selected_object),
    run: |editor, _| {
        if let Some(object) = editor.selected_object() {
            editor.switch_object(&object, false);
        }
    },
    ..PLAIN
};

/// All objects again.
pub const ALL_ON: Command = Command {
    name: "Switch all objects on",
    tooltip: "Brings back all objects that are switched off.",
    menu: Menu::Edit,
    ready: |editor| {
        let session = editor.session.as_ref().ok_or("open a project first")?;
        let any = !session.history.present().objects_off.is_empty();
        if any { Ok(()) } else { Err("no object is switched off") }
    },
    run: |editor, _| editor.switch_all_on(),
    ..PLAIN
};

fn history(
    editor: &Editor,
    ready: fn(&crate::document::history::History) -> bool,
    why_not: WhyNot,
) -> Result<(), WhyNot> {
    let session = editor.session.as_ref().ok_or("open a project first")?;
    // Imports are taken back and made again one after the other.
    if editor.jobs.runs(Kind::Import) {
        return Err("wait until the import has ended");
    }
    if !editor.masking.is_kept() {
        return Err("wait a moment: a mask is being kept");
    }
    if ready(&session.history) { Ok(()) } else { Err(why_not) }
}

fn with_surface_and_photo(editor: &Editor) -> Result<(), WhyNot> {
    editor.selected_photo().ok_or("select a photo first")?;
    match editor.selection {
        Selection::Object(_) | Selection::Face(_) | Selection::Layer { .. } => Ok(()),
        Selection::Nothing | Selection::Photo(_) => Err("select an object, a face or an image layer"),
    }
}
