//! Masks mark the pixels of a photo that must not be used: drawn with brush and lasso, or accepted from suggestions.
//!
//! A stroke is a set of pixels while it is drawn, and its display is made of cells of screen pixels, so that its cost
//! is that of its outline. When it ends, a job writes the photo's new mask as a step of the history; until then the
//! stroke waits in a queue and is shown as if it were done.

pub mod keeping;
pub mod mask_cache;
pub mod queries;
pub mod stroke;
pub mod suggested;
pub mod tool;

use self::keeping::Keeping;
use self::mask_cache::MaskCache;
use self::stroke::MaskStroke;
use self::suggested::Suggested;
use self::tool::MaskTool;
use quadratura_document::masks::MaskOrigin;

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
    /// The stroke that is being drawn.
    pub stroke: Option<MaskStroke>,
    /// The edits that wait to be written.
    pub keeping: Keeping,
    /// The pixels of masks.
    pub cache: MaskCache,
    radius_px: Option<f64>,
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
            cache: MaskCache::default(),
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

    /// Returns whether no edit of masks waits or is being written.
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

/// Returns the origin of a mask in words.
pub fn origin_words(from: &MaskOrigin) -> String {
    match from {
        MaskOrigin::Drawn => "drawn by hand".into(),
        MaskOrigin::Suggested => "from suggestions".into(),
        other => other.words(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::PhotoId;

    #[test]
    fn a_tool_that_is_taken_up_shows_masks_and_ends_the_stroke_of_another() {
        let mut masking = Masking { shown: false, ..Masking::default() };
        masking.stroke = Some(MaskStroke::new(PhotoId(0), MaskTool::Brush, false, 1.0));
        masking.toggle(MaskTool::Lasso);
        assert!(masking.shown && !masking.is_drawing() && masking.tool == Some(MaskTool::Lasso));
        masking.toggle(MaskTool::Lasso);
        assert!(masking.shown && masking.tool.is_none());
    }

    #[test]
    fn the_brush_grows_from_a_share_of_the_photo_and_stays_within_its_range() {
        let mut masking = Masking::default();
        assert_eq!(masking.radius_px([6000, 4000]), 100.0);
        masking.resize(1.5, [6000, 4000]);
        assert_eq!(masking.radius_px([600, 400]), 150.0, "a size that was chosen is kept");
        masking.resize(1e9, [6000, 4000]);
        assert_eq!(masking.radius_px([6000, 4000]), *RADII_PX.end());
        masking.resize(1e-9, [6000, 4000]);
        assert_eq!(masking.radius_px([6000, 4000]), *RADII_PX.start());
    }

    #[test]
    fn a_stroke_is_given_up_once() {
        let stroke = Some(MaskStroke::new(PhotoId(0), MaskTool::Brush, false, 1.0));
        let mut masking = Masking { stroke, ..Masking::default() };
        assert!(masking.give_up() && !masking.give_up());
    }
}
