//! Masks: what of a photo must not be used, drawn on it with brush and lasso, or suggested and accepted by click.
//!
//! A stroke is kept as a set of pixels while it goes on and drawn as cells of the screen, so that its cost is that of
//! its outline. Once it ends, a job writes the photo's new mask, and that is a step of the history; until then it waits
//! in a queue and is shown as if it were done.

pub mod drawing;
pub mod hand;
pub mod keeping;
pub mod known;
pub mod repairing;
pub mod strip;
pub mod suggesting;

use self::drawing::Overlay;
use self::hand::Stroke;
use self::keeping::Keeping;
use self::known::Known;
use self::suggesting::Suggested;
use crate::app::state::State;

/// What draws masks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tool {
    /// A round brush.
    Brush,
    /// A line around what is meant.
    Lasso,
}

impl Tool {
    /// In a sentence.
    pub fn name(self) -> &'static str {
        match self {
            Self::Brush => "brush",
            Self::Lasso => "lasso",
        }
    }
}

/// Of a photo's longer side, the first radius of the brush: somebody who stands at some distance is as wide as the
/// brush then.
const FIRST_RADIUS: f64 = 1.0 / 60.0;
/// The radii of the brush, in pixels of the photo.
pub const RADII_PX: std::ops::RangeInclusive<f64> = 0.5..=2000.0;
/// A step of a key makes the brush so much larger.
pub const STEP: f64 = 1.25;
/// Around a masked object, in pixels of the photo: models of large photos are wrong by about so many.
const FIRST_MARGIN_PX: u32 = 8;

/// How masks are drawn and shown.
pub struct Masking {
    /// What the mouse draws with in the photo.
    pub tool: Option<Tool>,
    /// It takes masks away.
    pub uncovers: bool,
    /// Masks are shown.
    pub shown: bool,
    /// Around an object that is masked, in pixels of the photo.
    pub margin_px: u32,
    /// What was found that might be masked.
    pub suggested: Suggested,
    radius_px: Option<f64>,
    stroke: Option<Stroke>,
    keeping: Keeping,
    known: Known,
    overlay: Overlay,
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
            overlay: Overlay::default(),
        }
    }
}

impl Masking {
    /// Takes a tool up, or puts it away where it was in use.
    pub fn toggle(&mut self, tool: Tool) {
        self.tool = (self.tool != Some(tool)).then_some(tool);
        self.stroke = None;
        // Nobody draws blindly.
        self.shown |= self.tool.is_some();
    }

    /// A stroke goes on.
    pub fn is_drawing(&self) -> bool {
        self.stroke.is_some()
    }

    /// Gives the stroke up that goes on; whether there was one.
    pub fn give_up(&mut self) -> bool {
        self.stroke.take().is_some()
    }

    /// Nothing waits to be kept.
    pub fn is_kept(&self) -> bool {
        self.keeping.is_empty()
    }

    /// What waits to be kept is not wanted any more.
    pub fn forget_waiting(&mut self) {
        self.keeping = Keeping::default();
    }

    /// The brush's radius, in pixels of a photo of this size.
    pub fn radius_px(&self, [width, height]: [u32; 2]) -> f64 {
        let first = f64::from(width.max(height)) * FIRST_RADIUS;
        self.radius_px.unwrap_or(first).clamp(*RADII_PX.start(), *RADII_PX.end())
    }

    /// Makes the brush larger.
    pub fn resize(&mut self, factor: f64, size: [u32; 2]) {
        let radius = self.radius_px(size) * factor;
        self.radius_px = Some(radius.clamp(*RADII_PX.start(), *RADII_PX.end()));
    }
}

impl State {
    /// The size of the selected photo.
    pub fn selected_photo_size(&self) -> Option<[u32; 2]> {
        let photo = self.selected_photo()?;
        let camera = &self.session.as_ref()?.opened.site.photos[photo].camera;
        Some([camera.width, camera.height])
    }
}
