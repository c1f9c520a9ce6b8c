//! Commands on projects and on the program.

use eframe::egui::Key;

use super::{Command, Menu, PLAIN, WhyNot, ctrl, plain, with_project};
use crate::app::state::State;
use crate::app::state::ask::{Ask, BuildAsk, Flag, ProjectAsk, WindowAsk};
use crate::app::state::life::{Goal, LifeEvent};
use crate::app::state::opening::{DialogRequest, Purpose};
use crate::app::state::settings::Colours;

/// The commands in the order of their menus.
pub const COMMANDS: &[&Command] = &[
    &NEW,
    &OPEN,
    &CLOSE,
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
];

/// Opens the assistant for new projects.
pub const NEW: Command = Command {
    name: "New project…",
    tooltip: "Makes a project of photos, cameras and a model: a folder is enough, what is in it is found by itself.",
    keys: &[ctrl(Key::N)],
    ask: |_| dialog(DialogRequest::New(None)),
    ..PLAIN
};

/// Asks for a project folder and opens it.
pub const OPEN: Command = Command {
    name: "Open project…",
    tooltip: "Opens the folder of a project.",
    keys: &[ctrl(Key::O)],
    ask: |_| dialog(DialogRequest::Choose(Purpose::Project)),
    ..PLAIN
};

/// Closes the project.
pub const CLOSE: Command = Command {
    name: "Close project",
    tooltip: "Closes the project; asks where something is not saved.",
    keys: &[ctrl(Key::W)],
    ready: with_project,
    ask: |_| ProjectAsk::Life(LifeEvent::Leave(Goal::Close)).into(),
    ..PLAIN
};

/// Ends the program.
pub const QUIT: Command = Command {
    name: "Quit",
    tooltip: "Ends the program.",
    keys: &[ctrl(Key::Q)],
    starts_group: true,
    ask: |_| ProjectAsk::Life(LifeEvent::Leave(Goal::Quit)).into(),
    ..PLAIN
};

/// Reads files again that have changed on disk while the project was open.
pub const READ_AGAIN: Command = Command {
    name: "Read files again",
    tooltip: "Reads photos, cameras and model again, as they are on disk now; decisions stay.",
    keys: &[plain(Key::F5)],
    ready: |state| match state.running.is_idle() {
        true => with_project(state),
        false => Err("wait until the job that runs has ended, or stop it"),
    },
    ask: |_| BuildAsk::Reread(None).into(),
    ..PLAIN
};

/// Shows the files that are missing.
pub const MISSING: Command = Command {
    name: "Missing files…",
    tooltip: "Shows which files of the project are not where they were, and finds them again.",
    ready: with_problems,
    ask: |_| ProjectAsk::ShowMissing.into(),
    ..PLAIN
};

/// Shows or hides the settings.
pub const SETTINGS: Command = Command {
    name: "Settings…",
    tooltip: "Shows colours, sizes, and what the mouse does.",
    keys: &[ctrl(Key::Comma)],
    starts_group: true,
    on: Some(|state| state.settings_shown),
    in_dialog: |state| state.settings_shown,
    ask: |_| WindowAsk::Flip(Flag::Settings).into(),
    ..PLAIN
};

/// Shows or hides the command palette.
pub const PALETTE: Command = Command {
    name: "Command palette",
    tooltip: "Finds any command by a few letters of its name.",
    keys: &[ctrl(Key::P)],
    menu: Menu::Window,
    in_dialog: |state| state.palette.is_open(),
    ask: |_| WindowAsk::Palette.into(),
    ..PLAIN
};

/// Shows or hides the messages.
pub const NOTES: Command = Command {
    name: "Notes",
    tooltip: "Shows or hides what the program has to say, and the jobs that run.",
    keys: &[ctrl(Key::J)],
    menu: Menu::Window,
    on: Some(|state| state.settings.notes_shown),
    ask: |_| WindowAsk::Flip(Flag::Notes).into(),
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
    ask: |_| WindowAsk::Flip(Flag::Lists).into(),
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
    ask: |_| WindowAsk::Flip(Flag::Side).into(),
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
            ask: |_| WindowAsk::Theme(Colours::$colours).into(),
            ..PLAIN
        };
    };
}

theme!(DARK, Dark, "Theme: dark", "Light text on dark.", true);
theme!(LIGHT, Light, "Theme: light", "Dark text on light.", false);
theme!(AS_SYSTEM, System, "Theme: as the system", "Dark or light, as the system has it.", false);

/// Makes the interface larger.
pub const LARGER: Command = Command {
    name: "Larger",
    tooltip: "Makes text and buttons larger.",
    keys: &[ctrl(Key::Plus), ctrl(Key::Equals)],
    menu: Menu::Window,
    starts_group: true,
    in_dialog: |_| true,
    ask: |_| WindowAsk::Resize(1.0).into(),
    ..PLAIN
};

/// Makes the interface smaller.
pub const SMALLER: Command = Command {
    name: "Smaller",
    tooltip: "Makes text and buttons smaller.",
    keys: &[ctrl(Key::Minus)],
    menu: Menu::Window,
    in_dialog: |_| true,
    ask: |_| WindowAsk::Resize(-1.0).into(),
    ..PLAIN
};

/// Resets the interface to the system's size.
pub const USUAL: Command = Command {
    name: "Usual size",
    tooltip: "Makes text and buttons as large as the system has them.",
    keys: &[ctrl(Key::Num0)],
    menu: Menu::Window,
    in_dialog: |_| true,
    ask: |_| WindowAsk::UsualSize.into(),
    ..PLAIN
};

/// Resets the layout.
pub const LAYOUT: Command = Command {
    name: "Reset layout",
    tooltip: "Puts all views and panels back to where they were at first.",
    menu: Menu::Window,
    ask: |_| WindowAsk::ResetLayout.into(),
    ..PLAIN
};

/// Shows the keys and mouse buttons.
pub const KEYS: Command = Command {
    name: "Keys and mouse",
    tooltip: "Shows what keys and mouse do.",
    keys: &[plain(Key::F1)],
    menu: Menu::Window,
    on: Some(|state| state.help_shown),
    ask: |_| WindowAsk::Flip(Flag::Help).into(),
    ..PLAIN
};

fn dialog(request: DialogRequest) -> Ask {
    ProjectAsk::Dialog(request).into()
}

/// Succeeds when some of the project's files could not be read.
fn with_problems(state: &State) -> Result<(), WhyNot> {
    with_project(state)?;
    let complete = state.session.as_ref().is_some_and(|session| !session.incomplete);
    if complete { Err("nothing is missing") } else { Ok(()) }
}
