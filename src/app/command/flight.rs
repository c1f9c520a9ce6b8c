//! Commands on bookmarks, flights, and pictures of them.

use eframe::egui::Key;

use super::{Command, Menu, PLAIN, WhyNot, ctrl, plain, with_project};
use crate::app::state::State;
use crate::app::state::ask::{Flag, FlightAsk, WindowAsk};
use crate::app::state::running::JobKind;

/// The commands in the order of their menus.
pub const COMMANDS: &[&Command] = &[&PANEL, &KEEP, &ADD, &REMOVE, &PLAY, &STILL, &FILM];

const FLIGHT: Command = Command { menu: Menu::View, ready: with_project, ..PLAIN };

/// Shows or hides the panel.
pub const PANEL: Command = Command {
    name: "Views and flight",
    tooltip: "Shows or hides kept views and the line of time of the flight.",
    keys: &[plain(Key::T)],
    starts_group: true,
    on: Some(|state| state.flights.shown),
    ask: |_| WindowAsk::Flip(Flag::Flight).into(),
    ..FLIGHT
};

/// Adds a bookmark of the view.
pub const KEEP: Command = Command {
    name: "Keep this view",
    tooltip: "Keeps the view as it is, to come back to it.",
    keys: &[ctrl(Key::D)],
    ask: |_| FlightAsk::KeepView.into(),
    ..FLIGHT
};

/// Adds a keyframe of the view.
pub const ADD: Command = Command {
    name: "Add keyframe",
    tooltip: "The flight leads through this view.",
    keys: &[plain(Key::K)],
    ask: |_| FlightAsk::AddKeyframe.into(),
    ..FLIGHT
};

/// Removes the selected keyframe.
pub const REMOVE: Command = Command {
    name: "Remove keyframe",
    tooltip: "Takes the selected keyframe out of the flight.",
    ready: |state| if state.has_keyframe() { Ok(()) } else { Err("select a keyframe of the flight") },
    ask: |_| FlightAsk::RemoveKeyframe.into(),
    ..FLIGHT
};

/// Plays or pauses the flight.
pub const PLAY: Command = Command {
    name: "Play flight",
    tooltip: "Plays the flight, or pauses it.",
    keys: &[plain(Key::Space)],
    ready: can_fly,
    on: Some(State::plays),
    ask: |_| FlightAsk::Play.into(),
    ..FLIGHT
};

/// Renders a picture of the view.
pub const STILL: Command = Command {
    name: "Make a picture…",
    tooltip: "Renders the view in final quality, at any size.",
    ready: with_painter,
    ask: |_| FlightAsk::ChooseStill.into(),
    ..FLIGHT
};

/// Renders a video of the flight.
pub const FILM: Command = Command {
    name: "Make a film…",
    tooltip: "Renders the flight in final quality, as pictures and as a film.",
    ready: |state| with_painter(state).and(can_fly(state)),
    ask: |_| FlightAsk::ChooseFilm.into(),
    ..FLIGHT
};

fn can_fly(state: &State) -> Result<(), WhyNot> {
    if state.can_fly() { Ok(()) } else { Err("add two keyframes first") }
}

fn with_painter(state: &State) -> Result<(), WhyNot> {
    let session = state.session.as_ref().ok_or("open a project first")?;
    if state.device.is_some() {
        Ok(())
    } else if session.photos.iter().all(|photo| photo.stack.is_none()) {
        Err("build the layers first")
    } else if state.running.runs(JobKind::Preview) {
        Err("the 3D view is being prepared, wait a moment")
    } else {
        Err("the 3D view does not run; its place in the window says why")
    }
}
