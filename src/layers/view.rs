//! One photo's view of the model, ready for a rasteriser: planar items with their triangles in
//! homogeneous clip coordinates and their planes as inverse depth over the image.

use crate::scene::FaceId;

/// An item's place in [`View::items`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ItemId(pub u32);

/// What the visibility sort orders: a planar face, or one triangle of a face that is not planar.
#[derive(Debug, Clone, PartialEq)]
pub struct Item {
    /// The face.
    pub face: FaceId,
    /// Which of its triangles, when the face is not planar.
    pub triangle: Option<u32>,
    /// The item's plane.
    pub inverse_depth: InverseDepth,
    /// The photo sees it from behind.
    pub back: bool,
}

/// The inverse depth 1/z of a plane over the image, in f32, such that every implementation computes
/// the same bits: `(a * (x + 0.5 - u0) + b * (y + 0.5 - v0)) + c`, each operation rounded by
/// itself (never fused), for the pixel in column x and row y. `u0`, `v0` are multiples of 0.5, so
/// the differences are exact. Units: 1 / world unit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct InverseDepth {
    /// Change per pixel to the right.
    pub a: f32,
    /// Change per pixel down.
    pub b: f32,
    /// The value at (`u0`, `v0`), the farthest point of the item within the photo, where the
    /// relative error would be largest.
    pub c: f32,
    /// Image position in pixels where `c` holds.
    pub u0: f32,
    /// Image position in pixels where `c` holds.
    pub v0: f32,
}

impl InverseDepth {
    /// The value at the centre of the pixel in column `x`, row `y`.
    #[inline]
    pub fn at(&self, x: u32, y: u32) -> f32 {
        let du = (x as f32 + 0.5) - self.u0;
        let dv = (y as f32 + 0.5) - self.v0;
        (self.a * du + self.b * dv) + self.c
    }
}

/// One photo's view of the model.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct View {
    /// Size of the photo in pixels.
    pub width: u32,
    /// Size of the photo in pixels.
    pub height: u32,
    /// In model order: of items visible at one pixel, the later one owns it.
    pub items: Vec<Item>,
    /// Triangles in item order, corners in homogeneous clip coordinates (x, y, w): the image
    /// position in pixels is ((x/w + 1) width/2, (1 - y/w) height/2), w is the depth in world
    /// units; corners behind the camera have w <= 0 and are clipped by the rasteriser.
    pub corners: Vec<[[f32; 3]; 3]>,
    /// The item of each triangle; never decreases.
    pub triangle_items: Vec<u32>,
    /// An upper bound of the inverse depth of anything in the photo; a power of two.
    pub largest_inverse_depth: f32,
}
