//! Commands on kept views, flights, and pictures of them.

use eframe::egui::Key;

use super::{Command, Menu, PLAIN, WhyNot, ctrl, plain, with_project};
use crate::app::editor::Editor;
use crate::app::jobs::Kind;

/// In the order of their menus.
pub const COMMANDS: &[&Command] = &[&PANEL, &KEEP, &ADD, &REMOVE, &PLAY, &STILL, &FILM];

const FLIGHT: Command = Command { menu: Menu::View, ready: with_project, ..PLAIN };

/// Shows or hides the panel.
pub const PANEL: Command = Command {
    name: "Views and flight",
    tooltip: "Shows or hides kept views and the line of time of the flight.",
    keys: &[plain(Key::T)],
    starts_group: true,
    on: Some(|editor| editor.flights.shown),
    run: |editor, _| editor.flights.shown ^= true,
    ..FLIGHT
};

/// Keeps the view.
pub const KEEP: Command = Command {
    name: "Keep this view",
    tooltip: "Keeps the view as it is, to come back to it.",
    keys: &[ctrl(Key::D)],
    run: |editor, _| editor.keep_view(),
    ..FLIGHT
};

/// A keyframe.
pub const ADD: Command = Command {
    name: "Add keyframe",
    tooltip: "The flight leads through this view.",
    keys: &[plain(Key::K)],
    run: |editor, _| editor.add_keyframe(),
    ..FLIGHT
};

/// No keyframe.
pub const REMOVE: Command = Command {
    name: "Remove keyframe",
    tooltip: "Takes the selected keyframe out of the flight.",
    ready: |editor| if editor.has_keyframe() { Ok(()) } else { Err("select a keyframe of the flight") },
    run: |editor, _| editor.remove_keyframe(),
    ..FLIGHT
};

/// Plays or pauses.
pub const PLAY: Command = Command {
    name: "Play flight",
    tooltip: "Plays the flight, or pauses it.",
    keys: &[plain(Key::Space)],
    ready: can_fly,
    on: Some(Editor::plays),
    run: |editor, _| editor.play(),
    ..FLIGHT
};

/// A picture.
pub const STILL: Command = Command {
    name: "Make a picture…",
    tooltip: "Renders the view in final quality, at any size.",
    ready: with_painter,
    run: |editor, _| editor.ask_still(),
    ..FLIGHT
};

/// A film.
pub const FILM: Command = Command {
    name: "Make a film…",
    tooltip: "Renders the flight in final quality, as pictures and as a film.",
    ready: |editor| with_painter(editor).and(can_fly(editor)),
    run: |editor, _| editor.ask_film(),
    ..FLIGHT
};

fn can_fly(editor: &Editor) -> Result<(), WhyNot> {
    if editor.can_fly() { Ok(()) } else { Err("add two keyframes first") }
}

fn with_painter(editor: &Editor) -> Result<(), WhyNot> {
    let session = editor.session.as_ref().ok_or("open a project first")?;
    if session.painter.is_some() {
        Ok(())
    } else if session.photos.iter().all(|photo| photo.stack.is_none()) {
        Err("build the layers first")
    } else if editor.jobs.runs(Kind::Preview) {
        Err("the 3D view is being prepared, wait a moment")
    } else {
        Err("the 3D view does not run; its place in the window says why")
    }
}
