//! Commands on the views of the centre, and on the flat ones among them.

use eframe::egui::Key;

use super::{Command, Menu, PLAIN, WhyNot, plain, with_project};
use crate::app::editor::Editor;
use crate::app::flat::View;
use crate::app::layout::Pane;

/// In the order of their menus.
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

/// The whole picture.
pub const FIT: Command = Command {
    name: "Fit into the view",
    tooltip: "Shows the whole photo or image layer.",
    run: |editor, _| editor.flat_view().fit(),
    ..PHOTO
};

/// Pixel for pixel.
pub const PIXELS: Command = Command {
    name: "Show pixels 1:1",
    tooltip: "Shows each pixel of the photo or image layer as one of the screen's.",
    keys: &[plain(Key::N)],
    run: |editor, context| editor.flat_view().show_pixels(context.pixels_per_point()),
    ..PHOTO
};

/// Comes nearer.
pub const LARGER: Command = Command {
    name: "Zoom in",
    tooltip: "Shows the photo or image layer larger.",
    keys: &[plain(Key::Plus), plain(Key::Equals)],
    run: |editor, _| editor.flat_view().zoom(STEP),
    ..PHOTO
};

/// Goes back.
pub const SMALLER: Command = Command {
    name: "Zoom out",
    tooltip: "Shows the photo or image layer smaller.",
    keys: &[plain(Key::Minus)],
    run: |editor, _| editor.flat_view().zoom(1.0 / STEP),
    ..PHOTO
};

/// Two steps are twice the size.
const STEP: f64 = std::f64::consts::SQRT_2;

/// One more visibility layer gone.
pub const TAKE_OFF: Command = Command {
    name: "Take one layer off",
    tooltip: "Takes the front visibility layer off the photo, and shows what the layers behind have.",
    keys: &[plain(Key::Period)],
    starts_group: true,
    ready: with_layers,
    run: |editor, _| editor.peel(1),
    ..PHOTO
};

/// One back.
pub const PUT_BACK: Command = Command {
    name: "Put one layer back",
    tooltip: "Puts the visibility layer back that was taken off last.",
    keys: &[plain(Key::Comma)],
    ready: with_layers,
    run: |editor, _| editor.peel(-1),
    ..PHOTO
};

macro_rules! switch {
    ($constant:ident, $field:ident, $name:literal, $tooltip:literal, [$($key:ident)?], $starts_group:literal) => {
        #[doc = $tooltip]
        pub const $constant: Command = Command {
            name: $name,
            tooltip: $tooltip,
            keys: &[$(plain(Key::$key))?],
            starts_group: $starts_group,
            on: Some(|editor| editor.flat.switches.$field),
            run: |editor, _| editor.flat.switches.$field ^= true,
            ..PHOTO
        };
    };
}

switch!(
    OUTLINES,
    outlines,
    "Outlines",
    "Draws the outlines of elements over the photo, by depth.",
    [O],
    true
);
switch!(
    HATCHING,
    hatching,
    "Hatching",
    "Hatches what is hidden: needed by a surface and not shown by the photo.",
    [H],
    false
);
switch!(
    RECTANGLES,
    rectangles,
    "Rectangles",
    "Draws the rectangles of image layers over the photo.",
    [R],
    false
);
switch!(
    FILLING,
    filling,
    "Filling",
    "Shows what fills hidden parts, and paint of other photos that lies over this one.",
    [],
    false
);
switch!(PAINT, paint, "Paint", "Shows what was painted.", [], false);
switch!(
    EVEN,
    even,
    "Even colour",
    "Shows the photo in the exposure that it is blended with, as the colour panel has it; off: as it was taken.",
    [],
    false
);

/// Why faces have no texture from the photo.
pub const UNTEXTURED: Command = Command {
    name: "Untextured faces",
    tooltip: "Lists the faces that this photo gives no texture, with the reason.",
    keys: &[plain(Key::U)],
    starts_group: true,
    on: Some(|editor| editor.flat.photo.reasons_shown),
    run: |editor, _| {
        editor.flat.photo.reasons_shown ^= true;
        if editor.flat.photo.reasons_shown {
            editor.layout.show(Pane::Photo);
        }
    },
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
            on: Some(|editor| editor.layout.is_shown(Pane::$pane)),
            run: |editor, _| editor.layout.show(Pane::$pane),
            ..PLAIN
        };
    };
}

show!(SHOW_SPACE, Space, "Show 3D view", F2, "Brings the 3D view to the front.", true);
show!(SHOW_PHOTO, Photo, "Show photo", F3, "Brings the photo with its layers to the front.", false);
show!(SHOW_LAYER, Layer, "Show image layer", F4, "Brings the selected image layer to the front.", false);

fn with_layers(editor: &Editor) -> Result<(), WhyNot> {
    with_project(editor)?;
    editor.selected_stack().map(|_| ()).ok_or("build the photo's layers first")
}

impl Editor {
    /// The flat view in use: the photo's, where that is none of them.
    fn flat_view(&mut self) -> &mut View {
        match self.layout.used() {
            Pane::Layer => &mut self.flat.layer.view,
            Pane::Space | Pane::Photo => &mut self.flat.photo.view,
        }
    }

    /// Takes so many more visibility layers off the photo.
    fn peel(&mut self, by: i32) {
        let depth = self.selected_stack().map_or(0, |stack| stack.visibility_layers.len() as u32);
        let taken_off = &mut self.flat.photo.taken_off;
        *taken_off = taken_off.saturating_add_signed(by).min(depth);
        self.layout.show(Pane::Photo);
    }
}
