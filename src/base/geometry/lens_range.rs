//! The range of angles in which a lens model is valid, and the inverse of the model within it.

use std::f64::consts::{FRAC_PI_3, TAU};

use glam::{DMat2, DVec2};

use super::Lens;

/// A lens with the disc around the axis in which it is injective. Polynomial models are fitted to the photo's own
/// field of view; a little beyond it they may fold back and show everything a second time, mirrored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangedLens {
    lens: Lens,
    radius: f64,
}

/// The largest half opening angle of a pinhole image, 60 degrees: there it already needs four times the pixels
/// along a radius that a fisheye has.
const WIDEST_ANGLE: f64 = FRAC_PI_3;
/// The range ends where the distortion's area factor falls below this share of the central one, so that one source
/// pixel would be stretched over fifty.
const LEAST_SLOPE: f64 = 0.02;
/// The number of directions and of steps of the search: terms without symmetry vary slowly around the axis.
const DIRECTIONS: u32 = 32;
const STEPS: u32 = 128;

impl RangedLens {
    /// Finds the valid range of `lens`, at most 60 degrees from the axis.
    #[inline]
    pub fn new(lens: Lens) -> Self {
        let widest = WIDEST_ANGLE.tan();
        let radius = (0..DIRECTIONS)
            .map(|i| DVec2::from_angle(TAU * f64::from(i) / f64::from(DIRECTIONS)))
            .map(|direction| range_along(&lens, direction, widest))
            .fold(widest, f64::min);
        Self { lens, radius }
    }

    /// Returns the lens model.
    #[inline]
    pub fn lens(&self) -> &Lens {
        &self.lens
    }

    /// Returns the radius of the range, which is the tangent of the largest angle to the axis.
    #[inline]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Maps an undistorted point as [`Lens::distort`] does; `None` outside the range.
    #[inline]
    pub fn distort(&self, xy: DVec2) -> Option<DVec2> {
        (xy.length_squared() <= self.radius * self.radius).then(|| self.lens.distort(xy))
    }

    /// Returns the undistorted point within the range that maps to `distorted`, both normalised; `None` where there
    /// is none.
    #[inline]
    pub fn undistort(&self, distorted: DVec2) -> Option<DVec2> {
        let start = self.same_radius(distorted);
        let solved = self.newton(start, distorted)?;
        // The photo's border may lie exactly on the border of the range.
        (solved.length() <= self.radius * (1.0 + 1e-9)).then_some(solved)
    }

    /// Returns the point in the direction of `distorted` whose image has the same distance from the centre. It is
    /// the solution for lenses with radial terms only, and near it for all others.
    fn same_radius(&self, distorted: DVec2) -> DVec2 {
        let (direction, target) = (distorted.normalize_or_zero(), distorted.length());
        let (mut low, mut high) = (0.0, self.radius);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.lens.distort(direction * middle).length() < target { low = middle } else { high = middle }
        }
        direction * high
    }

    /// Solves `distort(xy) = target` by Newton's method; `None` where it does not converge.
    fn newton(&self, start: DVec2, target: DVec2) -> Option<DVec2> {
        let mut xy = start;
        for _ in 0..20 {
            let miss = self.lens.distort(xy) - target;
            // A millionth of a pixel even for a photo of 65,535.
            if miss.length() < 1e-12 * target.length().max(1.0) {
                return Some(xy);
            }
            let step = self.lens.jacobian(xy).inverse() * miss;
            // Steps are limited to a quarter of the range: where the slope is small, a full step overshoots.
            xy -= step.clamp_length_max(0.25 * self.radius);
            if !xy.is_finite() {
                return None;
            }
        }
        let miss = self.lens.distort(xy) - target;
        (miss.length() < 1e-9 * target.length().max(1.0)).then_some(xy)
    }
}

/// Returns the radius in one direction up to which the lens is valid, at most `widest`.
fn range_along(lens: &Lens, direction: DVec2, widest: f64) -> f64 {
    let central = lens.jacobian(DVec2::ZERO).determinant();
    let sound = |radius: f64| {
        let jacobian: DMat2 = lens.jacobian(direction * radius);
        // NaN compares false, too.
        jacobian.determinant() > LEAST_SLOPE * central && (jacobian * direction).dot(direction) > 0.0
    };
    let step = widest / f64::from(STEPS);
    let Some(first_bad) = (1..=STEPS).find(|&i| !sound(step * f64::from(i))) else { return widest };
    let (mut good, mut bad) = (step * f64::from(first_bad - 1), step * f64::from(first_bad));
    for _ in 0..40 {
        let middle = 0.5 * (good + bad);
        if sound(middle) { good = middle } else { bad = middle }
    }
    good
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::geometry::lens::EVERY_KIND;

    #[test]
    fn barrel_distortion_ends_where_its_radius_turns_back() {
        // r (1 - 0.2 r^2): slope 1 - 0.6 r^2, determinant (1 - 0.6 r^2)(1 - 0.2 r^2) = 0.02.
        let range = RangedLens::new(Lens::Brown { k: [-0.2, 0.0, 0.0, 0.0, 0.0, 0.0], p: [0.0; 2] });
        let r2 = range.radius() * range.radius();
        assert!(((1.0 - 0.6 * r2) * (1.0 - 0.2 * r2) - LEAST_SLOPE).abs() < 1e-6, "{r2}");
        assert!(range.distort(DVec2::new(0.0, 1.3)).is_none());
    }

    #[test]
    fn a_sound_lens_goes_to_sixty_degrees() {
        for lens in [Lens::None, Lens::Division { k: -0.1 }, Lens::Eucm { alpha: 0.6, beta: 1.1 }] {
            assert_eq!(RangedLens::new(lens).radius(), WIDEST_ANGLE.tan());
        }
    }

    #[test]
    fn a_division_lens_ends_before_its_root() {
        // 1 - 4 k r^2 = 0 at r = 0.5 for k = 1.
        let range = RangedLens::new(Lens::Division { k: 1.0 });
        assert!(range.radius() < 0.5 && range.radius() > 0.45, "{}", range.radius());
    }

    #[test]
    fn absurd_parameters_leave_a_small_range_and_no_panic() {
        for k in [-1e300, -1e6, 1e6, 1e300, f64::MAX] {
            let lens = Lens::Brown { k: [k, -k, k, 0.0, 0.0, 0.0], p: [k, 0.0] };
            let range = RangedLens::new(lens);
            assert!(range.radius() < 0.1, "{k}: {}", range.radius());
            assert_eq!(range.undistort(DVec2::new(0.3, 0.2)), None);
        }
    }

    #[test]
    fn tangential_terms_shrink_the_range_to_the_nearest_fold() {
        // Along y: y + 3 p y^2 has slope 1 + 6 p y, which vanishes at y = -1 / (6 p).
        let range = RangedLens::new(Lens::Brown { k: [0.0; 6], p: [0.2, 0.0] });
        assert!(range.radius() < 1.0 / 1.2 && range.radius() > 0.6, "{}", range.radius());
    }

    proptest! {
        #[test]
        fn the_inverse_leads_back(kind in 0..EVERY_KIND.len(), radius in 0.0..0.999, angle in 0.0..TAU) {
            let range = RangedLens::new(EVERY_KIND[kind]);
            let xy = DVec2::from_angle(angle) * radius * range.radius();
            let back = range.undistort(range.distort(xy).unwrap()).unwrap();
            prop_assert!((back - xy).length() < 1e-8, "{back} is not {xy}");
        }
    }
}
