//! Commands on bookmarks, flights, and pictures of them.

use eframe::egui::Key;

use super::{Command, KeysIn, Menu, PLAIN, WhyNot, ctrl, plain, with_project};
use crate::state::State;
use crate::state::request::{Flag, FlightRequest, WindowRequest};
use crate::state::running::JobKind;

/// The commands in the order of their menus.
pub const COMMANDS: &[&Command] = &[&PANEL, &KEEP, &ADD, &REMOVE, &PLAY];

const FLIGHT: Command = Command { menu: Menu::View, ready: with_project, ..PLAIN };

/// Shows or hides the panel.
pub const PANEL: Command = Command {
    name: "Bookmarks and flight",
    tooltip: "Shows or hides bookmarks and the timeline of the flight.",
    keys: &[plain(Key::T)],
    starts_group: true,
    on: Some(|state| state.flights.shown),
    request: |_| WindowRequest::Flip(Flag::Flight).into(),
    ..FLIGHT
};

/// Adds a bookmark of the view.
pub const KEEP: Command = Command {
    name: "Add bookmark",
    tooltip: "Saves the current viewpoint as a bookmark.",
    keys: &[ctrl(Key::D)],
    request: |_| FlightRequest::KeepView.into(),
    ..FLIGHT
};

/// Adds a keyframe of the view.
pub const ADD: Command = Command {
    name: "Add keyframe",
    tooltip: "Adds the current viewpoint to the flight as a keyframe.",
    keys: &[plain(Key::K)],
    keys_in: KeysIn::Space,
    request: |_| FlightRequest::AddKeyframe.into(),
    ..FLIGHT
};

/// Removes the selected keyframe.
pub const REMOVE: Command = Command {
    name: "Remove keyframe",
    tooltip: "Removes the selected keyframe from the flight.",
    ready: |state| if state.has_keyframe() { Ok(()) } else { Err("select a keyframe of the flight") },
    request: |_| FlightRequest::RemoveKeyframe.into(),
    ..FLIGHT
};

/// Plays or pauses the flight.
pub const PLAY: Command = Command {
    name: "Play flight",
    tooltip: "Plays or pauses the flight.",
    keys: &[plain(Key::Space)],
    keys_in: KeysIn::AllButFlat,
    ready: can_fly,
    on: Some(State::plays),
    request: |_| FlightRequest::Play.into(),
    ..FLIGHT
};

/// Renders a picture of the view.
pub const STILL: Command = Command {
    name: "Render picture…",
    tooltip: "Renders the 3D view in final quality, at any size, as PNG of 8 or 16 bits or as OpenEXR.",
    starts_group: true,
    menu: Menu::File,
    ready: with_painter,
    request: |_| FlightRequest::ChooseStill.into(),
    ..FLIGHT
};

/// Renders a video of the flight.
pub const FILM: Command = Command {
    name: "Render video…",
    tooltip: "Renders the flight in final quality, as a video or as a sequence of pictures.",
    menu: Menu::File,
    ready: |state| with_painter(state).and(can_fly(state)),
    request: |_| FlightRequest::ChooseFilm.into(),
    ..FLIGHT
};

fn can_fly(state: &State) -> Result<(), WhyNot> {
    if state.can_fly() { Ok(()) } else { Err("add two keyframes first") }
}

fn with_painter(state: &State) -> Result<(), WhyNot> {
    let session = state.session.as_ref().ok_or("open a project first")?;
    if state.space.device.is_some() {
        Ok(())
    } else if session.photos.iter().all(|photo| photo.stack.is_none()) {
        Err("build the layers first")
    } else if state.running.runs(JobKind::Preview) {
        Err("wait a moment: the 3D view is being prepared")
    } else {
        Err("the 3D view is not running; its tab shows the reason")
    }
}
