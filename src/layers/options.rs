//! What the user may decide about the method: the command line's, the project's and the editor's.

use serde::{Deserialize, Serialize};

use super::cluster::SMALLEST_TILE;

/// Five times the tie of depths: depths in f32 tell no finer tolerance from rounding.
const LEAST_TOLERANCE: f32 = 1e-5;

/// How the visibility layers are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// The occlusion graph: every pair of fragments counted, cycles forgiven or cut.
    #[default]
    Graph,
    /// Stencil peeling as published in 2003; its order may be wrong, and it says where.
    Stencil,
}

/// The shape of an image layer's rectangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BoxShape {
    /// Width and height are powers of two.
    #[default]
    PowerOfTwo,
    /// The bounding box with its margin.
    Exact,
}

/// Options of the visibility sort and of the image layers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// How the visibility layers are found.
    pub method: Method,
    /// a occludes b where depth_a (1 + tolerance) < depth_b. Relative; 1e-5 <= tolerance < 0.1:
    /// below, rounding decides ([`super::rasteriser::TIE`]).
    pub tolerance: f32,
    /// A refused edge of at most so many pixels is contact noise.
    pub min_support: u32,
    /// Pixels added around an element's bounding box on every side.
    pub margin: u32,
    /// Powers of two, or the exact box.
    pub boxes: BoxShape,
    /// Merge image layers within one visibility layer only, the rule of 2003.
    pub published: bool,
    /// No image layer has a longer side, in pixels: larger elements get several, side by side.
    pub largest_side: u32,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            method: Method::Graph,
            tolerance: 1e-4,
            min_support: 16,
            margin: 1,
            boxes: BoxShape::PowerOfTwo,
            published: false,
            largest_side: 16384,
        }
    }
}

impl Options {
    /// What is wrong with them, named as in `project.json`; `None` when they can be used.
    pub fn problem(&self) -> Option<String> {
        // Written so that NaN is out of range too.
        if !(self.tolerance >= LEAST_TOLERANCE && self.tolerance < 0.1) {
            return Some(format!(
                "tolerance is {}, expected {LEAST_TOLERANCE} at least and less than 0.1",
                self.tolerance
            ));
        }
        if self.margin > LARGEST_MARGIN {
            return Some(format!("margin is {}, expected at most {LARGEST_MARGIN} pixels", self.margin));
        }
        if !(SMALLEST_TILE..=LARGEST_SIDE).contains(&self.largest_side) {
            return Some(format!(
                "largest_side is {}, expected {SMALLEST_TILE} to {LARGEST_SIDE} pixels",
                self.largest_side
            ));
        }
        // A tile keeps half of the smallest one beside its margins, within a power of two.
        if SMALLEST_TILE / 2 + 2 * self.margin > 1 << self.largest_side.ilog2() {
            return Some(format!(
                "largest_side is {}, too small for a margin of {} pixels on every side",
                self.largest_side, self.margin
            ));
        }
        None
    }
}

/// A wider margin than this is a slip of the keyboard.
const LARGEST_MARGIN: u32 = 4096;
/// The largest power of two that a rectangle's coordinates hold with room to add.
const LARGEST_SIDE: u32 = 1 << 20;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_can_be_used_and_what_is_out_of_range_is_named() {
        assert_eq!(Options::default().problem(), None);
        let worse = |options: Options| options.problem().unwrap_or_default();
        assert!(worse(Options { tolerance: f32::NAN, ..Options::default() }).contains("tolerance"));
        assert!(worse(Options { margin: u32::MAX, ..Options::default() }).contains("margin"));
        assert!(
            worse(Options { largest_side: 64, margin: 20, ..Options::default() }).contains("margin of 20")
        );
        assert!(worse(Options { largest_side: 0, ..Options::default() }).contains("largest_side"));
    }
}
