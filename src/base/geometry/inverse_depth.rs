//! Planes as inverse depth over the image, computed to the same bits everywhere.

use glam::{DVec2, DVec3};

use super::Pinhole;

/// The inverse depth 1/z of a plane over the image, in f32, such that every implementation computes the same
/// bits: `(a * (x + 0.5 - u0) + b * (y + 0.5 - v0)) + c`, each operation rounded separately (never fused),
/// for the pixel in column x and row y. `u0` and `v0` are multiples of 0.5, so that the differences are
/// exact. Unit: 1 / world unit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct InverseDepth {
    /// Change per pixel to the right.
    pub a: f32,
    /// Change per pixel down.
    pub b: f32,
    /// The value at (`u0`, `v0`), which is the farthest point of the item within the photo, where the
    /// relative error would be largest.
    pub c: f32,
    /// Column coordinate in pixels of the point where `c` holds.
    pub u0: f32,
    /// Row coordinate in pixels of the point where `c` holds.
    pub v0: f32,
}

impl InverseDepth {
    /// Expresses the plane n . x = d (camera frame) as inverse depth over the image, expanded around `around`
    /// (pixels).
    pub fn of_plane(n: DVec3, d: f64, around: DVec2, camera: &Pinhole) -> Self {
        let around = (around * 2.0).round() / 2.0;
        Self {
            a: (n.x / camera.fx / d) as f32,
            b: (n.y / camera.fy / d) as f32,
            c: (n.dot(camera.ray_in_camera(around)) / d) as f32,
            u0: around.x as f32,
            v0: around.y as f32,
        }
    }

    /// Evaluates the inverse depth at the centre of the pixel in column `x`, row `y`.
    #[inline]
    pub fn at(&self, x: u32, y: u32) -> f32 {
        let du = (x as f32 + 0.5) - self.u0;
        let dv = (y as f32 + 0.5) - self.v0;
        (self.a * du + self.b * dv) + self.c
    }
}
