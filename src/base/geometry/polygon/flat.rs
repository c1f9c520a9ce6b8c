//! Rings in plane coordinates: two coordinates in the ring's plane, local origin, unit extent.

use glam::{DVec2, DVec3};

use super::plane_fit::{extent, resolution};
use crate::geometry::Plane;

/// An orthonormal frame (u, v) of a plane with `u x v` its normal: what runs counter-clockwise around the normal
/// runs counter-clockwise in (u, v). Axis-parallel planes get axis-parallel axes.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PlaneFrame {
    /// The point of the plane with coordinates (0, 0).
    pub origin: DVec3,
    /// The first axis, of unit length.
    pub u: DVec3,
    /// The second axis, of unit length and at right angles to `u`.
    pub v: DVec3,
}

impl PlaneFrame {
    /// Makes a frame around the plane's own point.
    pub fn from_plane(plane: &Plane) -> Self {
        let (u, v) = plane.normal.any_orthonormal_pair();
        Self { origin: plane.point, u, v }
    }

    /// Projects a point onto the plane and returns its two coordinates.
    pub fn flat(&self, point: DVec3) -> DVec2 {
        let offset = point - self.origin;
        DVec2::new(offset.dot(self.u), offset.dot(self.v))
    }

    /// Returns the point of the plane with these coordinates.
    pub fn raised(&self, point: DVec2) -> DVec3 {
        self.origin + self.u * point.x + self.v * point.y
    }
}

/// Points in plane coordinates, scaled to an extent of one, which keeps products of tiny and of huge models within
/// the range of f64.
pub(super) struct PlanePoints {
    pub frame: PlaneFrame,
    /// Units of the model per unit of `points`.
    pub scale: f64,
    pub points: Vec<DVec2>,
    /// The distance, in units of `points`, below which differences are rounding errors.
    pub resolution: f64,
}

impl PlanePoints {
    /// Projects points into their plane and scales them; `None` when all points coincide.
    pub fn new(points: &[DVec3], plane: &Plane) -> Option<Self> {
        let scale = extent(points);
        if !(scale > 0.0 && scale.is_finite()) {
            return None;
        }
        let frame = PlaneFrame::from_plane(plane);
        let flat = |p: &DVec3| frame.flat(*p) / scale;
        Some(Self {
            frame,
            scale,
            points: points.iter().map(flat).collect(),
            resolution: resolution(points) / scale,
        })
    }

    /// Returns the point of the model at a flat point.
    pub fn raised(&self, point: DVec2) -> DVec3 {
        self.frame.raised(point * self.scale)
    }
}

/// Returns the signed area of a ring, positive when it runs counter-clockwise.
pub(super) fn signed_area(ring: impl ExactSizeIterator<Item = DVec2> + Clone) -> f64 {
    let next = ring.clone().cycle().skip(1);
    ring.zip(next).map(|(a, b)| a.perp_dot(b)).sum::<f64>() / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_frame_turns_like_its_normal() {
        for normal in [DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::new(0.6, 0.0, -0.8)] {
            let frame = PlaneFrame::from_plane(&Plane { normal, point: DVec3::ONE });
            assert!((frame.u.cross(frame.v) - normal).length() < 1e-15);
            let p = frame.raised(DVec2::new(3.0, -2.0));
            assert!((frame.flat(p) - DVec2::new(3.0, -2.0)).length() < 1e-14);
        }
    }

    #[test]
    fn a_unit_square_has_area_one_with_the_sign_of_its_winding() {
        let square = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        assert_eq!(signed_area(square.into_iter()), 1.0);
        assert_eq!(signed_area(square.into_iter().rev()), -1.0);
    }
}
