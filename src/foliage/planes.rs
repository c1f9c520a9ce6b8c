//! Planes of depth through an instance, on which texels are drawn (Max, Deussen & Keating 1999).

use super::images::{MSample, depth_from_stored};
use super::place::{ImagePlacement, Instance};

/// Planes across the direction of an image, in steps of stored depths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DepthPlanes {
    /// The depth of the nearest one.
    first: f32,
    spacing: f32,
    count: i32,
}

/// The least and the most planes.
const COUNTS: [f64; 2] = [6.0, 128.0];

/// How many spacings more than half of one a texel of bark is drawn in front of its depth and behind it. On a smooth surface the texels of
/// the axis that sees it best are spread by 3 at most, and (3 - 1) / 2 closes the gaps. Leaves would become larger by that.
const OVERLAP: f64 = 1.0;

impl DepthPlanes {
    /// Makes the planes that displace what they show by about `error_px` pixels at most.
    pub fn new(instance: &Instance, place: &ImagePlacement, direction: usize, error_px: f64) -> Self {
        let space = instance.bounds.space;
        let away = instance.directions.view_from_object(direction).row(2);
        let extent = away.abs().dot(space.high - space.low);
        // One step away from the image's viewer in the view, at the middle of the ball.
        let step = place.linear.z_axis;
        let middle = place.origin;
        let px = place.image(middle);
        let sideways = place.change(middle, px, step).length();
        // Pixels for a unit there, without foreshortening.
        let scale =
            if place.perspective { place.focal.max_element() / middle.z } else { place.focal.max_element() };
        let straight = (step.length_squared() * scale * scale - sideways * sideways).max(0.0).sqrt();
        let tangent = f64::from(sideways / straight);
        let extent_px = extent * f64::from(step.length() * scale);
        let count = count(extent_px, tangent, error_px);
        let [unit, offset] = depth_from_stored(instance.bounds.ball.radius);
        let spacing = extent / count;
        let first = -0.5 * extent + 0.5 * spacing;
        Self {
            first: ((first - offset) / unit) as f32,
            spacing: (spacing / unit).max(f64::from(f32::MIN_POSITIVE)) as f32,
            count: count as i32,
        }
    }

    /// Calls `each` with the depths of the planes that a sample is drawn on.
    #[inline]
    pub fn each_near(&self, sample: &MSample, mut each: impl FnMut(f32)) {
        let at = (f32::from(sample.depth) - self.first) / self.spacing;
        let reach = if sample.normal.is_leaf() { 0.5 } else { 0.5 + OVERLAP as f32 };
        // The depths of surfaces at the very ends are rounded, too.
        let at = at.clamp(-0.5, self.count as f32 - 0.5);
        let first = ((at - reach).ceil() as i32).max(0);
        let last = ((at + reach).floor() as i32).min(self.count - 1);
        (first..=last).for_each(|plane| each(self.first + plane as f32 * self.spacing));
    }
}

/// Returns how many planes an extent of `extent_px` pixels needs: what is off by up to (1/2 + o) spacings in depth is off by that times the
/// tangent of the angle between direction and view in the picture.
fn count(extent_px: f64, tangent: f64, error_px: f64) -> f64 {
    let wanted = (extent_px * (0.5 + OVERLAP) * tangent / error_px).ceil();
    // What is no number asks for most.
    if wanted <= COUNTS[1] { wanted.max(COUNTS[0]) } else { COUNTS[1] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NormalCode;

    #[test]
    fn planes_go_with_extent_angle_and_error_within_6_and_128() {
        assert_eq!(count(40.0, 1.0, 1.0), 60.0);
        assert_eq!(count(40.0, 0.5, 0.5), 60.0);
        assert_eq!(
            [count(40.0, 0.0, 1.0), count(1e3, 1.0, 1.0), count(0.0, f64::INFINITY, 1.0)],
            [6.0, 128.0, 128.0]
        );
    }

    #[test]
    fn a_leaf_is_on_the_nearest_plane_and_bark_on_three() {
        let planes = DepthPlanes { first: 100.0, spacing: 10.0, count: 8 };
        let on = |depth: u16, normal: u16| {
            let mut found = Vec::new();
            planes.each_near(&MSample { depth, normal: NormalCode(normal), ..MSample::default() }, |at| {
                found.push(at)
            });
            found
        };
        let leaf = 1 << 15;
        assert_eq!((on(124, leaf), on(126, leaf), on(172, leaf)), (vec![120.0], vec![130.0], vec![170.0]));
        assert_eq!((on(124, 0), on(101, 0)), (vec![110.0, 120.0, 130.0], vec![100.0, 110.0]));
        assert_eq!((on(90, leaf), on(190, leaf)), (vec![100.0], vec![170.0]));
    }
}
