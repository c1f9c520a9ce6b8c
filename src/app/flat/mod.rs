//! What flat views share: how a picture lies in a view, its tiles of texture, hatching.

pub mod hatch;
pub mod placement;
pub mod slot;
pub mod tiled;

use std::sync::Arc;
use std::time::SystemTime;

use eframe::egui::{CentralPanel, Color32, PointerButton, Rect, Response, Ui};

use self::hatch::Checkerboard;
use self::placement::{Placement, Seen};
use super::layer::LayerPane;
use super::photo::PhotoPane;
use crate::app::state::session::Session;
use crate::document::Stack;
use crate::geometry::PixelRect;
use crate::io::paint_store::PaintStore;

/// A step of a wheel comes nearer by this factor (egui's steps are about 40 points).
const ZOOM_PER_POINT: f64 = 1.0045;

/// What is drawn over flat views: chosen once for all of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Switches {
    /// Outlines of elements.
    pub outlines: bool,
    /// Stripes on what is hidden.
    pub hatching: bool,
    /// Rectangles of image layers.
    pub rectangles: bool,
    /// What fills hidden parts.
    pub filling: bool,
    /// Paint.
    pub paint: bool,
    /// Photos in one exposure.
    pub even: bool,
}

impl Default for Switches {
    fn default() -> Self {
        Self { outlines: true, hatching: true, rectangles: false, filling: true, paint: true, even: false }
    }
}

/// A picture in a flat view: where it lies, and what it lies on.
#[derive(Default)]
pub struct View {
    /// How it lies in the view.
    pub placement: Placement,
    /// The view on the screen, as it was drawn last.
    pub rect: Option<Rect>,
    /// Behind what is transparent.
    pub checkerboard: Checkerboard,
}

impl View {
    /// Shows the whole picture.
    pub fn fit(&mut self) {
        self.placement.fit();
    }

    /// Shows pixels as large as the screen's, `density` of which make a point.
    pub fn show_pixels(&mut self, density: f32) {
        if let Some(rect) = self.rect {
            self.placement.show_pixels(rect, rect.center(), density);
        }
    }

    /// Shows the picture larger.
    pub fn zoom(&mut self, factor: f64) {
        if let Some(rect) = self.rect {
            self.placement.zoom(rect, rect.center(), factor);
        }
    }
}

/// The flat views.
#[derive(Default)]
pub struct Flat {
    /// What is drawn over both.
    pub switches: Switches,
    /// The photo with its layers.
    pub photo: PhotoPane,
    /// One image layer.
    pub layer: LayerPane,
}

impl Flat {
    /// Forgets what belonged to a project; what the user chose stays.
    pub fn forget(&mut self) {
        *self = Self { switches: self.switches.clone(), ..Self::default() };
    }
}

/// What layers look like at a time: of this stack, with the paint as it is.
#[derive(Debug, Clone)]
pub struct Version {
    /// The stack that was read.
    pub stack: Arc<Stack>,
    painted: Option<SystemTime>,
}

impl Version {
    /// That of a photo now; none before it is built.
    pub fn of(session: &Session, photo: usize) -> Option<Self> {
        let stack = session.photos.get(photo)?.stack.clone()?;
        Some(Self { stack, painted: PaintStore::new(&session.folder).changed() })
    }
}

impl PartialEq for Version {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.stack, &other.stack) && self.painted == other.painted
    }
}

/// Behind pictures.
pub fn background(ui: &Ui) -> Color32 {
    if ui.visuals().dark_mode { Color32::from_gray(28) } else { Color32::from_gray(190) }
}

/// In place of a picture: what to do to see one.
pub fn nothing_ui(ui: &mut Ui, words: &str) {
    CentralPanel::default_margins().show(ui, |ui| ui.centered_and_justified(|ui| ui.label(words)));
}

/// What the left button does in a flat view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LeftButton {
    /// It moves the picture, as the others do.
    Moves,
    /// It belongs to a tool, and so does the wheel with Ctrl.
    Draws,
}

/// Moves a picture as mouse and wheel say, and says how it lies then: a drag moves, the wheel comes nearer to what is
/// under the pointer, a double click goes to the pixels' own size and back.
pub fn navigate(
    placement: &mut Placement,
    ui: &Ui,
    response: &Response,
    (rect, bounds): (Rect, PixelRect),
    left: LeftButton,
) -> Seen {
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
