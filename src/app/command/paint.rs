//! Commands on paint: export to the image editor, and import.

use eframe::egui::{Key, KeyboardShortcut, Modifiers};

use super::{Command, Menu, PLAIN, WhyNot, ctrl, with_project};
use crate::state::State;
use crate::state::request::{Flag, RoundTripRequest, WindowRequest};
use crate::state::running::JobKind;
use crate::state::session::Session;

/// The commands in the order of their menus.
pub const COMMANDS: &[&Command] = &[&EDIT, &EDIT_FRESH, &CHOOSE_EDITOR, &TAKE_BACK, &SHOW_EDITING];

const PAINT: Command = Command { menu: Menu::Paint, ready: with_project, ..PLAIN };

/// Opens the photo in the image editor.
pub const EDIT: Command = Command {
    name: "Edit in image editor",
    tooltip: "Opens the selected photo's layers in the image editor; what you save there is imported automatically.",
    keys: &[ctrl(Key::E)],
    ready: can_export_photo,
    request: |_| RoundTripRequest::EditPhoto { fresh: false }.into(),
    ..PAINT
};

/// Opens a new export of the photo in the image editor.
pub const EDIT_FRESH: Command = Command {
    name: "Edit a new export",
    tooltip: "Opens a new export of the selected photo's layers, with all paint, instead of the previous file.",
    ready: can_export_photo,
    request: |_| RoundTripRequest::EditPhoto { fresh: true }.into(),
    ..PAINT
};

/// Chooses the image editor.
pub const CHOOSE_EDITOR: Command = Command {
    name: "Choose image editor…",
    tooltip: "Chooses one of the installed image editors, or another program.",
    ready: super::always,
    request: |_| WindowRequest::Flip(Flag::ImageEditor).into(),
    ..PAINT
};

/// Imports edited files.
pub const IMPORT: Command = Command {
    name: "Import edited files…",
    tooltip: "Imports what was painted on exported files.",
    keys: &[ctrl(Key::I)],
    starts_group: true,
    menu: Menu::File,
    request: |_| RoundTripRequest::ChooseImports.into(),
    ..PAINT
};

/// Undoes the last import.
pub const TAKE_BACK: Command = Command {
    name: "Undo import",
    tooltip: "Restores all paint as it was before the last import; the files do not change.",
    starts_group: true,
    ready: can_take_back,
    request: |_| RoundTripRequest::TakeBackLast.into(),
    ..PAINT
};

/// Exports photos.
pub const EXPORT: Command = Command {
    name: "Export…",
    tooltip: "Writes photos with their layers as files for image editors (PSD, XCF, OpenRaster, folders of PNG), the site for other \
              programs (Blender, GLB, OBJ, USD, OpenEXR, Nuke, cameras), layered depth images, pages for browsers, and orthophotos.",
    keys: &[KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::E)],
    menu: Menu::File,
    ready: |state| can_export(state),
    request: |_| RoundTripRequest::ChooseExport.into(),
    ..PAINT
};

/// Shows the folder of the documents that are being edited.
pub const SHOW_EDITING: Command = Command {
    name: "Show painted files",
    tooltip: "Shows the folder of the edited files in the system's file manager.",
    ready: |state| match state.session.as_ref().and_then(Session::editing_folder) {
        Some(_) => Ok(()),
        None => Err("no photo was opened in an image editor yet"),
    },
    request: |state| {
        RoundTripRequest::ShowFolder(
            state.session.as_ref().and_then(Session::editing_folder).unwrap_or_default(),
        )
        .into()
    },
    ..PAINT
};

/// Succeeds when some photo has layers and nothing writes them.
pub(super) fn can_export(state: &State) -> Result<(), WhyNot> {
    let session = state.session.as_ref().ok_or("open a project first")?;
    if session.photos.iter().all(|photo| photo.stack.is_none()) {
        return Err("build the layers first");
    }
    let writes =
        [JobKind::Build, JobKind::Fill, JobKind::Export].into_iter().any(|kind| state.running.runs(kind));
    if writes { Err("wait until the running job has ended, or stop it") } else { Ok(()) }
}

/// Succeeds when the selected photo has layers and nothing writes them.
pub(super) fn can_export_photo(state: &State) -> Result<(), WhyNot> {
    can_export(state)?;
    let index = state.selected_photo().ok_or("select a photo first")?;
    let built = state.session.as_ref().is_some_and(|session| session.stack_of(index).is_some());
    if built { Ok(()) } else { Err("build the layers of this photo first") }
}

fn can_take_back(state: &State) -> Result<(), WhyNot> {
    with_project(state)?;
    if state.round_trip.history.is_empty() {
        return Err("there is no import to undo");
    }
    if state.running.runs(JobKind::Import) { Err("wait until the import has ended") } else { Ok(()) }
}
