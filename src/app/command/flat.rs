//! Commands on the views of the centre, most of them flat.

use eframe::egui::Key;

use super::{Command, Menu, PLAIN, WhyNot, plain, with_project};
use crate::state::State;
use crate::state::panes::Pane;
use crate::state::request::{Flag, FlatRequest, WindowRequest};

/// The commands in the order of their menus.
pub const COMMANDS: &[&Command] = &[
    &FIT,
    &PIXELS,
    &LARGER,
    &SMALLER,
    &TAKE_OFF,
    &PUT_BACK,
    &OUTLINES,
    &HATCHING,
    &RECTANGLES,
    &FILLING,
    &PAINT,
    &EVEN,
    &UNTEXTURED,
    &SHOW_SPACE,
    &SHOW_PHOTO,
    &SHOW_LAYER,
];

const PHOTO: Command = Command { menu: Menu::Photo, ready: with_project, ..PLAIN };

/// Fits the whole picture into the view.
pub const FIT: Command = Command {
    name: "Fit into the view",
    tooltip: "Shows the whole photo or image layer.",
    request: |_| FlatRequest::Fit.into(),
    ..PHOTO
};

/// Shows the picture at one screen pixel for each pixel.
pub const PIXELS: Command = Command {
    name: "Show pixels 1:1",
    tooltip: "Shows one pixel of the photo or image layer per pixel of the screen.",
    keys: &[plain(Key::N)],
    request: |_| FlatRequest::ShowPixels.into(),
    ..PHOTO
};

/// Zooms in.
pub const LARGER: Command = Command {
    name: "Zoom in",
    tooltip: "Shows the photo or image layer larger.",
    keys: &[plain(Key::Plus), plain(Key::Equals)],
    request: |_| FlatRequest::Zoom(STEP).into(),
    ..PHOTO
};

/// Zooms out.
pub const SMALLER: Command = Command {
    name: "Zoom out",
    tooltip: "Shows the photo or image layer smaller.",
    keys: &[plain(Key::Minus)],
    request: |_| FlatRequest::Zoom(1.0 / STEP).into(),
    ..PHOTO
};

/// The zoom factor of one step: two steps double the size.
const STEP: f64 = std::f64::consts::SQRT_2;

/// Hides one more visibility layer.
pub const TAKE_OFF: Command = Command {
    name: "Hide nearest layer",
    tooltip: "Hides the nearest visibility layer of the photo that is still shown, and shows the layers behind it.",
    keys: &[plain(Key::Period)],
    starts_group: true,
    ready: with_layers,
    request: |_| FlatRequest::Peel(1).into(),
    ..PHOTO
};

/// Shows the last hidden visibility layer again.
pub const PUT_BACK: Command = Command {
    name: "Show last hidden layer",
    tooltip: "Shows the visibility layer that was hidden last.",
    keys: &[plain(Key::Comma)],
    ready: with_layers,
    request: |_| FlatRequest::Peel(-1).into(),
    ..PHOTO
};

macro_rules! switch {
    ($constant:ident, $field:ident, $flag:ident, $name:literal, $tooltip:literal, [$($key:ident)?], $starts_group:literal) => {
        #[doc = $tooltip]
        pub const $constant: Command = Command {
            name: $name,
            tooltip: $tooltip,
            keys: &[$(plain(Key::$key))?],
            starts_group: $starts_group,
            on: Some(|state| state.flat.switches.$field),
            request: |_| WindowRequest::Flip(Flag::$flag).into(),
            ..PHOTO
        };
    };
}

switch!(
    OUTLINES,
    outlines,
    Outlines,
    "Outlines",
    "Draws the outlines of elements over the photo, by depth.",
    [O],
    true
);
switch!(
    HATCHING,
    hatching,
    Hatching,
    "Hatching",
    "Hatches hidden areas: surfaces need them, and the photo does not show them.",
    [H],
    false
);
switch!(
    RECTANGLES,
    rectangles,
    Rectangles,
    "Rectangles",
    "Draws the rectangles of image layers over the photo.",
    [R],
    false
);
switch!(
    FILLING,
    filling,
    Filling,
    "Filling",
    "Shows the filling of occluded areas, and paint projected from other photos.",
    [],
    false
);
switch!(PAINT, paint, Paint, "Paint", "Shows paint.", [], false);
switch!(
    EVEN,
    even,
    Even,
    "Matched exposure",
    "Shows the photo with the exposure that it is blended with, as set in the colour panel; off: as it was taken.",
    [],
    false
);

/// Lists faces without texture from the photo, with reasons.
pub const UNTEXTURED: Command = Command {
    name: "Untextured faces",
    tooltip: "Lists the faces that this photo does not texture, with the reason.",
    keys: &[plain(Key::U)],
    starts_group: true,
    on: Some(|state| state.flat.photo.reasons_shown),
    request: |_| FlatRequest::ListUntextured.into(),
    ..PHOTO
};

macro_rules! show {
    ($constant:ident, $pane:ident, $name:literal, $key:ident, $tooltip:literal, $starts_group:literal) => {
        #[doc = $tooltip]
        pub const $constant: Command = Command {
            name: $name,
            tooltip: $tooltip,
            keys: &[plain(Key::$key)],
            menu: Menu::Window,
            starts_group: $starts_group,
            ready: with_project,
            on: Some(|state| state.panes.is_shown(Pane::$pane)),
            request: |_| WindowRequest::ShowPane(Pane::$pane).into(),
            ..PLAIN
        };
    };
}

show!(SHOW_SPACE, Space, "Show 3D view", F2, "Brings the 3D view to the front.", true);
show!(SHOW_PHOTO, Photo, "Show photo", F3, "Brings the photo with its layers to the front.", false);
show!(SHOW_LAYER, Layer, "Show image layer", F4, "Brings the selected image layer to the front.", false);

fn with_layers(state: &State) -> Result<(), WhyNot> {
    with_project(state)?;
    state.selected_stack().map(|_| ()).ok_or("build the photo's layers first")
}
