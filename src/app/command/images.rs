//! Commands on layered depth images: the 3D view drawn from them, and files of them.

use eframe::egui::Key;

use super::paint::can_export_photo;
use super::{Command, Menu, PLAIN, shift, with_project};
use crate::state::request::{Flag, ImagesRequest, OrthoRequest, PublishRequest, WindowRequest};
use crate::state::save_image::ImageFormat;

/// Draws the 3D view from layered depth images, or from the model.
pub const SHOW: Command = Command {
    name: "Layered depth image",
    tooltip: "Draws the 3D view from a layered depth image of the best photos, which is built in the background, instead \
              of from the model.",
    keys: &[shift(Key::I)],
    menu: Menu::View,
    ready: with_project,
    on: Some(|state| state.space.images.on),
    request: |_| WindowRequest::Flip(Flag::Images).into(),
    ..PLAIN
};

/// Saves the photo as a layered depth image.
pub const SAVE: Command = Command {
    name: "Export layered depth image…",
    tooltip: "Writes the selected photo, with what is behind its surfaces, as a layered depth image.",
    ready: can_export_photo,
    request: |_| ImagesRequest::Choose(ImageFormat::Ldi).into(),
    ..PLAIN
};

/// Draws an orthophoto of the selection.
pub const ORTHOPHOTO: Command = Command {
    name: "Orthophoto…",
    tooltip: "Draws the selected face or object from straight in front, or the site from above, to scale: as TIFF, PNG and a page with \
              scale bar.",
    ready: super::paint::can_export,
    request: |_| OrthoRequest::Choose.into(),
    ..PLAIN
};

/// Publishes the site as a web page.
pub const PUBLISH: Command = Command {
    name: "Publish as a web page…",
    tooltip: "Writes the site as a folder in which visitors walk through it in their browser, with texts at places, credits and licence.",
    menu: Menu::File,
    ready: super::paint::can_export,
    request: |_| PublishRequest::Choose.into(),
    ..PLAIN
};

/// Sets the site's frame.
pub const FRAME: Command = Command {
    name: "Site frame…",
    tooltip: "Makes the site level, metric and oriented, and places it on a map; exports, measurements and orthophotos use it.",
    menu: Menu::View,
    ready: with_project,
    request: |_| OrthoRequest::ChooseFrame.into(),
    ..PLAIN
};

/// Saves the photo as a page.
pub const PAGE: Command = Command {
    name: "Export page of the photo…",
    tooltip: "Writes the selected photo, with what is behind its surfaces, as a page for browsers in which one leans into \
              it.",
    ready: can_export_photo,
    request: |_| ImagesRequest::Choose(ImageFormat::Page).into(),
    ..PLAIN
};
