//! Parts that the flat views share: the placement of a picture in a view, textures in tiles, hatching.

pub mod hatch;
pub mod placement;
pub mod tiled;

use eframe::egui::{Button, CentralPanel, Color32, PointerButton, Rect, Response, Ui};

use self::hatch::Checkerboard;
use self::placement::{PlacedPicture, on_screen, screen_rect};
use self::tiled::TiledPictures;
use super::button_ui;
use crate::command::{Commands, flat};
use crate::state::flat::placement::Placement;
use crate::state::request::Request;
use quadratura_base::geometry::PixelRect;

/// The zoom factor of one point of wheel movement (a step of a wheel is about 40 points in egui).
const ZOOM_PER_POINT: f64 = 1.0045;

/// The textures of the flat views.
#[derive(Default)]
pub struct FlatTextures {
    /// The pictures.
    pub pictures: TiledPictures,
    /// The checkerboard behind transparent areas.
    pub checkerboard: Checkerboard,
}

/// Returns the colour behind pictures.
pub fn background(ui: &Ui) -> Color32 {
    if ui.visuals().dark_mode { Color32::from_gray(28) } else { Color32::from_gray(190) }
}

/// Draws a hint in place of a picture that is not there.
pub fn nothing_ui(ui: &mut Ui, words: &str) {
    CentralPanel::default_margins().show(ui, |ui| ui.centered_and_justified(|ui| ui.label(words)));
}

/// The role of the left mouse button in a flat view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LeftButton {
    /// The button moves the picture, as the other buttons do.
    Moves,
    /// The button belongs to a tool, and so does the wheel with Ctrl.
    Draws,
}

/// Moves a picture with mouse and wheel, and returns its new placement: a drag pans, the wheel zooms around the
/// pointer, a double click switches to one screen pixel per pixel and back.
pub fn navigate(
    placement: &mut Placement,
    ui: &Ui,
    response: &Response,
    rect: Rect,
    bounds: PixelRect,
    left: LeftButton,
) -> PlacedPicture {
    let density = ui.ctx().pixels_per_point();
    placement.settle(bounds, screen_rect(rect));
    if response.drag_started() || response.clicked() {
        response.request_focus();
    }
    let draws = left == LeftButton::Draws;
    if response.dragged() && !(draws && response.dragged_by(PointerButton::Primary)) {
        placement.pan(on_screen(response.drag_delta().to_pos2()));
    }
    let pointer = ui.input(|input| input.pointer.hover_pos()).filter(|_| response.contains_pointer());
    if let Some(pointer) = pointer {
        let (scrolled, pinched) =
            ui.input(|input| (f64::from(input.smooth_scroll_delta().y), f64::from(input.zoom_delta())));
        let pinched = if draws && ui.input(|input| input.modifiers.command) { 1.0 } else { pinched };
        let factor = ZOOM_PER_POINT.powf(scrolled) * pinched;
        if factor != 1.0 {
            placement.zoom(screen_rect(rect), on_screen(pointer), factor);
        }
        if response.double_clicked() && !draws {
            match placement.is_fitted() {
                true => placement.show_pixels(screen_rect(rect), on_screen(pointer), density),
                false => placement.fit(),
            }
            placement.settle(bounds, screen_rect(rect));
        }
    }
    PlacedPicture::new(placement, rect, density)
}

/// Draws the buttons Fit and 1:1, and the zoom.
pub fn scale_ui(commands: Commands<'_>, ui: &mut Ui, magnification: f64, requests: &mut Vec<Request>) {
    ui.horizontal(|ui| {
        for (command, text) in [(&flat::FIT, "Fit"), (&flat::PIXELS, "1:1")] {
            if button_ui(ui, command, Button::new(text).small()) {
                requests.push(commands.requested(command));
            }
        }
        ui.monospace(format!("{:.0} %", 100.0 * magnification));
    });
}
