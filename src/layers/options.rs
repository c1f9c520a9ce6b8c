//! What the user may decide about the method: the command line's, the project's and the editor's.

use serde::{Deserialize, Serialize};

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
    /// a occludes b where depth_a (1 + tolerance) < depth_b. Relative; 0 < tolerance < 0.1.
    pub tolerance: f32,
    /// A refused edge of at most so many pixels is contact noise.
    pub min_support: u32,
    /// Pixels added around an element's bounding box on every side.
    pub margin: u32,
    /// Powers of two, or the exact box.
    pub boxes: BoxShape,
    /// Merge image layers within one visibility layer only, the rule of 2003.
    pub published: bool,
    /// Boxes are not merged beyond this side, in pixels (one element alone may exceed it).
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
