//! The weights of photos at a surface point; the CPU reference of `shaders/weights.wgsl`.
//!
//! Every photo that shows the point gets a penalty q. The k photos of least penalty share the point, with
//! weights that reach zero where the (k+1)-th photo takes over, so that nothing pops (Buehler et al. 2001,
//! section 4). Confidence and border are part of q; no weight is multiplied by anything after the selection.

use glam::DVec3;

use super::shot::{Blend, Mode};
use quadratura_base::geometry::{Pinhole, Plane};

/// The angle added to every penalty, in radians; it keeps q above zero at the photo's own camera.
pub const LEAST_ANGLE: f64 = 1e-6;

/// The width of the ramp at a photo's border, as a share of the photo's shorter side; further inside the
/// photo counts fully.
pub const BORDER_SHARE: f64 = 0.05;

/// The penalty, in radians, added where a billboard is textured by a photo of its other side: any photo of
/// the right side comes first, because angles are at most pi.
pub const OTHER_SIDE: f64 = 1000.0;

/// The quantities that determine the penalty of one photo at a surface point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Claim {
    /// The angle between the rays to the viewpoint and to the photo's camera, in radians.
    pub angle: f64,
    /// The octaves of resolution that the photo lacks, 0 or more, see [`octaves_missing`].
    pub octaves: f64,
    /// The border factor, 0 at the photo's edge to 1 inside, see [`border`].
    pub border: f64,
    /// The confidence of the filtered texel, 0 to 1.
    pub confidence: f64,
    /// How far other photos confirm the texel, above 0 to 1 (`agreement`).
    pub agreement: f64,
}

impl Claim {
    /// Returns the trust in the photo at the point: border times confidence, 0 to 1.
    pub fn trust(&self) -> f64 {
        self.border * self.confidence
    }

    /// Computes the penalty; infinite where the photo cannot contribute. [`Mode::Debevec`] uses angles alone.
    pub fn penalty(&self, blend: &Blend) -> f64 {
        let trust = self.trust();
        if trust <= 0.0 {
            return f64::INFINITY;
        }
        let contradicted = blend.transient_angle() * (1.0 - self.agreement) + LEAST_ANGLE;
        match blend.mode {
            Mode::Debevec => self.angle / self.agreement + contradicted,
            Mode::Best | Mode::Lumigraph | Mode::Smooth => {
                ((self.angle + blend.lambda * self.octaves) / self.agreement + contradicted) / trust
            }
        }
    }
}

/// Computes the angle at `point` between the rays to `a` and `b`, in radians, as precisely for nearly equal
/// rays as for nearly opposite ones (Kahan's form: the chord over its complement).
pub fn angle_at(point: DVec3, a: DVec3, b: DVec3) -> f64 {
    let (a, b) = ((a - point).normalize(), (b - point).normalize());
    2.0 * (a - b).length().atan2((a + b).length())
}

/// Computes the pixels per world unit on a plane at a point: the geometric mean over directions, f sqrt(h /
/// z^3), with h the distance of the camera from the plane and z the depth of the point.
pub fn pixels_per_unit(camera: &Pinhole, plane: &Plane, center: DVec3, depth: f64) -> f64 {
    let height = plane.normal.dot(center - plane.point).abs();
    (camera.fx * camera.fy * height / (depth * depth * depth)).sqrt()
}

/// Computes the octaves of resolution that a photo lacks at a point, compared with the view; 0 when it has
/// enough. Both arguments as from [`pixels_per_unit`].
pub fn octaves_missing(in_view: f64, in_photo: f64) -> f64 {
    (in_view / in_photo).log2().max(0.0)
}

/// Computes the border factor, 0 at the photo's edge to 1 from [`BORDER_SHARE`] of its shorter side inwards;
/// `px` in photo pixels.
pub fn border(camera: &Pinhole, px: glam::DVec2) -> f64 {
    let (width, height) = (f64::from(camera.width), f64::from(camera.height));
    let inside = px.x.min(width - px.x).min(px.y).min(height - px.y);
    border_ramp(inside / (BORDER_SHARE * width.min(height)))
}

/// Computes the ramp from 0 at 0 to 1 at 1 and above: `1 - (1 - share)^8`. It ends with slope 0, and begins
/// so steeply that in a photo's own camera other photos contribute less than a hundredth even at the
/// outermost pixels.
pub fn border_ramp(share: f64) -> f64 {
    1.0 - (1.0 - share.clamp(0.0, 1.0)).powi(8)
}

/// Computes the weights of photos with these penalties: at most `blend.photos` are above zero, and they sum
/// to 1. All are 0 where no photo contributes.
pub fn weights(penalties: &[f64], blend: &Blend) -> Vec<f64> {
    let mut rising: Vec<usize> = (0..penalties.len()).filter(|&i| penalties[i].is_finite()).collect();
    // The sort is stable, so ties are resolved by position.
    rising.sort_by(|&a, &b| penalties[a].total_cmp(&penalties[b]));
    let most = if blend.mode == Mode::Best { 1 } else { blend.photos.max(1) as usize };
    let next = rising.get(most).map_or(f64::INFINITY, |&i| penalties[i]);
    rising.truncate(most);
    let mut weights = vec![0.0; penalties.len()];
    for &i in &rising {
        weights[i] = raw_weight(penalties[i], next, blend.mode);
    }
    let sum: f64 = weights.iter().sum();
    let ties = rising.len() as f64;
    for &i in &rising {
        weights[i] = if sum > 0.0 { weights[i] / sum } else { 1.0 / ties };
    }
    weights
}

/// Computes the shares of photos at a face that may be pinned to one of them. `trusts` holds the
/// [`Claim::trust`] of the pinned photo, and `None` for the others.
///
/// The pinned photo takes a share of the point equal to its trust there, and the others share the rest as if
/// it were absent; where no other photo contributes it takes everything. Trust does not depend on the
/// viewpoint, and it ends in ramps at the photo's border and at the outline of what the photo shows, so that
/// nothing pops and no seam appears. (If its penalty were merely put before all others', the transition would
/// be abrupt.) Several overlapping servers of the pinned photo divide its share by their trust.
pub fn shares(penalties: &[f64], trusts: &[Option<f64>], blend: &Blend) -> Vec<f64> {
    let pinned = |i: usize| trusts[i].is_some();
    let others = (0..penalties.len()).map(|i| if pinned(i) { f64::INFINITY } else { penalties[i] });
    let mut shares = weights(&others.collect::<Vec<_>>(), blend);
    let sum: f64 = trusts.iter().flatten().sum();
    if sum <= 0.0 {
        return shares;
    }
    let alone = shares.iter().all(|share| *share <= 0.0);
    let most = if alone { 1.0 } else { trusts.iter().flatten().fold(0.0, |a: f64, b| a.max(*b)) };
    for (share, trust) in shares.iter_mut().zip(trusts) {
        *share = *share * (1.0 - most) + most * trust.unwrap_or(0.0) / sum;
    }
    shares
}

fn raw_weight(q: f64, next: f64, mode: Mode) -> f64 {
    match mode {
        Mode::Best => 1.0,
        Mode::Debevec | Mode::Lumigraph => (1.0 - q / next).max(0.0) / q,
        // (T - q) / (T q) = 1/q - 1/T; the right-hand form also holds for an infinite T.
        Mode::Smooth => (1.0 / q - 1.0 / next).max(0.0).powi(2),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    const MODES: [Mode; 3] = [Mode::Debevec, Mode::Lumigraph, Mode::Smooth];

    fn blend(mode: Mode, photos: u32) -> Blend {
        Blend { mode, photos, ..Blend::default() }
    }

    #[test]
    fn weights_sum_to_one_and_at_most_k_are_above_zero() {
        let mut rng = Rng::new(11);
        for _ in 0..1000 {
            let penalties: Vec<f64> = (0..rng.whole(1, 20)).map(|_| rng.between(1e-6, 2.0)).collect();
            for mode in MODES {
                let weights = weights(&penalties, &blend(mode, 4));
                assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
                assert!(weights.iter().filter(|w| **w > 0.0).count() <= 4);
            }
        }
    }

    #[test]
    fn a_photo_that_joins_the_best_does_so_with_no_weight() {
        for mode in MODES {
            let before = weights(&[0.1, 0.2, 0.3, 0.3 + 1e-9], &blend(mode, 3));
            let after = weights(&[0.1, 0.2, 0.3 + 1e-9, 0.3], &blend(mode, 3));
            for (a, b) in before.iter().zip(&after) {
                assert!((a - b).abs() < 1e-6, "{mode}: {before:?} {after:?}");
            }
        }
    }

    #[test]
    fn photos_that_do_not_serve_have_no_weight_and_ties_share() {
        for mode in MODES {
            assert_eq!(weights(&[f64::INFINITY, 0.2], &blend(mode, 4)), [0.0, 1.0]);
            assert_eq!(weights(&[0.5; 5], &blend(mode, 4)), [0.25, 0.25, 0.25, 0.25, 0.0]);
            assert_eq!(weights(&[f64::INFINITY; 2], &blend(mode, 4)), [0.0, 0.0]);
        }
    }

    #[test]
    fn a_pinned_photo_takes_what_it_is_trusted_with_and_leaves_the_rest_as_it_was() {
        for mode in MODES {
            let blend = blend(mode, 2);
            let alone = weights(&[0.3, 0.1, 0.2], &blend);
            let with = |trust: f64| shares(&[0.3, 0.5, 0.1, 0.2], &[None, Some(trust), None, None], &blend);
            for trust in [0.0, 0.25, 1.0] {
                let left = 1.0 - trust;
                let expected = [alone[0] * left, trust, alone[1] * left, alone[2] * left];
                let found = with(trust);
                assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{mode}: {found:?}");
            }
        }
    }

    #[test]
    fn a_pinned_photo_that_serves_alone_is_all_there_is_and_two_of_its_layers_share() {
        let blend = blend(Mode::Lumigraph, 4);
        assert_eq!(shares(&[0.3, f64::INFINITY], &[Some(0.01), None], &blend), [1.0, 0.0]);
        assert_eq!(shares(&[0.3, 0.3, 0.1], &[Some(0.5), Some(0.5), None], &blend), [0.25, 0.25, 0.5]);
        assert_eq!(shares(&[0.3], &[None], &blend), [1.0]);
    }

    #[test]
    fn a_photos_own_camera_leaves_others_less_than_a_thousandth() {
        let own = Claim { angle: 0.0, octaves: 0.0, border: 1.0, confidence: 1.0, agreement: 1.0 };
        let other = Claim { angle: 0.02, octaves: 0.0, border: 1.0, confidence: 1.0, agreement: 1.0 };
        for mode in MODES {
            let penalties = [own.penalty(&blend(mode, 4)), other.penalty(&blend(mode, 4))];
            assert!(weights(&penalties, &blend(mode, 4))[0] > 0.999);
        }
    }

    #[test]
    fn angles_are_exact_from_nothing_to_a_half_turn() {
        for angle in [0.0, 1e-9, 1e-4, 0.5, 1.5, 3.0, std::f64::consts::PI] {
            let b = DVec3::new(7.0 * f64::cos(angle), 7.0 * f64::sin(angle), 0.0);
            assert!((angle_at(DVec3::ZERO, DVec3::X * 3.0, b) - angle).abs() < 1e-12);
        }
    }

    #[test]
    fn pixels_per_unit_is_the_area_of_the_projection() {
        let camera = Pinhole { width: 100, height: 100, fx: 200.0, fy: 300.0, cx: 50.0, cy: 50.0 };
        let plane = Plane { normal: DVec3::new(0.6, 0.0, -0.8), point: DVec3::new(0.0, 0.0, 5.0) };
        let point = plane.point;
        let (along, up) = (DVec3::new(0.8, 0.0, 0.6), DVec3::Y);
        let step = 1e-5;
        let at = |p: DVec3| camera.image_from_camera(p).expect("in front");
        let (du, dv) = (at(point + along * step) - at(point), at(point + up * step) - at(point));
        let area = du.perp_dot(dv).abs() / (step * step);
        let found = pixels_per_unit(&camera, &plane, DVec3::ZERO, point.z);
        assert!((found * found / area - 1.0).abs() < 1e-4);
    }
}
