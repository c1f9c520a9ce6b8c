//! The pages of the inspector about objects, faces and image layers.

pub mod layer;
pub mod surface;
pub mod tree;
pub mod trees;

/// The greatest height of lists on a page, in points: the parts below stay within reach.
const LIST: f32 = 260.0;
