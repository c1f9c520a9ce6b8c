//! Options of the method, shared by the command line, the project file and the editor.

use serde::{Deserialize, Serialize};

use super::cluster::SMALLEST_TILE;

/// The smallest tolerance allowed: five times [`super::rasteriser::TIE`], because depths in f32 cannot
/// separate a finer tolerance from rounding.
const LEAST_TOLERANCE: f32 = 1e-5;

/// The algorithm that finds the visibility layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// The occlusion graph: every pair of fragments is counted, cycles are forgiven or cut.
    #[default]
    Graph,
    /// Stencil peeling as published in 2003; its order may be wrong, and the contradictions are reported.
    Stencil,
}

/// The shape of an image layer's rectangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BoxShape {
    /// Width and height are powers of two.
    #[default]
    PowerOfTwo,
    /// Width and height are the bounding box's with its margin.
    Exact,
}

/// Options of the visibility sort and of the image layers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// The algorithm that finds the visibility layers.
    pub method: Method,
    /// Relative depth tolerance: a occludes b where depth_a (1 + tolerance) < depth_b. Range: 1e-5 <=
    /// tolerance < 0.1; below that, rounding decides ([`super::rasteriser::TIE`]).
    pub tolerance: f32,
    /// The largest support, in pixels, at which a refused edge counts as contact noise.
    pub min_support: u32,
    /// Pixels added on every side of an element's bounding box.
    pub margin: u32,
    /// The shape of rectangles: sides that are powers of two, or the exact box.
    pub boxes: BoxShape,
    /// Merges image layers within one visibility layer only, as published in 2003.
    pub published: bool,
    /// The longest side that an image layer may have, in pixels; larger elements are split into several side
    /// by side.
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
    /// Describes the first option that is out of range, named as in `project.json`; `None` when all options
    /// are valid.
    pub fn problem(&self) -> Option<String> {
        // The condition is negated so that NaN counts as out of range too.
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
        // After subtracting its margins, a tile has to keep half of the smallest tile's side, within a power
        // of two.
        if SMALLEST_TILE / 2 + 2 * self.margin > 1 << self.largest_side.ilog2() {
            return Some(format!(
                "largest_side is {}, too small for a margin of {} pixels on every side",
                self.largest_side, self.margin
            ));
        }
        None
    }
}

/// The largest margin allowed, in pixels; a wider one is taken for a typing error.
const LARGEST_MARGIN: u32 = 4096;
/// The largest side allowed, in pixels: the largest power of two that leaves rectangle coordinates in i32
/// room for additions.
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
