//! Commands on the 3D view: its viewpoint and display.

use eframe::egui::Key;

use super::{Command, KeysIn, Menu, PLAIN, WhyNot, images, plain, shift, with_project};
use crate::state::State;
use crate::state::panes::{KeyOwner, Pane};
use crate::state::request::{Flag, JobRequest, Request, SelectRequest, SpaceRequest, WindowRequest};
use crate::state::space::brush::STEP;
use crate::state::space::visibility::Uncovered;
use quadratura_view::DisplayMode;

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
    &AGREED,
    &GROUP,
    &MATTE,
    &LAYER,
    &ITEM,
    &PROVENANCE,
    &LEGEND,
    &EXPLODED,
    &images::SHOW,
    &BRUSH,
    &MEASURE,
    &images::FRAME,
    &WIREFRAME,
    &CAMERAS,
    &BACKS,
    &SURROUNDINGS,
    &AGREEMENT,
    &WITHOUT_TRANSIENTS,
    &GLASS,
    &NO_UNCOVERED,
    &HIDE,
    &ISOLATE,
    &SHOW_OBJECTS,
    &FLIP,
    &RESTART,
];

/// The commands that choose what the 3D view shows: one is on at a time.
pub const DISPLAY_COMMANDS: &[&Command] = &[
    &COLOUR,
    &WEIGHTS,
    &BEST,
    &COVERAGE,
    &DENSITY,
    &CONFIDENCE,
    &AGREED,
    &GROUP,
    &MATTE,
    &LAYER,
    &ITEM,
    &PROVENANCE,
];

/// Returns the command that shows this in the 3D view.
pub fn command_of(display: DisplayMode) -> &'static Command {
    match display {
        DisplayMode::Colour => &COLOUR,
        DisplayMode::Weights => &WEIGHTS,
        DisplayMode::BestPhoto => &BEST,
        DisplayMode::Coverage => &COVERAGE,
        DisplayMode::Density => &DENSITY,
        DisplayMode::Confidence => &CONFIDENCE,
        DisplayMode::Agreement => &AGREED,
        DisplayMode::Group => &GROUP,
        DisplayMode::Matte => &MATTE,
        DisplayMode::Layer => &LAYER,
        DisplayMode::Item => &ITEM,
        DisplayMode::Provenance => &PROVENANCE,
    }
}

const VIEW: Command = Command { menu: Menu::View, ready: with_project, ..PLAIN };

/// Frames the selection.
pub const FRAME: Command = Command {
    name: "Frame selection",
    tooltip: "Moves to where the selection fills the view: 3D, photo or image layer.",
    keys: &[plain(Key::F)],
    request: |_| SpaceRequest::Frame.into(),
    ..VIEW
};

/// Frames everything.
pub const EVERYTHING: Command = Command {
    name: "Show everything",
    tooltip: "Zooms out until the whole model, photo or image layer is in the view.",
    keys: &[plain(Key::Home)],
    request: |_| SpaceRequest::ShowAll.into(),
    ..VIEW
};

/// Flies into the photo, and back.
pub const SNAP: Command = Command {
    name: "Look through camera",
    tooltip: "Flies to the selected photo's camera, and the second time back.",
    keys: &[plain(Key::Num0)],
    ready: with_photo,
    request: |_| SpaceRequest::Snap.into(),
    ..VIEW
};

/// Flies into the photo, and never back: confirming a text field with a second Enter must not leave it.
pub const INTO: Command = Command {
    name: "Fly to camera",
    tooltip: "Flies to the selected photo's camera and stays there; 0 flies back.",
    keys: &[plain(Key::Enter)],
    ready: with_photo,
    request: |_| SpaceRequest::FlyInto.into(),
    ..VIEW
};

/// Selects the next photo.
pub const NEXT: Command = Command {
    name: "Next photo",
    tooltip: "Selects the next photo, and flies to its camera if you look through one. With the brush: makes it larger.",
    keys: &[plain(Key::CloseBracket), plain(Key::PageDown)],
    request: |state| resized(state, STEP).unwrap_or(SelectRequest::StepPhoto(1).into()),
    ..VIEW
};

/// Selects the previous photo.
pub const PREVIOUS: Command = Command {
    name: "Previous photo",
    tooltip: "Selects the previous photo, and flies to its camera if you look through one. With the brush: makes it smaller.",
    keys: &[plain(Key::OpenBracket), plain(Key::PageUp)],
    request: |state| resized(state, 1.0 / STEP).unwrap_or(SelectRequest::StepPhoto(-1).into()),
    ..VIEW
};

/// Levels the horizon.
pub const LEVEL: Command = Command {
    name: "Level the horizon",
    tooltip: "Rolls the view until vertical lines are upright.",
    request: |_| SpaceRequest::Level.into(),
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
            request: |_| SpaceRequest::Display(DisplayMode::$shown).into(),
            ..VIEW
        };
    };
}

shown!(
    WEIGHTS,
    Weights,
    "Weights",
    Num2,
    "Shows blending weights: one colour per photo, and stripes as wide as their weights where photos are blended."
);
shown!(BEST, BestPhoto, "Best photo", Num3, "Shows the photo with the highest weight, one colour per photo.");
shown!(COVERAGE, Coverage, "Coverage", Num4, "Shows how many photos cover each point.");
shown!(DENSITY, Density, "Resolution", Num5, "Shows the resolution of the best photo, in texels per pixel.");
shown!(
    CONFIDENCE,
    Confidence,
    "Confidence",
    Num6,
    "Shows the confidence of the photos that cover each point."
);
shown!(LAYER, Layer, "Image layers", Num7, "Shows the image layer of the best photo, one colour per layer.");
shown!(ITEM, Item, "Faces", Num8, "Shows the faces, one colour per face.");
shown!(
    PROVENANCE,
    Provenance,
    "Provenance",
    Num9,
    "Shows the source of each point: the photo, paint, other photos, or inpainting."
);

/// Shows what other photos contradict.
pub const AGREED: Command = Command {
    name: "Agreement",
    tooltip: "Shows how far the other photos confirm the nearest photo: what they contradict is magenta.",
    on: Some(|state| state.space.look.display == DisplayMode::Agreement),
    request: |_| SpaceRequest::Display(DisplayMode::Agreement).into(),
    ..VIEW
};

/// Shows the groups of light.
pub const GROUP: Command = Command {
    name: "Groups of light",
    tooltip: "Shows the group of light of the photo with the highest weight, one colour per group.",
    on: Some(|state| state.space.look.display == DisplayMode::Group),
    request: |_| SpaceRequest::Display(DisplayMode::Group).into(),
    ..VIEW
};

/// Shows the mattes of see-through surfaces.
pub const MATTE: Command = Command {
    name: "Mattes",
    tooltip: "Shows how much see-through surfaces, such as trees, cover of what is behind them: white is solid.",
    on: Some(|state| state.space.look.display == DisplayMode::Matte),
    request: |_| SpaceRequest::Display(DisplayMode::Matte).into(),
    ..VIEW
};

/// Shows or hides the legend.
pub const LEGEND: Command = Command {
    name: "Legend",
    tooltip: "Explains the colours of the 3D view.",
    keys: &[shift(Key::L)],
    on: Some(|state| state.space.legend_shown),
    request: |_| WindowRequest::Flip(Flag::Legend).into(),
    ..VIEW
};

/// Shows the layers in exploded view.
pub const EXPLODED: Command = Command {
    name: "Exploded view",
    tooltip: "Shows the selected photo's image layers as separate sheets in space, one behind the other.",
    keys: &[plain(Key::V)],
    starts_group: true,
    ready: with_layers,
    on: Some(|state| state.space.exploded.is_on()),
    request: |_| SpaceRequest::PullApart.into(),
    ..VIEW
};

/// Takes up the brush.
pub const BRUSH: Command = Command {
    name: "Brush",
    tooltip: "Paints on the surfaces of the 3D view: a colour, clone, heal, or erase; Esc puts the brush away.",
    keys: &[plain(Key::G)],
    keys_in: KeysIn::Space,
    on: Some(|state| state.space.brush.on),
    request: |_| SpaceRequest::Brush.into(),
    ..VIEW
};

/// Takes up the measuring tool.
pub const MEASURE: Command = Command {
    name: "Measure",
    tooltip: "Measures distances and heights between two points on surfaces, with their uncertainty; Esc puts the tool away. Areas are on \
              the pages of faces.",
    on: Some(|state| state.space.measure.on),
    request: |_| SpaceRequest::Measure.into(),
    ..VIEW
};

/// Shows the blended photos.
pub const COLOUR: Command = Command {
    name: "Photos",
    tooltip: "Shows the photos, blended for this view.",
    keys: &[plain(Key::Num1)],
    starts_group: true,
    on: Some(|state| state.space.look.display == DisplayMode::Colour),
    request: |_| SpaceRequest::Display(DisplayMode::Colour).into(),
    ..VIEW
};

/// Shows or hides outlines of faces.
pub const WIREFRAME: Command = Command {
    name: "Wireframe",
    tooltip: "Draws the outlines of all faces.",
    keys: &[plain(Key::Z)],
    starts_group: true,
    on: Some(|state| state.space.wireframe),
    request: |_| WindowRequest::Flip(Flag::Wireframe).into(),
    ..VIEW
};

/// Shows or hides the cameras.
pub const CAMERAS: Command = Command {
    name: "Show cameras",
    tooltip: "Shows the camera of each photo, with its picture.",
    keys: &[plain(Key::C)],
    on: Some(|state| state.space.cameras),
    request: |_| WindowRequest::Flip(Flag::Cameras).into(),
    ..VIEW
};

/// Shows or hides back faces.
pub const BACKS: Command = Command {
    name: "Back faces",
    tooltip: "Shows back faces, which no photo covers; while they are hidden, you see into courtyards from outside.",
    keys: &[shift(Key::B)],
    on: Some(|state| !state.space.look.without_backs),
    request: |_| WindowRequest::Flip(Flag::Backs).into(),
    ..VIEW
};

/// Shows or hides the surroundings.
pub const SURROUNDINGS: Command = Command {
    name: "Surroundings",
    tooltip: "Shows what the photos show where no surface of the model is, such as sky.",
    on: Some(|state| !state.space.look.without_surroundings),
    request: |_| WindowRequest::Flip(Flag::Surroundings).into(),
    ..VIEW
};

/// Lets photos count less where others contradict them.
pub const AGREEMENT: Command = Command {
    name: "Outvote contradicted photos",
    tooltip: "Photos count less where several others contradict them; a photo's own camera still shows the photo.",
    on: Some(|state| state.space.look.blend.agreement),
    request: |_| WindowRequest::Flip(Flag::Agreement).into(),
    ..VIEW
};

/// Shows what the others show where they contradict a photo.
pub const WITHOUT_TRANSIENTS: Command = Command {
    name: "Without transient objects",
    tooltip: "Shows what the other photos show where they contradict a photo, through its own camera, too.",
    ready: |state| {
        state.space.look.blend.agreement.then_some(()).ok_or("switch on the agreement of photos first")
    },
    on: Some(|state| state.space.look.blend.without_transients),
    request: |_| WindowRequest::Flip(Flag::WithoutTransients).into(),
    ..VIEW
};

/// Draws surfaces that no photo covers as glass.
pub const GLASS: Command = Command {
    name: "Uncovered surfaces as glass",
    tooltip: "Draws only the outlines of surfaces that no photo covers, so that one sees what is behind them.",
    on: Some(|state| state.space.visibility.uncovered == Uncovered::Glass),
    request: |state| uncovered(state, Uncovered::Glass),
    ..VIEW
};

/// Hides surfaces that no photo covers.
pub const NO_UNCOVERED: Command = Command {
    name: "Hide uncovered surfaces",
    tooltip: "Hides surfaces that no photo covers.",
    on: Some(|state| state.space.visibility.uncovered == Uncovered::Hidden),
    request: |state| uncovered(state, Uncovered::Hidden),
    ..VIEW
};

/// Hides the selected object.
pub const HIDE: Command = Command {
    name: "Hide object",
    tooltip: "Hides the selected object in the 3D view, as its eye in the list does; it remains in the model.",
    starts_group: true,
    ready: with_object,
    request: |state| SpaceRequest::ShowObject(state.selected_object().unwrap_or_default(), false).into(),
    ..VIEW
};

/// Hides all other objects.
pub const ISOLATE: Command = Command {
    name: "Show only this object",
    tooltip: "Hides all objects but the selected one in the 3D view, and the second time shows them again.",
    ready: with_object,
    request: |state| SpaceRequest::Isolate(state.selected_object().unwrap_or_default()).into(),
    ..VIEW
};

/// Shows all objects that are hidden.
pub const SHOW_OBJECTS: Command = Command {
    name: "Show all objects",
    tooltip: "Shows all objects in the 3D view that are hidden by their eyes.",
    ready: |state| match state.space.visibility.hides_objects() {
        true => with_project(state),
        false => Err("no object is hidden"),
    },
    request: |_| SpaceRequest::ShowAllObjects.into(),
    ..VIEW
};

/// Shows or hides the photo over the view.
pub const FLIP: Command = Command {
    name: "Photo overlay",
    starts_group: true,
    tooltip: "Overlays the photo whose camera you look through; hold X to flip between photo and view.",
    keys: &[plain(Key::P)],
    on: Some(|state| state.space.photo_over),
    request: |_| WindowRequest::Flip(Flag::PhotoOver).into(),
    ..VIEW
};

/// Restarts the renderer.
pub const RESTART: Command = Command {
    name: "Restart 3D view",
    tooltip: "Restarts the renderer of the 3D view on the current graphics device.",
    starts_group: true,
    request: |_| JobRequest::PreparePainter.into(),
    ..VIEW
};

/// Returns the request that resizes the brush, while it is in use and the 3D view has the keys.
fn resized(state: &State, factor: f64) -> Option<Request> {
    let has_keys = state.panes.key_owner() == KeyOwner::View(Pane::Space);
    (state.space.brush.on && has_keys).then(|| SpaceRequest::ResizeBrush(factor).into())
}

/// Returns the request that shows uncovered surfaces in one way, or as usual where they are shown in it already.
fn uncovered(state: &State, way: Uncovered) -> Request {
    let now = state.space.visibility.uncovered;
    SpaceRequest::ShowUncovered(if now == way { Uncovered::Solid } else { way }).into()
}

fn with_object(state: &State) -> Result<(), WhyNot> {
    state.selected_object().map(|_| ()).ok_or("select an object or a face")
}

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
