//! Parts that the flat views share: the placement of a picture in a view, textures in tiles, hatching.

pub mod hatch;
pub mod placement;
pub mod slot;
pub mod tiled;

use std::sync::Arc;
use std::time::SystemTime;

use eframe::egui::{CentralPanel, Color32, PointerButton, Rect, Response, Ui};

use self::hatch::Checkerboard;
use self::placement::{PlacedPicture, Placement};
use super::layer::LayerViewState;
use super::photo::PhotoPane;
use crate::app::state::session::Session;
use crate::document::Stack;
use crate::geometry::PixelRect;
use crate::io::paint_store::PaintStore;

/// The zoom factor of one point of wheel movement (a step of a wheel is about 40 points in egui).
const ZOOM_PER_POINT: f64 = 1.0045;

/// Overlays of the flat views; one set of switches applies to all of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Switches {
    /// Whether outlines of elements are drawn.
    pub outlines: bool,
    /// Whether hidden areas are hatched.
    pub hatching: bool,
    /// Whether rectangles of image layers are drawn.
    pub rectangles: bool,
    /// Whether the filling of occluded areas is drawn.
    pub filling: bool,
    /// Whether paint is drawn.
    pub paint: bool,
    /// Whether photos are drawn with matched exposure.
    pub even: bool,
}

impl Default for Switches {
    fn default() -> Self {
        Self { outlines: true, hatching: true, rectangles: false, filling: true, paint: true, even: false }
    }
}

/// A picture in a flat view: its placement, and the checkerboard behind it.
#[derive(Default)]
pub struct PlacedView {
    /// The placement of the picture in the view.
    pub placement: Placement,
    /// The rectangle of the view on the screen, as it was drawn last.
    pub rect: Option<Rect>,
    /// The checkerboard behind transparent areas.
    pub checkerboard: Checkerboard,
}

impl PlacedView {
    /// Fits the whole picture into the view.
    pub fn fit(&mut self) {
        self.placement.fit();
    }

    /// Shows one pixel of the picture as one of the screen; a point has `density` screen pixels.
    pub fn show_pixels(&mut self, density: f32) {
        if let Some(rect) = self.rect {
            self.placement.show_pixels(rect, rect.center(), density);
        }
    }

    /// Zooms by a factor.
    pub fn zoom(&mut self, factor: f64) {
        if let Some(rect) = self.rect {
            self.placement.zoom(rect, rect.center(), factor);
        }
    }
}

/// The state of the flat views.
#[derive(Default)]
pub struct FlatViews {
    /// The overlays of both views.
    pub switches: Switches,
    /// The view of the photo with its layers.
    pub photo: PhotoPane,
    /// The view of one image layer.
    pub layer: LayerViewState,
}

impl FlatViews {
    /// Resets the state that belongs to a project; the user's choices are kept.
    pub fn forget(&mut self) {
        *self = Self { switches: self.switches.clone(), ..Self::default() };
    }
}

/// A version of a photo's layers: a stack, with the paint at that time.
#[derive(Debug, Clone)]
pub struct LayersVersion {
    /// The stack that was read.
    pub stack: Arc<Stack>,
    painted: Option<SystemTime>,
}

impl LayersVersion {
    /// Returns the current version of a photo; none before it is built.
    pub fn new(session: &Session, photo: usize) -> Option<Self> {
        let stack = session.photos.get(photo)?.stack.clone()?;
        Some(Self { stack, painted: PaintStore::new(&session.folder).changed() })
    }
}

impl PartialEq for LayersVersion {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.stack, &other.stack) && self.painted == other.painted
    }
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
    (rect, bounds): (Rect, PixelRect),
    left: LeftButton,
) -> PlacedPicture {
    let density = ui.ctx().pixels_per_point();
    placement.settle(bounds, rect);
    if response.drag_started() || response.clicked() {
        response.request_focus();
    }
    let draws = left == LeftButton::Draws;
    if response.dragged() && !(draws && response.dragged_by(PointerButton::Primary)) {
        placement.pan(response.drag_delta());
    }
    let pointer = ui.input(|input| input.pointer.hover_pos()).filter(|_| response.contains_pointer());
    if let Some(pointer) = pointer {
        let (scrolled, pinched) =
            ui.input(|input| (f64::from(input.smooth_scroll_delta().y), f64::from(input.zoom_delta())));
        let pinched = if draws && ui.input(|input| input.modifiers.command) { 1.0 } else { pinched };
        let factor = ZOOM_PER_POINT.powf(scrolled) * pinched;
        if factor != 1.0 {
            placement.zoom(rect, pointer, factor);
        }
        if response.double_clicked() && !draws {
            match placement.is_fitted() {
                true => placement.show_pixels(rect, pointer, density),
                false => placement.fit(),
            }
            placement.settle(bounds, rect);
        }
    }
    placement.seen(rect, density)
}
