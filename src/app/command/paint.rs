//! Commands on what is painted: out to the image editor, and home.

use eframe::egui::{Key, KeyboardShortcut, Modifiers};

use super::{Command, Menu, PLAIN, WhyNot, ctrl, with_project};
use crate::app::editor::Editor;
use crate::app::jobs::Kind;

/// In the order of their menus.
pub const COMMANDS: &[&Command] =
    &[&EDIT, &EDIT_FRESH, &CHOOSE_EDITOR, &IMPORT, &TAKE_BACK, &EXPORT, &SHOW_EDITING];

const PAINT: Command = Command { menu: Menu::Paint, ready: with_project, ..PLAIN };

/// Opens the photo in the image editor.
pub const EDIT: Command = Command {
    name: "Edit in image editor",
    tooltip: "Opens the selected photo's layers in the image editor; what you save there comes home by itself.",
    keys: &[ctrl(Key::E)],
    ready: can_export_photo,
    run: |editor, _| editor.edit_photo(false),
    ..PAINT
};

/// Opens a new export of the photo.
pub const EDIT_FRESH: Command = Command {
    name: "Edit a new export",
    tooltip: "Opens the selected photo's layers as they are now, with all paint, instead of the file begun before.",
    ready: can_export_photo,
    run: |editor, _| editor.edit_photo(true),
    ..PAINT
};

/// Chooses the image editor.
pub const CHOOSE_EDITOR: Command = Command {
    name: "Choose image editor…",
    tooltip: "Chooses among the image editors that are installed, or another program.",
    ready: super::always,
    run: |editor, _| editor.trip.choosing_editor ^= true,
    ..PAINT
};

/// Imports edited files.
pub const IMPORT: Command = Command {
    name: "Import edited files…",
    tooltip: "Takes home what was painted on exported files.",
    keys: &[ctrl(Key::I)],
    starts_group: true,
    run: |editor, _| editor.choose_imports(),
    ..PAINT
};

/// Takes the last import back.
pub const TAKE_BACK: Command = Command {
    name: "Take back import",
    tooltip: "Makes all paint as it was before the last import; the files stay as they are.",
    ready: can_take_back,
    run: |editor, _| editor.take_back_last(),
    ..PAINT
};

/// Exports photos.
pub const EXPORT: Command = Command {
    name: "Export…",
    tooltip: "Writes photos with their layers as files for image editors.",
    keys: &[KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::E)],
    starts_group: true,
    ready: |editor| can_export(editor),
    run: |editor, _| editor.choose_export(),
    ..PAINT
};

/// Shows the folder of documents that are painted on.
pub const SHOW_EDITING: Command = Command {
    name: "Show painted files",
    tooltip: "Shows the folder of the files that you paint on in the system's file manager.",
    ready: |editor| match editor.editing_folder() {
        Some(_) => Ok(()),
        None => Err("nothing was opened in an image editor yet"),
    },
    run: |editor, _| {
        if let Some(folder) = editor.editing_folder() {
            editor.show_folder(&folder);
        }
    },
    ..PAINT
};

fn can_export(editor: &Editor) -> Result<(), WhyNot> {
    let session = editor.session.as_ref().ok_or("open a project first")?;
    if session.photos.iter().all(|photo| photo.stack.is_none()) {
        return Err("build the layers first");
    }
    let writes = [Kind::Build, Kind::Fill, Kind::Export].into_iter().any(|kind| editor.jobs.runs(kind));
    if writes { Err("wait until the job that runs has ended, or stop it") } else { Ok(()) }
}

fn can_export_photo(editor: &Editor) -> Result<(), WhyNot> {
    can_export(editor)?;
    let place = editor.selected_photo().ok_or("select a photo first")?;
    let built = editor.session.as_ref().is_some_and(|session| session.photos[place].stack.is_some());
    if built { Ok(()) } else { Err("build the layers of this photo first") }
}

fn can_take_back(editor: &Editor) -> Result<(), WhyNot> {
    with_project(editor)?;
    if editor.trip.history.is_empty() {
        return Err("there is no import to take back");
    }
    if editor.jobs.runs(Kind::Import) { Err("wait until the import has ended") } else { Ok(()) }
}
