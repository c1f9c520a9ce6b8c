//! A plane with a point near its polygon, so that sites far from the origin lose no digits.

use glam::DVec3;

/// The plane through `point` with unit `normal`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// The unit normal, on the side from which the outline runs counter-clockwise.
    pub normal: DVec3,
    /// A point of the plane near the polygon.
    pub point: DVec3,
}

impl Plane {
    /// Returns the signed distance, positive on the normal's side, in the points' unit.
    #[inline]
    pub fn signed_distance(&self, point: DVec3) -> f64 {
        self.normal.dot(point - self.point)
    }
}
