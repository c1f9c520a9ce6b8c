//! The order in which depth pixels are drawn so that nearer ones come last, without any comparison of depths.
//!
//! McMillan, *A List-Priority Rendering Algorithm for Redisplaying Projected Surfaces* (1995), used by Gortler, He & Cohen
//! 1997, section 3: in each quadrant around the epipole, pixels are walked towards it or away from it. Here the nine places
//! of the epipole and its three signs need no cases: with D(p) = (E_x - E_z x, E_y - E_z y), a quadrant is where both signs
//! are constant, and it is walked along x in the direction of the sign of D_x, along y in that of D_y.

use std::ops::Range;

use glam::DVec3;

/// A part of a frame that is walked in one direction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Quadrant {
    /// The columns.
    pub columns: Range<u32>,
    /// The rows.
    pub rows: Range<u32>,
    /// True when columns are walked to the right.
    pub right: bool,
    /// True when rows are walked down.
    pub down: bool,
}

/// The parts of one axis in the order in which they are walked: pixels, and whether upwards.
fn parts(pixels: u32, e: f64, e_z: f64) -> [(Range<u32>, bool); 2] {
    let split = match e_z {
        0.0 => pixels,
        _ => (e / e_z - 0.5).ceil().clamp(0.0, f64::from(pixels)) as u32,
    };
    let forward = e_z > 0.0 || (e_z == 0.0 && e >= 0.0);
    [(0..split, forward), (split..pixels, !forward)]
}

/// Returns the quadrants of a frame of `size` pixels with this epipole, homogeneous in pixels, in the order in which they
/// are drawn; none is empty.
pub fn quadrants(size: [u32; 2], epipole: DVec3) -> Vec<Quadrant> {
    let mut quadrants = Vec::with_capacity(4);
    for (rows, down) in parts(size[1], epipole.y, epipole.z) {
        for (columns, right) in parts(size[0], epipole.x, epipole.z) {
            if !rows.is_empty() && !columns.is_empty() {
                quadrants.push(Quadrant { columns, rows: rows.clone(), right, down });
            }
        }
    }
    quadrants
}

/// Returns the same quadrants in the opposite order, for tests: nearer depth pixels come first.
pub fn reversed(quadrants: &[Quadrant]) -> Vec<Quadrant> {
    let turned = |q: &Quadrant| Quadrant { right: !q.right, down: !q.down, ..q.clone() };
    quadrants.iter().rev().map(turned).collect()
}
