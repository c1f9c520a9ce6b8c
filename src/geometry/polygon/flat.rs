//! A ring laid flat: two coordinates in its plane, local origin, unit extent.

use glam::{DVec2, DVec3};

use super::plane_fit::{extent, resolution};
use crate::geometry::Plane;

/// Two axes in a plane, such that `u x v` is its normal: what runs counter-clockwise around the
/// normal runs counter-clockwise in (u, v). Axis-parallel planes get axis-parallel axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneFrame {
    /// A point of the plane, (0, 0).
    pub origin: DVec3,
    /// Unit length.
    pub u: DVec3,
    /// Unit length, at right angles to `u`.
    pub v: DVec3,
}

impl PlaneFrame {
    /// The frame of a plane around its own point.
    pub fn of(plane: &Plane) -> Self {
        let (u, v) = plane.normal.any_orthonormal_pair();
        Self { origin: plane.point, u, v }
    }

    /// The point's foot in the plane, in its two coordinates.
    pub fn flat(&self, point: DVec3) -> DVec2 {
        let offset = point - self.origin;
        DVec2::new(offset.dot(self.u), offset.dot(self.v))
    }

    /// The point of the plane with these coordinates.
    pub fn raised(&self, point: DVec2) -> DVec3 {
        self.origin + self.u * point.x + self.v * point.y
    }
}

/// Points laid flat and scaled to an extent of one, which keeps the products of tiny and of huge
/// models within range.
pub(super) struct Flat {
    pub frame: PlaneFrame,
    /// Units of the model per unit here.
    pub scale: f64,
    pub points: Vec<DVec2>,
    /// Distances below this are rounding.
    pub resolution: f64,
}

impl Flat {
    /// `None` when the points coincide.
    pub fn new(points: &[DVec3], plane: &Plane) -> Option<Self> {
        let scale = extent(points);
        if !(scale > 0.0 && scale.is_finite()) {
            return None;
        }
        let frame = PlaneFrame::of(plane);
        let flat = |p: &DVec3| frame.flat(*p) / scale;
        Some(Self {
            frame,
            scale,
            points: points.iter().map(flat).collect(),
            resolution: resolution(points) / scale,
        })
    }

    /// Takes a flat point back to the model.
    pub fn raised(&self, point: DVec2) -> DVec3 {
        self.frame.raised(point * self.scale)
    }
}

/// The area of a ring, positive when it runs counter-clockwise.
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
            let frame = PlaneFrame::of(&Plane { normal, point: DVec3::ONE });
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
