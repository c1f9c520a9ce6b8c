//! Commands on the 3D view: its viewpoint and display.

use eframe::egui::Key;

use super::{Command, Menu, PLAIN, WhyNot, plain, shift, with_project};
use crate::app::state::State;
use crate::app::state::ask::{BuildAsk, Flag, SelectAsk, SpaceAsk, WindowAsk};
use crate::projection::DisplayMode;

/// The commands in the order of their menus.
pub const COMMANDS: &[&Command] = &[
    &FRAME,
    &EVERYTHING,
    &SNAP,
    &INTO,
    &NEXT,
    &PREVIOUS,
    &LEVEL,
    &COLOUR,
    &WEIGHTS,
    &BEST,
    &COVERAGE,
    &DENSITY,
    &CONFIDENCE,
    &LAYER,
    &ITEM,
    &PROVENANCE,
    &LEGEND,
    &EXPLODED,
    &WIREFRAME,
    &CAMERAS,
    &BACKS,
    &FLIP,
    &RESTART,
];

/// The commands that choose what the 3D view shows: one is on at a time.
pub const DISPLAY_COMMANDS: &[&Command] =
    &[&COLOUR, &WEIGHTS, &BEST, &COVERAGE, &DENSITY, &CONFIDENCE, &LAYER, &ITEM, &PROVENANCE];

const VIEW: Command = Command { menu: Menu::View, ready: with_project, ..PLAIN };

/// Frames the selection.
pub const FRAME: Command = Command {
    name: "Frame selection",
    tooltip: "Goes to where the selection fills the view: 3D, photo or image layer.",
    keys: &[plain(Key::F)],
    ask: |_| SpaceAsk::Frame.into(),
    ..VIEW
};

/// Frames everything.
pub const EVERYTHING: Command = Command {
    name: "Show everything",
    tooltip: "Goes back until the whole model, photo or image layer is in the view.",
    keys: &[plain(Key::Home)],
    ask: |_| SpaceAsk::ShowAll.into(),
    ..VIEW
};

/// Flies into the photo, and back.
pub const SNAP: Command = Command {
    name: "Look through the photo",
    tooltip: "Flies into the selected photo's camera; a second time flies back.",
    keys: &[plain(Key::Num0)],
    ready: with_photo,
    ask: |_| SpaceAsk::Snap.into(),
    ..VIEW
};

/// Flies into the photo, and never back: confirming a text field with a second Enter must not leave it.
pub const INTO: Command = Command {
    name: "Fly into the photo",
    tooltip: "Flies into the selected photo's camera, and stays there; 0 flies back.",
    keys: &[plain(Key::Enter)],
    ready: with_photo,
    ask: |_| SpaceAsk::FlyInto.into(),
    ..VIEW
};

/// Selects the next photo.
pub const NEXT: Command = Command {
    name: "Next photo",
    tooltip: "Selects the next photo, and flies to it when looking through one.",
    keys: &[plain(Key::CloseBracket), plain(Key::PageDown)],
    ask: |_| SelectAsk::StepPhoto(1).into(),
    ..VIEW
};

/// Selects the previous photo.
pub const PREVIOUS: Command = Command {
    name: "Previous photo",
    tooltip: "Selects the photo before, and flies to it when looking through one.",
    keys: &[plain(Key::OpenBracket), plain(Key::PageUp)],
    ask: |_| SelectAsk::StepPhoto(-1).into(),
    ..VIEW
};

/// Levels the horizon.
pub const LEVEL: Command = Command {
    name: "Level the horizon",
    tooltip: "Turns the view about its axis until what is upright stands upright.",
    ask: |_| SpaceAsk::Level.into(),
    ..VIEW
};

macro_rules! shown {
    ($constant:ident, $shown:ident, $name:literal, $key:ident, $tooltip:literal) => {
        /// Shows this in the 3D view.
        pub const $constant: Command = Command {
            name: $name,
            tooltip: $tooltip,
            keys: &[plain(Key::$key)],
            on: Some(|state| state.space.look.display == DisplayMode::$shown),
            ask: |_| SpaceAsk::Display(DisplayMode::$shown).into(),
            ..VIEW
        };
    };
}

shown!(
    WEIGHTS,
    Weights,
    "Weights",
    Num2,
    "Each photo in a colour of its own, mixed as the photos are blended."
);
shown!(BEST, BestPhoto, "Best photo", Num3, "The photo that counts most, in a colour of its own.");
shown!(COVERAGE, Coverage, "Coverage", Num4, "How many photos serve each place.");
shown!(DENSITY, Density, "Texel density", Num5, "Texels of the best photo per pixel of the view.");
shown!(
    CONFIDENCE,
    Confidence,
    "Confidence",
    Num6,
    "How far the photos that serve a place are trusted there."
);
shown!(LAYER, Layer, "Image layers", Num7, "The image layer of the best photo, as a colour.");
shown!(ITEM, Item, "Faces", Num8, "Every face in a colour of its own.");
shown!(
    PROVENANCE,
    Provenance,
    "Provenance",
    Num9,
    "Where what is seen comes from: the photo, paint, other photos, or invention."
);

/// Shows or hides the legend.
pub const LEGEND: Command = Command {
    name: "Legend",
    tooltip: "Says what the colours of the 3D view mean.",
    keys: &[shift(Key::L)],
    on: Some(|state| state.space.legend_shown),
    ask: |_| WindowAsk::Flip(Flag::Legend).into(),
    ..VIEW
};

/// Shows the layers in exploded view.
pub const EXPLODED: Command = Command {
    name: "Layers pulled apart",
    tooltip: "Shows the selected photo's image layers as sheets in space, one behind the other: an exploded view.",
    keys: &[plain(Key::V)],
    starts_group: true,
    ready: with_layers,
    on: Some(|state| state.space.exploded.is_on()),
    ask: |_| SpaceAsk::PullApart.into(),
    ..VIEW
};

/// Shows the blended photos.
pub const COLOUR: Command = Command {
    name: "Photos",
    tooltip: "The photos, blended for this view.",
    keys: &[plain(Key::Num1)],
    starts_group: true,
    on: Some(|state| state.space.look.display == DisplayMode::Colour),
    ask: |_| SpaceAsk::Display(DisplayMode::Colour).into(),
    ..VIEW
};

/// Shows or hides outlines of faces.
pub const WIREFRAME: Command = Command {
    name: "Wireframe",
    tooltip: "Draws the outlines of all faces.",
    keys: &[plain(Key::Z)],
    starts_group: true,
    on: Some(|state| state.space.wireframe),
    ask: |_| WindowAsk::Flip(Flag::Wireframe).into(),
    ..VIEW
};

/// Shows or hides the cameras.
pub const CAMERAS: Command = Command {
    name: "Photos in space",
    tooltip: "Draws where each photo was taken from, with its picture.",
    keys: &[plain(Key::C)],
    on: Some(|state| state.space.cameras),
    ask: |_| WindowAsk::Flip(Flag::Cameras).into(),
    ..VIEW
};

/// Shows or hides back faces.
pub const BACKS: Command = Command {
    name: "Backs",
    tooltip: "Draws the backs of faces too, which no photo shows; without them one looks into courtyards from outside.",
    keys: &[shift(Key::B)],
    on: Some(|state| !state.space.look.without_backs),
    ask: |_| WindowAsk::Flip(Flag::Backs).into(),
    ..VIEW
};

/// Shows or hides the photo over the view.
pub const FLIP: Command = Command {
    name: "Photo over the view",
    tooltip: "Lays the photo one looks through over the view; hold X to flip between the two.",
    keys: &[plain(Key::P)],
    on: Some(|state| state.space.photo_over),
    ask: |_| WindowAsk::Flip(Flag::PhotoOver).into(),
    ..VIEW
};

/// Restarts the renderer.
pub const RESTART: Command = Command {
    name: "Restart 3D view",
    tooltip: "Prepares the 3D view anew, on the device as it is now.",
    starts_group: true,
    ask: |_| BuildAsk::PreparePainter.into(),
    ..VIEW
};

fn with_layers(state: &State) -> Result<(), WhyNot> {
    with_photo(state)?;
    match state.space.exploded.is_on() || state.selected_stack().is_some() {
        true => Ok(()),
        false => Err("build the photo's layers first"),
    }
}

fn with_photo(state: &State) -> Result<(), WhyNot> {
    with_project(state)?;
    state.selected_photo().map(|_| ()).ok_or("select a photo first")
}
