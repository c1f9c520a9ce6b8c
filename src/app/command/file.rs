//! Commands on projects and on the program.

use eframe::egui::{Context, Key};

use super::{Command, Menu, PLAIN, ctrl, plain, with_project};
use crate::app::editor::Editor;
use crate::app::leaving::Leaving;

/// In the order of their menus.
pub const COMMANDS: &[&Command] = &[&OPEN, &CLOSE, &QUIT, &PALETTE, &NOTES, &DARK, &LAYOUT, &KEYS];

/// Asks for a project's folder.
pub const OPEN: Command = Command {
    name: "Open project…",
    tooltip: "Opens the folder of a project.",
    keys: &[ctrl(Key::O)],
    run: |editor, _| editor.choose_project(),
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

/// Shows or hides the palette.
pub const PALETTE: Command = Command {
    name: "Command palette",
    tooltip: "Finds any command by a few letters of its name.",
    keys: &[ctrl(Key::P)],
    menu: Menu::Window,
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

/// Light or dark.
pub const DARK: Command = Command {
    name: "Dark",
    tooltip: "Switches between light and dark.",
    menu: Menu::Window,
    starts_group: true,
    on: Some(|editor| editor.settings.dark),
    run: switch_theme,
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

fn switch_theme(editor: &mut Editor, context: &Context) {
    editor.settings.dark ^= true;
    editor.settings.apply_to(context);
}
