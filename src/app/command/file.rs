//! Commands on projects and on the program.

use eframe::egui::{Key, KeyboardShortcut, Modifiers};

use super::{Command, Menu, PLAIN, WhyNot, ctrl, flight, images, paint, plain, with_project};
use crate::state::State;
use crate::state::guide::Document;
use crate::state::life::{Goal, LifeEvent};
use crate::state::opening::{DialogRequest, Purpose};
use crate::state::request::{Flag, JobRequest, ProjectRequest, Request, WindowRequest};
use crate::state::running::JobKind;
use crate::state::session::Session;
use crate::state::settings::Colours;

/// The commands in the order of their menus.
pub const COMMANDS: &[&Command] = &[
    &NEW,
    &OPEN,
    &SAVE,
    &SAVE_COPY,
    &CLOSE,
    &paint::IMPORT,
    &paint::EXPORT,
    &images::SAVE,
    &images::PAGE,
    &images::PUBLISH,
    &images::ORTHOPHOTO,
    &flight::STILL,
    &flight::FILM,
    &READ_AGAIN,
    &MISSING,
    &SETTINGS,
    &QUIT,
    &PALETTE,
    &NOTES,
    &LISTS,
    &SIDE,
    &DARK,
    &LIGHT,
    &AS_SYSTEM,
    &LARGER,
    &SMALLER,
    &USUAL,
    &LAYOUT,
    &KEYS,
    &SAMPLE,
    &GUIDE,
    &WINDOW,
    &EDITING,
    &PLANTS,
    &GLOSSARY,
    &FORMATS,
    &METHOD,
    &ABOUT,
    &DIAGNOSTICS,
];

/// Opens the assistant for new projects.
pub const NEW: Command = Command {
    name: "New project…",
    tooltip: "Creates a project from photos, cameras and a model. A folder is enough: its contents are detected \
              automatically.",
    keys: &[ctrl(Key::N)],
    request: |_| dialog(DialogRequest::New(None)),
    ..PLAIN
};

/// Asks for a project folder and opens it.
pub const OPEN: Command = Command {
    name: "Open project…",
    tooltip: "Opens a project folder.",
    keys: &[ctrl(Key::O)],
    request: |_| dialog(DialogRequest::Choose(Purpose::Project)),
    ..PLAIN
};

/// Saves the project.
pub const SAVE: Command = Command {
    name: "Save",
    tooltip: "Saves decisions; layers, fillings and paint are always on disk.",
    keys: &[ctrl(Key::S)],
    starts_group: true,
    ready: |state| {
        with_project(state)?;
        if state.is_dirty() { Ok(()) } else { Err("there are no unsaved changes") }
    },
    request: |_| ProjectRequest::Save.into(),
    ..PLAIN
};

/// Copies the project to another folder.
pub const SAVE_COPY: Command = Command {
    name: "Save a copy…",
    tooltip: "Copies the project to another folder, with unsaved changes; this project stays open.",
    keys: &[KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::S)],
    ready: can_copy,
    request: |_| dialog(DialogRequest::Copy),
    ..PLAIN
};

/// Closes the project.
pub const CLOSE: Command = Command {
    name: "Close project",
    tooltip: "Closes the project; asks first if there are unsaved changes.",
    keys: &[ctrl(Key::W)],
    ready: with_project,
    request: |_| ProjectRequest::Life(LifeEvent::Leave(Goal::Close)).into(),
    ..PLAIN
};

/// Ends the program.
pub const QUIT: Command = Command {
    name: "Quit",
    tooltip: "Quits the program.",
    keys: &[ctrl(Key::Q)],
    starts_group: true,
    request: |_| ProjectRequest::Life(LifeEvent::Leave(Goal::Quit)).into(),
    ..PLAIN
};

/// Reads files again that have changed on disk while the project was open.
pub const READ_AGAIN: Command = Command {
    name: "Reload from disk",
    tooltip: "Reloads photos, cameras and model from disk; decisions are kept.",
    keys: &[plain(Key::F5)],
    starts_group: true,
    ready: with_project,
    request: |_| JobRequest::Reread(None).into(),
    ..PLAIN
};

/// Shows the files that are missing.
pub const MISSING: Command = Command {
    name: "Missing files…",
    tooltip: "Lists files of the project that are missing, and helps to locate them.",
    ready: with_problems,
    request: |_| ProjectRequest::ShowMissing.into(),
    ..PLAIN
};

/// Shows or hides the settings.
pub const SETTINGS: Command = Command {
    name: "Settings…",
    tooltip: "Sets the theme, the size of text and buttons, and the mouse controls.",
    keys: &[ctrl(Key::Comma)],
    starts_group: true,
    on: Some(|state| state.dialogs.settings),
    in_dialog: |state| state.dialogs.settings,
    request: |_| WindowRequest::Flip(Flag::Settings).into(),
    ..PLAIN
};

/// Shows or hides the command palette.
pub const PALETTE: Command = Command {
    name: "Command palette",
    tooltip: "Finds any command by a few letters of its name.",
    keys: &[ctrl(Key::P)],
    menu: Menu::Window,
    in_dialog: |state| state.dialogs.palette.is_open(),
    request: |_| WindowRequest::Palette.into(),
    ..PLAIN
};

/// Shows or hides the messages.
pub const NOTES: Command = Command {
    name: "Messages",
    tooltip: "Shows or hides messages and running jobs.",
    keys: &[ctrl(Key::J)],
    menu: Menu::Window,
    on: Some(|state| state.settings.notes_shown),
    request: |_| WindowRequest::Flip(Flag::Notes).into(),
    ..PLAIN
};

/// Shows or hides the photos and lists on the left.
pub const LISTS: Command = Command {
    name: "Lists on the left",
    tooltip: "Shows or hides the left side, with the photos, the layers and the objects.",
    keys: &[plain(Key::F6)],
    menu: Menu::Window,
    ready: with_project,
    on: Some(|state| state.settings.lists_shown),
    request: |_| WindowRequest::Flip(Flag::Lists).into(),
    ..PLAIN
};

/// Shows or hides the right side.
pub const SIDE: Command = Command {
    name: "Panels on the right",
    tooltip: "Shows or hides the right side, with the selection, filling, colour and paint.",
    keys: &[plain(Key::F7)],
    menu: Menu::Window,
    ready: with_project,
    on: Some(|state| state.settings.side_shown),
    request: |_| WindowRequest::Flip(Flag::Side).into(),
    ..PLAIN
};

macro_rules! theme {
    ($constant:ident, $colours:ident, $name:literal, $tooltip:literal, $starts_group:literal) => {
        #[doc = $tooltip]
        pub const $constant: Command = Command {
            name: $name,
            tooltip: $tooltip,
            menu: Menu::Window,
            starts_group: $starts_group,
            on: Some(|state| state.settings.colours == Colours::$colours),
            request: |_| WindowRequest::Theme(Colours::$colours).into(),
            ..PLAIN
        };
    };
}

theme!(DARK, Dark, "Theme: dark", "Light text on dark.", true);
theme!(LIGHT, Light, "Theme: light", "Dark text on light.", false);
theme!(AS_SYSTEM, System, "Theme: system", "Follows the system's theme.", false);

/// Makes the interface larger.
pub const LARGER: Command = Command {
    name: "Larger interface",
    tooltip: "Makes text and buttons larger.",
    keys: &[ctrl(Key::Plus), ctrl(Key::Equals)],
    menu: Menu::Window,
    starts_group: true,
    in_dialog: |_| true,
    request: |_| WindowRequest::Resize(1.0).into(),
    ..PLAIN
};

/// Makes the interface smaller.
pub const SMALLER: Command = Command {
    name: "Smaller interface",
    tooltip: "Makes text and buttons smaller.",
    keys: &[ctrl(Key::Minus)],
    menu: Menu::Window,
    in_dialog: |_| true,
    request: |_| WindowRequest::Resize(-1.0).into(),
    ..PLAIN
};

/// Resets the interface to the system's size.
pub const USUAL: Command = Command {
    name: "Default interface size",
    tooltip: "Restores the system's size of text and buttons.",
    keys: &[ctrl(Key::Num0)],
    menu: Menu::Window,
    in_dialog: |_| true,
    request: |_| WindowRequest::UsualSize.into(),
    ..PLAIN
};

/// Resets the layout.
pub const LAYOUT: Command = Command {
    name: "Reset layout",
    tooltip: "Restores the default layout of all views and panels.",
    menu: Menu::Window,
    request: |_| WindowRequest::ResetLayout.into(),
    ..PLAIN
};

/// Shows the keys and mouse buttons.
pub const KEYS: Command = Command {
    name: "Keys and mouse",
    tooltip: "Shows the functions of keys and mouse.",
    keys: &[plain(Key::F1)],
    menu: Menu::Help,
    on: Some(|state| state.dialogs.help),
    request: |_| WindowRequest::Flip(Flag::Help).into(),
    ..PLAIN
};

/// Copies the sample project and opens it.
pub const SAMPLE: Command = Command {
    name: "Open sample project…",
    tooltip: "Copies a small project, an invented square, to a folder that you choose, and opens it.",
    menu: Menu::Help,
    request: |_| dialog(DialogRequest::Sample),
    ..PLAIN
};

macro_rules! document {
    ($constant:ident, $tooltip:literal, $starts_group:literal) => {
        #[doc = $tooltip]
        pub const $constant: Command = Command {
            name: Document::$constant.name,
            tooltip: $tooltip,
            menu: Menu::Help,
            starts_group: $starts_group,
            request: |_| WindowRequest::Read(Document::$constant).into(),
            ..PLAIN
        };
    };
}

document!(GUIDE, "Opens the guide from photos to painted layers and novel views in the browser.", true);
document!(WINDOW, "Opens the document on this window in the browser.", false);
document!(EDITING, "Opens the document on painting in image editors in the browser.", false);
document!(PLANTS, "Opens the document on trees and plants in the browser.", false);
document!(GLOSSARY, "Opens the list of words in the browser.", false);
document!(FORMATS, "Opens the document on files and formats in the browser.", false);
document!(METHOD, "Opens the document on the method in the browser.", false);

/// Shows the program's name and version.
pub const ABOUT: Command = Command {
    name: "About Quadratura",
    tooltip: "Shows the program's version, its licence and the graphics device.",
    menu: Menu::Help,
    starts_group: true,
    on: Some(|state| state.dialogs.about),
    request: |_| WindowRequest::Flip(Flag::About).into(),
    ..PLAIN
};

/// Copies facts for a report of a fault.
pub const DIAGNOSTICS: Command = Command {
    name: "Copy diagnostics",
    tooltip: "Copies version, system, graphics device, the size of the project and all messages to the clipboard.",
    menu: Menu::Help,
    request: |_| WindowRequest::CopyDiagnostics.into(),
    ..PLAIN
};

fn dialog(request: DialogRequest) -> Request {
    ProjectRequest::Dialog(request).into()
}

/// Succeeds when no job writes what a copy would contain.
fn can_copy(state: &State) -> Result<(), WhyNot> {
    with_project(state)?;
    // An update in the background stops for it.
    let writes = state.running.writing().next().is_some() || state.running.runs(JobKind::Mask);
    if writes { Err("wait until the running job has ended, or stop it") } else { Ok(()) }
}

/// Succeeds when some of the project's files could not be read.
fn with_problems(state: &State) -> Result<(), WhyNot> {
    with_project(state)?;
    let is_complete = |session: &Session| !session.incomplete && session.missing_since().next().is_none();
    let complete = state.session.as_ref().is_some_and(is_complete);
    if complete { Err("no files are missing") } else { Ok(()) }
}
