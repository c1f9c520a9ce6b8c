//! Masks mark the pixels of a photo that must not be used: drawn with brush and lasso, or accepted from suggestions.
//!
//! A stroke is a set of pixels while it is drawn, and its display is made of cells of screen pixels, so that its cost
//! is that of its outline. When it ends, a job writes the photo's new mask as a step of the history; until then the
//! stroke waits in a queue and is shown as if it were done.

pub mod drawing;
pub mod hand;
pub mod keeping;
pub mod known;
pub mod repairing;
pub mod strip;
pub mod suggesting;

use self::drawing::MaskOverlay;
use self::hand::Stroke;
use self::keeping::Keeping;
use self::known::Known;
use self::suggesting::Suggested;
use crate::app::state::State;

/// A tool that draws masks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MaskTool {
    /// A round brush.
    Brush,
    /// A closed outline.
    Lasso,
}

impl MaskTool {
    /// Returns the tool's name, for use in a sentence.
    pub fn name(self) -> &'static str {
        match self {
            Self::Brush => "brush",
            Self::Lasso => "lasso",
        }
    }
}

/// The first radius of the brush, as a share of the photo's longer side: about the width of a person at some distance.
const FIRST_RADIUS: f64 = 1.0 / 60.0;
/// The radii of the brush, in photo pixels.
pub const RADII_PX: std::ops::RangeInclusive<f64> = 0.5..=2000.0;
/// The factor by which a key resizes the brush.
pub const STEP: f64 = 1.25;
/// The default margin around a masked object, in photo pixels: the usual error of models in large photos.
const FIRST_MARGIN_PX: u32 = 8;

/// The state of masks, tools and suggestions.
pub struct Masking {
    /// The tool in use.
    pub tool: Option<MaskTool>,
    /// Whether the tool erases.
    pub uncovers: bool,
    /// Whether masks are shown.
    pub shown: bool,
    /// The margin around masked objects, in photo pixels.
    pub margin_px: u32,
    /// The suggestions.
    pub suggested: Suggested,
    radius_px: Option<f64>,
    stroke: Option<Stroke>,
    keeping: Keeping,
    known: Known,
    overlay: MaskOverlay,
}

impl Default for Masking {
    fn default() -> Self {
        Self {
            tool: None,
            uncovers: false,
            shown: true,
            margin_px: FIRST_MARGIN_PX,
            suggested: Suggested::default(),
            radius_px: None,
            stroke: None,
            keeping: Keeping::default(),
            known: Known::default(),
            overlay: MaskOverlay::default(),
        }
    }
}

impl Masking {
    /// Selects a tool, or deselects it where it is in use.
    pub fn toggle(&mut self, tool: MaskTool) {
        self.tool = (self.tool != Some(tool)).then_some(tool);
        self.stroke = None;
        // Masks are shown while a tool is in use.
        self.shown |= self.tool.is_some();
    }

    /// Returns whether a stroke is being drawn.
    pub fn is_drawing(&self) -> bool {
        self.stroke.is_some()
    }

    /// Cancels the current stroke; returns whether there was one.
    pub fn give_up(&mut self) -> bool {
        self.stroke.take().is_some()
    }

    /// Returns whether all edits of masks are written.
    pub fn is_kept(&self) -> bool {
        self.keeping.is_empty()
    }

    /// Drops the edits that wait to be written.
    pub fn forget_waiting(&mut self) {
        self.keeping = Keeping::default();
    }

    /// Returns the brush's radius, in pixels of a photo of this size.
    pub fn radius_px(&self, [width, height]: [u32; 2]) -> f64 {
        let first = f64::from(width.max(height)) * FIRST_RADIUS;
        self.radius_px.unwrap_or(first).clamp(*RADII_PX.start(), *RADII_PX.end())
    }

    /// Resizes the brush by a factor.
    pub fn resize(&mut self, factor: f64, size: [u32; 2]) {
        let radius = self.radius_px(size) * factor;
        self.radius_px = Some(radius.clamp(*RADII_PX.start(), *RADII_PX.end()));
    }
}

impl State {
    /// Returns the size of the selected photo, in pixels.
    pub fn selected_photo_size(&self) -> Option<[u32; 2]> {
        let photo = self.selected_photo()?;
        let camera = &self.session.as_ref()?.opened.site.photos[photo].camera;
        Some([camera.width, camera.height])
    }
}
