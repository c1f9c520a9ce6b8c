//! Bounds of a photo's angle, position and border factor over a ball of points.

use std::ops::Range;

use glam::{DVec2, DVec3};

use quadratura_base::geometry::Pinhole;
use quadratura_view::weights::{BORDER_SHARE, angle_at, border_ramp};

/// Bounds the angle under which `a` and `b` appear from points of a ball. At a point with distances x and y
/// from them the angle changes by at most |a - b| / (x y) per unit of movement, because its level sets are
/// the circles through both (inscribed angles).
pub fn angles(middle: DVec3, radius: f64, a: DVec3, b: DVec3) -> Range<f64> {
    let (x, y) = (middle.distance(a) - radius, middle.distance(b) - radius);
    if x <= 0.0 || y <= 0.0 {
        return 0.0..std::f64::consts::PI;
    }
    let angle = angle_at(middle, a, b);
    let change = radius * a.distance(b) / (x * y);
    (angle - change).max(0.0)..(angle + change).min(std::f64::consts::PI)
}

/// Bounds the angle between the directions from a point of a ball to `a` and from the same point of another ball of this
/// size, which may be turned, to what appears at `b` from the ball's middle.
pub fn angles_apart(middle: DVec3, radius: f64, a: DVec3, b: DVec3) -> Range<f64> {
    let (x, y) = (middle.distance(a), middle.distance(b));
    if x <= radius || y <= radius {
        return 0.0..std::f64::consts::PI;
    }
    let angle = angle_at(middle, a, b);
    let change = (radius / x).asin() + (radius / y).asin();
    (angle - change).max(0.0)..(angle + change).min(std::f64::consts::PI)
}

/// Returns a box in photo pixels that contains the projection of a ball (camera frame); the whole plane where
/// the ball reaches behind the camera.
pub fn projected_ball(middle: DVec3, radius: f64, camera: &Pinhole) -> (DVec2, DVec2) {
    if middle.z <= radius {
        return (DVec2::NEG_INFINITY, DVec2::INFINITY);
    }
    // The bounds of x/z over the box around the ball; each is taken at the depth that makes it extreme.
    let depths = (middle.z - radius, middle.z + radius);
    let bounds = |m: f64, f: f64, c: f64| {
        let (low, high) = (m - radius, m + radius);
        let low = if low < 0.0 { low / depths.0 } else { low / depths.1 };
        let high = if high > 0.0 { high / depths.0 } else { high / depths.1 };
        (f * low + c, f * high + c)
    };
    let (x0, x1) = bounds(middle.x, camera.fx, camera.cx);
    let (y0, y1) = bounds(middle.y, camera.fy, camera.cy);
    (DVec2::new(x0, y0), DVec2::new(x1, y1))
}

/// Bounds [`quadratura_view::weights::border`] over a box in photo pixels.
pub fn borders(camera: &Pinhole, low: DVec2, high: DVec2) -> Range<f64> {
    let size = DVec2::new(f64::from(camera.width), f64::from(camera.height));
    let ramp = BORDER_SHARE * size.min_element();
    let least = low.min(size - high).min_element();
    let most = high.min(size - low).min_element();
    border_ramp(least / ramp)..border_ramp(most / ramp)
}
