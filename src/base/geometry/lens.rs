//! Forward lens distortion: from the undistorted to the distorted image plane.
//!
//! Coordinates are normalised: x = X/Z, y = Y/Z in the camera frame, x right, y down. Pixels follow as f * x + c
//! with the focal lengths and the principal point of the *distorted* photo. Every model maps (0, 0) to itself.
//! Sources of the formulas: Brown 1966 (radial, tangential), Devernay and Faugeras 2001 (field of view), Kannala
//! and Brandt 2006 (fisheye), Weng et al. 1992 (thin prism), Fitzgibbon 2001 (division), Khomutenko et al. 2016
//! (enhanced unified). Parameters are in COLMAP's order.

use std::fmt;

use glam::{DMat2, DVec2};

/// A lens distortion model with its parameters, which have no unit unless one is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lens {
    /// No distortion.
    None,
    /// Brown's model: radial `(1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6)`, then tangential.
    Brown {
        /// Radial coefficients k1..k6.
        k: [f64; 6],
        /// Tangential coefficients p1, p2 in OpenCV's order.
        p: [f64; 2],
    },
    /// The ideal field-of-view model of Devernay and Faugeras.
    Fov {
        /// The model's opening angle in radians.
        omega: f64,
    },
    /// An equidistant fisheye: the radius is the angle theta to the axis, times `1 + k1 theta^2 + .. + k4 theta^8`,
    /// with tangential and thin-prism terms added.
    Fisheye {
        /// Radial coefficients k1..k4.
        k: [f64; 4],
        /// Tangential coefficients p1, p2 in OpenCV's order.
        p: [f64; 2],
        /// Thin-prism coefficients sx1, sy1: a shift by s * theta^2.
        s: [f64; 2],
    },
    /// An equidistant fisheye whose tangential and prism terms act on the radially distorted point.
    PrismFisheye {
        /// Radial coefficients k0..k5 of theta^2 to theta^12.
        k: [f64; 6],
        /// Tangential coefficients: p0 goes with x^2 (OpenCV's p2), p1 with y^2.
        p: [f64; 2],
        /// Prism coefficients s0, s1 along x and s2, s3 along y: a shift by `s0 r^2 + s1 r^4`.
        s: [f64; 4],
    },
    /// The division model: undistorted = distorted / (1 + k r_distorted^2).
    Division {
        /// The coefficient; negative for barrel distortion.
        k: f64,
    },
    /// Brown's model as Metashape and RealityScan have it: radial `1 + k1 r^2 + .. + k4 r^8`, then tangential, then x moved by
    /// `skew` times y, for pixels whose sides are not at right angles.
    Skewed {
        /// Radial coefficients k1..k4.
        k: [f64; 4],
        /// Tangential coefficients p1, p2 in OpenCV's order.
        p: [f64; 2],
        /// The shift of the distorted x per unit of the distorted y.
        skew: f64,
    },
    /// VisualSFM's model, whose polynomial acts on the measurement: undistorted = distorted (1 + k r_distorted^2).
    Reverse {
        /// The coefficient; positive for barrel distortion.
        k: f64,
    },
    /// The enhanced unified camera model: x = X / (alpha sqrt(beta (X^2 + Y^2) + Z^2) + (1 - alpha) Z).
    Eucm {
        /// The blend parameter, 0..=1.
        alpha: f64,
        /// The shape parameter, positive.
        beta: f64,
    },
}

/// A lens is displayed by the name of its model and the coefficients that are not 0.
impl fmt::Display for Lens {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The name, and the coefficients of each letter with the number of the first.
        let (name, coefficients) = match self {
            Self::None => ("no distortion", Vec::new()),
            Self::Brown { k, p } => ("Brown", vec![("k", 1, &k[..]), ("p", 1, &p[..])]),
            Self::Fov { omega } => return write!(f, "FOV, omega {omega:?}"),
            Self::Fisheye { k, p, s } => {
                ("fisheye", vec![("k", 1, &k[..]), ("p", 1, &p[..]), ("sx", 1, &s[..1]), ("sy", 1, &s[1..])])
            }
            Self::PrismFisheye { k, p, s } => {
                ("prism fisheye", vec![("k", 0, &k[..]), ("p", 0, &p[..]), ("s", 0, &s[..])])
            }
            Self::Division { k } => return write!(f, "division, k {k:?}"),
            Self::Skewed { k, p, skew } => {
                ("Brown", vec![("k", 1, &k[..]), ("p", 1, &p[..]), ("skew", 1, std::slice::from_ref(skew))])
            }
            Self::Reverse { k } => return write!(f, "VisualSFM, k {k:?}"),
            Self::Eucm { alpha, beta } => return write!(f, "EUCM, alpha {alpha:?}, beta {beta:?}"),
        };
        f.write_str(name)?;
        for (letter, first, values) in coefficients {
            for (index, value) in values.iter().enumerate().filter(|(_, value)| **value != 0.0) {
                write!(f, ", {letter}{} {value:?}", first + index)?;
            }
        }
        Ok(())
    }
}

impl Lens {
    /// Returns true when the lens changes no point, so that the photo is a pinhole image already.
    #[inline]
    pub fn is_none(&self) -> bool {
        match *self {
            Self::None => true,
            Self::Brown { k, p } => k == [0.0; 6] && p == [0.0; 2],
            Self::Fov { omega } => omega == 0.0,
            Self::Fisheye { .. } | Self::PrismFisheye { .. } => false,
            Self::Division { k } | Self::Reverse { k } => k == 0.0,
            Self::Skewed { k, p, skew } => k == [0.0; 4] && p == [0.0; 2] && skew == 0.0,
            Self::Eucm { alpha, .. } => alpha == 0.0,
        }
    }

    /// Returns the magnification on the axis, which is 1 except for the field-of-view model.
    #[inline]
    pub(crate) fn central_magnification(&self) -> f64 {
        match *self {
            Self::Fov { omega } => fov_factor(0.0, omega),
            _ => 1.0,
        }
    }

    /// Maps the undistorted point `xy` to the distorted plane, both normalised. It does not check that `xy` is
    /// within the range where the model is valid (see [`super::RangedLens`]); the result is not finite where the
    /// formula has no value.
    pub fn distort(&self, xy: DVec2) -> DVec2 {
        match *self {
            Self::None => xy,
            Self::Brown { k, p } => brown(xy, k, p),
            Self::Fov { omega } => xy * fov_factor(xy.length(), omega),
            Self::Fisheye { k, p, s } => fisheye(equidistant(xy), k, p, s),
            Self::PrismFisheye { k, p, s } => prism_fisheye(equidistant(xy), k, p, s),
            Self::Division { k } => xy * (2.0 / (1.0 + (1.0 - 4.0 * k * xy.length_squared()).sqrt())),
            Self::Skewed { k, p, skew } => {
                let bent = xy * (1.0 + polynomial(&k, xy.length_squared())) + tangential(xy, p);
                DVec2::new(bent.x + skew * bent.y, bent.y)
            }
            Self::Reverse { k } => xy * reverse_factor(xy.length(), k),
            Self::Eucm { alpha, beta } => {
                xy / (alpha * (beta * xy.length_squared() + 1.0).sqrt() + (1.0 - alpha))
            }
        }
    }

    /// Returns the derivative of [`Lens::distort`] at `xy` by central differences; columns are d/dx, d/dy.
    #[inline]
    pub fn jacobian(&self, xy: DVec2) -> DMat2 {
        // The step balances truncation (h^2) against cancellation (1e-16 / h): error near 1e-10.
        let h = 1e-5 * xy.length().max(1.0);
        let along = |step: DVec2| (self.distort(xy + step) - self.distort(xy - step)) / (2.0 * h);
        DMat2::from_cols(along(DVec2::new(h, 0.0)), along(DVec2::new(0.0, h)))
    }
}

/// Applies the rational radial and the tangential terms of Brown's model.
fn brown(xy: DVec2, k: [f64; 6], p: [f64; 2]) -> DVec2 {
    let r2 = xy.length_squared();
    let radial = (1.0 + polynomial(&k[..3], r2)) / (1.0 + polynomial(&k[3..], r2));
    xy * radial + tangential(xy, p)
}

/// Applies radial, tangential and prism terms to the equidistant point `uv`.
fn fisheye(uv: DVec2, k: [f64; 4], p: [f64; 2], s: [f64; 2]) -> DVec2 {
    let theta2 = uv.length_squared();
    uv * (1.0 + polynomial(&k, theta2)) + tangential(uv, p) + DVec2::from(s) * theta2
}

/// Applies the radial term to the equidistant point `uv`, then tangential and prism terms to the result.
fn prism_fisheye(uv: DVec2, k: [f64; 6], [p0, p1]: [f64; 2], s: [f64; 4]) -> DVec2 {
    let bent = uv * (1.0 + polynomial(&k, uv.length_squared()));
    let r2 = bent.length_squared();
    let prism = DVec2::new(s[0] + s[1] * r2, s[2] + s[3] * r2) * r2;
    bent + tangential(bent, [p1, p0]) + prism
}

/// Evaluates `c[0] t + c[1] t^2 + ..`.
fn polynomial(coefficients: &[f64], t: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| (sum + c) * t)
}

/// Returns the tangential shift at `xy`.
fn tangential(xy: DVec2, [p1, p2]: [f64; 2]) -> DVec2 {
    let DVec2 { x, y } = xy;
    let r2 = xy.length_squared();
    DVec2::new(2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x), 2.0 * p2 * x * y + p1 * (r2 + 2.0 * y * y))
}

/// Maps (x/z, y/z) to the point in the same direction whose radius is the angle to the axis in radians.
fn equidistant(xy: DVec2) -> DVec2 {
    let r = xy.length();
    // Below 1e-8 the next term of atan(r)/r = 1 - r^2/3 is lost in rounding.
    if r < 1e-8 { xy } else { xy * (r.atan() / r) }
}

/// Returns `atan(2 r tan(omega/2)) / (r omega)`, or its limit where r or omega vanishes.
fn fov_factor(r: f64, omega: f64) -> f64 {
    if omega == 0.0 {
        return 1.0;
    }
    let slope = 2.0 * (omega / 2.0).tan();
    if r < 1e-8 { slope / omega } else { (r * slope).atan() / (r * omega) }
}

/// Returns t / r for the t with `t (1 + k t^2) = r`, by the trigonometric solution of the cubic; not a number where there is none.
fn reverse_factor(r: f64, k: f64) -> f64 {
    // The next term of 1 - k r^2 is lost in rounding.
    if k.abs() * r * r < 1e-9 {
        return 1.0 - k * r * r;
    }
    let root = (3.0 * k.abs()).sqrt();
    let third = 1.5 * r * root;
    let solved = if k > 0.0 { (third.asinh() / 3.0).sinh() } else { (third.asin() / 3.0).sin() };
    2.0 * solved / (root * r)
}

/// One lens of each kind with terms of realistic size, for tests.
#[cfg(test)]
pub(crate) const EVERY_KIND: [Lens; 9] = [
    Lens::None,
    Lens::Brown { k: [-0.2, 0.05, 0.01, 0.02, 0.01, 0.005], p: [0.001, -0.002] },
    Lens::Fov { omega: 0.9 },
    Lens::Fisheye { k: [0.02, -0.01, 0.003, -0.001], p: [0.001, 0.002], s: [0.003, -0.001] },
    Lens::PrismFisheye {
        k: [0.02, -0.01, 0.003, -0.001, 0.0002, 0.0001],
        p: [0.001, 0.002],
        s: [0.003, -0.001, 0.002, 0.001],
    },
    Lens::Division { k: -0.1 },
    Lens::Skewed { k: [-0.2, 0.05, 0.01, -0.002], p: [0.001, -0.002], skew: -0.005 },
    Lens::Reverse { k: 0.1 },
    Lens::Eucm { alpha: 0.6, beta: 1.1 },
];

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: DVec2, b: DVec2) {
        assert!((a - b).length() < 1e-12, "{a} is not {b}");
    }

    #[test]
    fn no_lens_moves_the_centre() {
        for lens in EVERY_KIND {
            close(lens.distort(DVec2::ZERO), DVec2::ZERO);
        }
    }

    #[test]
    fn radial_terms_stretch_by_the_polynomial() {
        let lens = Lens::Brown { k: [0.1, 0.01, 0.0, 0.0, 0.0, 0.0], p: [0.0; 2] };
        close(lens.distort(DVec2::new(1.0, 0.0)), DVec2::new(1.11, 0.0));
        close(lens.distort(DVec2::new(0.0, 2.0)), DVec2::new(0.0, 2.0 * (1.0 + 0.4 + 0.16)));
    }

    #[test]
    fn the_full_model_divides_by_its_second_polynomial() {
        let lens = Lens::Brown { k: [0.1, 0.2, 0.3, 0.4, 0.5, 0.6], p: [0.0; 2] };
        close(lens.distort(DVec2::new(1.0, 0.0)), DVec2::new(1.6 / 2.5, 0.0));
    }

    #[test]
    fn a_lens_is_displayed_with_its_coefficients_that_are_not_0() {
        let brown = Lens::Brown { k: [1e308, 0.0, 0.5, 0.0, 0.0, 0.0], p: [0.0, -0.1] };
        assert_eq!(brown.to_string(), "Brown, k1 1e308, k3 0.5, p2 -0.1");
        let fisheye = Lens::Fisheye { k: [0.0; 4], p: [0.0; 2], s: [0.0, 2.0] };
        assert_eq!(fisheye.to_string(), "fisheye, sy1 2.0");
        let prism = Lens::PrismFisheye { k: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0], p: [0.0; 2], s: [0.0; 4] };
        assert_eq!(prism.to_string(), "prism fisheye, k0 1.0");
        assert_eq!(Lens::Division { k: -0.25 }.to_string(), "division, k -0.25");
    }

    #[test]
    fn tangential_terms_follow_opencv() {
        let lens = Lens::Brown { k: [0.0; 6], p: [0.01, 0.02] };
        // x = 1, y = 2: r2 = 5.
        close(
            lens.distort(DVec2::new(1.0, 2.0)),
            DVec2::new(1.0 + 0.04 + 0.02 * 7.0, 2.0 + 0.08 + 0.01 * 13.0),
        );
    }

    #[test]
    fn a_plain_fisheye_has_the_angle_as_its_radius() {
        let lens = Lens::Fisheye { k: [0.0; 4], p: [0.0; 2], s: [0.0; 2] };
        let at_60_degrees = DVec2::new(60f64.to_radians().tan(), 0.0);
        close(lens.distort(at_60_degrees), DVec2::new(60f64.to_radians(), 0.0));
    }

    #[test]
    fn a_fisheye_polynomial_is_in_the_angle() {
        let lens = Lens::Fisheye { k: [0.1, 0.2, 0.3, 0.4], p: [0.0; 2], s: [0.5, 0.25] };
        let t = 0.5f64;
        let r = t * (1.0 + 0.1 * t.powi(2) + 0.2 * t.powi(4) + 0.3 * t.powi(6) + 0.4 * t.powi(8));
        close(lens.distort(DVec2::new(0.0, t.tan())), DVec2::new(0.5 * t * t, r + 0.25 * t * t));
    }

    #[test]
    fn the_prism_fisheye_shifts_the_radially_distorted_point() {
        let lens =
            Lens::PrismFisheye { k: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0], p: [0.1, 0.2], s: [0.3, 0.4, 0.5, 0.6] };
        let t = 0.5f64;
        let r = t * (1.0 + t * t);
        let expected = DVec2::new(
            r + 0.1 * 3.0 * r * r + 0.3 * r.powi(2) + 0.4 * r.powi(4),
            0.2 * r * r + 0.5 * r.powi(2) + 0.6 * r.powi(4),
        );
        close(lens.distort(DVec2::new(t.tan(), 0.0)), expected);
    }

    #[test]
    fn the_field_of_view_model_has_its_closed_form() {
        let lens = Lens::Fov { omega: 1.0 };
        let r = (2.0 * 0.5f64.tan() * 0.7).atan();
        close(lens.distort(DVec2::new(0.7, 0.0)), DVec2::new(r, 0.0));
    }

    #[test]
    fn the_division_model_inverts_its_division() {
        let lens = Lens::Division { k: -0.2 };
        let distorted = lens.distort(DVec2::new(0.6, -0.3));
        close(distorted / (1.0 - 0.2 * distorted.length_squared()), DVec2::new(0.6, -0.3));
    }

    #[test]
    fn a_skewed_lens_moves_x_by_the_distorted_y() {
        let lens = Lens::Skewed { k: [0.0, 0.0, 0.0, 0.5], p: [0.0; 2], skew: 0.25 };
        // At x = 0, y = 1 the factor is 1 + 0.5.
        close(lens.distort(DVec2::new(0.0, 1.0)), DVec2::new(0.375, 1.5));
    }

    #[test]
    fn the_reverse_model_acts_on_the_measurement() {
        for k in [0.3, -0.2, 1e-9, -1e-10] {
            for at in [DVec2::new(0.6, -0.3), DVec2::new(1e-7, 0.0)] {
                let measured = Lens::Reverse { k }.distort(at);
                close(measured * (1.0 + k * measured.length_squared()), at);
            }
        }
        assert!(Lens::Reverse { k: -1.0 }.distort(DVec2::new(0.5, 0.0)).x.is_nan(), "it folds at 0.385");
    }

    #[test]
    fn the_unified_model_on_the_unit_sphere_is_stereographic() {
        // alpha 1/2, beta 1: x = 2 sin / (1 + cos) = 2 tan(theta / 2).
        let lens = Lens::Eucm { alpha: 0.5, beta: 1.0 };
        close(lens.distort(DVec2::new(1f64.tan(), 0.0)), DVec2::new(2.0 * 0.5f64.tan(), 0.0));
    }

    #[test]
    fn the_jacobian_is_the_derivative() {
        // Along a radius of a radial lens: d/dr of r (1 + k r^2) = 1 + 3 k r^2, across it 1 + k r^2.
        let lens = Lens::Brown { k: [-0.1, 0.0, 0.0, 0.0, 0.0, 0.0], p: [0.0; 2] };
        let jacobian = lens.jacobian(DVec2::new(0.8, 0.0));
        assert!((jacobian.x_axis.x - (1.0 - 0.3 * 0.64)).abs() < 1e-9);
        assert!((jacobian.y_axis.y - (1.0 - 0.1 * 0.64)).abs() < 1e-9);
        for lens in EVERY_KIND {
            let (at, step) = (DVec2::new(0.4, -0.3), DVec2::new(3e-4, 2e-4));
            let moved = lens.distort(at + step) - lens.distort(at - step);
            assert!((lens.jacobian(at) * step * 2.0 - moved).length() < 1e-10, "{lens:?}");
        }
    }

    #[test]
    fn only_models_that_move_nothing_count_as_none() {
        assert!(Lens::Brown { k: [0.0; 6], p: [0.0; 2] }.is_none());
        assert!(Lens::Division { k: 0.0 }.is_none());
        assert!(!Lens::Fisheye { k: [0.0; 4], p: [0.0; 2], s: [0.0; 2] }.is_none());
        assert!(!Lens::Brown { k: [0.0; 6], p: [1e-9, 0.0] }.is_none());
    }
}
