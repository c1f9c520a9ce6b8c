//! Commands on projects and on the program.

use eframe::egui::{Context, Key};

use super::{Command, Menu, PLAIN, WhyNot, ctrl, plain, with_project};
use crate::app::editor::Editor;
use crate::app::leaving::Leaving;
use crate::app::opening::Purpose;
use crate::app::settings::Colours;

/// In the order of their menus.
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

/// The assistant for new projects.
pub const NEW: Command = Command {
    name: "New project…",
    tooltip: "Makes a project of photos, cameras and a model: a folder is enough, what is in it is found by itself.",
    keys: &[ctrl(Key::N)],
    run: |editor, _| editor.start_assistant(None),
    ..PLAIN
};

/// Asks for a project's folder.
pub const OPEN: Command = Command {
    name: "Open project…",
    tooltip: "Opens the folder of a project.",
    keys: &[ctrl(Key::O)],
    run: |editor, _| editor.choose(Purpose::Project),
    ..PLAIN
};

/// Closes the project.
pub const CLOSE: Command = Command {
    name: "Close project",
    tooltip: "Closes the project; asks where something is not saved.",
    keys: &[ctrl(Key::W)],
    ready: with_project,
    run: |editor, _| editor.leave(Leaving::Close),
    ..PLAIN
};

/// Ends the program.
pub const QUIT: Command = Command {
    name: "Quit",
    tooltip: "Ends the program.",
    keys: &[ctrl(Key::Q)],
    starts_group: true,
    run: |editor, _| editor.leave(Leaving::Quit),
    ..PLAIN
};

/// What has changed on disk while the project was open.
pub const READ_AGAIN: Command = Command {
    name: "Read files again",
    tooltip: "Reads photos, cameras and model again, as they are on disk now; decisions stay.",
    keys: &[plain(Key::F5)],
    ready: |editor| match editor.jobs.is_idle() {
        true => with_project(editor),
        false => Err("wait until the job that runs has ended, or stop it"),
    },
    run: |editor, _| editor.reopen(None),
    ..PLAIN
};

/// Files that are not where they were.
pub const MISSING: Command = Command {
    name: "Missing files…",
    tooltip: "Shows which files of the project are not where they were, and finds them again.",
    ready: with_problems,
    run: |editor, _| editor.show_missing(),
    ..PLAIN
};

/// The settings.
pub const SETTINGS: Command = Command {
    name: "Settings…",
    tooltip: "Shows colours, sizes, and what the mouse does.",
    keys: &[ctrl(Key::Comma)],
    starts_group: true,
    on: Some(|editor| editor.settings_shown),
    in_dialog: |editor| editor.settings_shown,
    run: |editor, _| editor.settings_shown ^= true,
    ..PLAIN
};

/// Shows or hides the palette.
pub const PALETTE: Command = Command {
    name: "Command palette",
    tooltip: "Finds any command by a few letters of its name.",
    keys: &[ctrl(Key::P)],
    menu: Menu::Window,
    in_dialog: |editor| editor.palette.is_open(),
    run: |editor, _| editor.palette.toggle(),
    ..PLAIN
};

/// Shows or hides the notes.
pub const NOTES: Command = Command {
    name: "Notes",
    tooltip: "Shows or hides what the program has to say, and the jobs that run.",
    keys: &[ctrl(Key::J)],
    menu: Menu::Window,
    on: Some(|editor| editor.settings.notes_shown),
    run: |editor, _| editor.settings.notes_shown ^= true,
    ..PLAIN
};

/// Photos and lists on the left.
pub const LISTS: Command = Command {
    name: "Lists on the left",
    tooltip: "Shows or hides the left side, with the photos, the layers and the objects.",
    keys: &[plain(Key::F6)],
    menu: Menu::Window,
    ready: with_project,
    on: Some(|editor| editor.settings.lists_shown),
    run: |editor, _| editor.settings.lists_shown ^= true,
    ..PLAIN
};

/// The right side.
pub const SIDE: Command = Command {
    name: "Panels on the right",
    tooltip: "Shows or hides the right side, with the selection, filling, colour and paint.",
    keys: &[plain(Key::F7)],
    menu: Menu::Window,
    ready: with_project,
    on: Some(|editor| editor.settings.side_shown),
    run: |editor, _| editor.settings.side_shown ^= true,
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
            on: Some(|editor| editor.settings.colours == Colours::$colours),
            run: |editor, context| {
                editor.settings.colours = Colours::$colours;
                editor.settings.apply_to(context);
            },
            ..PLAIN
        };
    };
}

theme!(DARK, Dark, "Theme: dark", "Light text on dark.", true);
theme!(LIGHT, Light, "Theme: light", "Dark text on light.", false);
theme!(AS_SYSTEM, System, "Theme: as the system", "Dark or light, as the system has it.", false);

/// Everything larger.
pub const LARGER: Command = Command {
    name: "Larger",
    tooltip: "Makes text and buttons larger.",
    keys: &[ctrl(Key::Plus), ctrl(Key::Equals)],
    menu: Menu::Window,
    starts_group: true,
    in_dialog: |_| true,
    run: |editor, context| resize(editor, context, 1.0),
    ..PLAIN
};

/// Everything smaller.
pub const SMALLER: Command = Command {
    name: "Smaller",
    tooltip: "Makes text and buttons smaller.",
    keys: &[ctrl(Key::Minus)],
    menu: Menu::Window,
    in_dialog: |_| true,
    run: |editor, context| resize(editor, context, -1.0),
    ..PLAIN
};

/// Everything as large as the system has it.
pub const USUAL: Command = Command {
    name: "Usual size",
    tooltip: "Makes text and buttons as large as the system has them.",
    keys: &[ctrl(Key::Num0)],
    menu: Menu::Window,
    in_dialog: |_| true,
    run: |editor, context| {
        editor.settings.scale = 1.0;
        editor.settings.apply_to(context);
    },
    ..PLAIN
};

/// The layout as it was at first.
pub const LAYOUT: Command = Command {
    name: "Reset layout",
    tooltip: "Puts all views and panels back to where they were at first.",
    menu: Menu::Window,
    run: |editor, context| editor.reset_layout(context),
    ..PLAIN
};

/// Keys and mouse.
pub const KEYS: Command = Command {
    name: "Keys and mouse",
    tooltip: "Shows what keys and mouse do.",
    keys: &[plain(Key::F1)],
    menu: Menu::Window,
    on: Some(|editor| editor.help_shown),
    run: |editor, _| editor.help_shown ^= true,
    ..PLAIN
};

fn resize(editor: &mut Editor, context: &Context, steps: f32) {
    editor.settings.resize(steps);
    editor.settings.apply_to(context);
}

/// Something of the project could not be read.
fn with_problems(editor: &Editor) -> Result<(), WhyNot> {
    with_project(editor)?;
    let complete = editor.session.as_ref().is_some_and(|session| !session.incomplete);
    if complete { Err("nothing is missing") } else { Ok(()) }
}
