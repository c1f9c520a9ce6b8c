//! Least-squares planes of outlines, and the test whether an outline is planar.

use glam::DVec3;

use crate::geometry::Plane;

/// The planarity limit: no point of a planar outline is farther from its plane than this share of its extent.
///
/// Files written with few decimals move the corners of flat faces off their plane (the sample sites, four decimals
/// in metres: up to 6e-5 of the extent), which must not split walls into triangles. At this limit a face that fills
/// a photo of 3000 pixels is off by at most 3 pixels.
pub const PLANARITY: f64 = 1e-3;

/// Returns Newell's normal: the ring's area vector times two, in the points' unit squared. It is computed relative
/// to the first point, so that a site far from the origin loses no digits.
pub fn newell_normal(ring: &[DVec3]) -> DVec3 {
    let Some(&origin) = ring.first() else { return DVec3::ZERO };
    let mut normal = DVec3::ZERO;
    let mut previous = ring[ring.len() - 1] - origin;
    for &point in ring {
        let point = point - origin;
        normal += previous.cross(point);
        previous = point;
    }
    normal
}

/// Fits the plane through the mean of the points with Newell's normal; `None` for a ring without area (fewer than
/// three points, all on a line, or lobes that cancel out).
pub fn fit_plane(ring: &[DVec3]) -> Option<Plane> {
    let normal = newell_normal(ring);
    // A ring thinner than the rounding of its coordinates has a meaningless area.
    if ring.len() < 3 || normal.length() <= 2.0 * extent(ring) * resolution(ring) {
        return None;
    }
    let origin = ring[0];
    let mean = ring.iter().map(|&p| p - origin).sum::<DVec3>() / ring.len() as f64;
    Some(Plane { normal: normal.try_normalize()?, point: origin + mean })
}

/// Returns the diagonal of the bounding box, in the points' unit.
pub fn extent(ring: &[DVec3]) -> f64 {
    let Some(&first) = ring.first() else { return 0.0 };
    let (low, high) = ring.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p)));
    (high - low).length()
}

/// Returns the largest distance of the ring's points from the plane, in their unit.
pub fn largest_distance(ring: &[DVec3], plane: &Plane) -> f64 {
    ring.iter().map(|&p| plane.signed_distance(p).abs()).fold(0.0, f64::max)
}

/// Returns true when every point is within [`PLANARITY`] of the extent from the plane, or within the rounding error
/// of coordinates far from the origin.
pub fn is_planar(ring: &[DVec3], plane: &Plane) -> bool {
    largest_distance(ring, plane) <= (PLANARITY * extent(ring)).max(resolution(ring))
}

/// Returns the distance below which differences are rounding errors: 1e-12 of the extent, or a few units in the
/// last place of the largest coordinate.
pub(super) fn resolution(ring: &[DVec3]) -> f64 {
    let largest = ring.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    (1e-12 * extent(ring)).max(8.0 * f64::EPSILON * largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FAR: DVec3 = DVec3::new(5e6, -5e6, 120.0);

    #[test]
    fn a_square_has_the_plane_its_winding_says() {
        let square = [[0., 0., 2.], [3., 0., 2.], [3., 3., 2.], [0., 3., 2.]].map(DVec3::from_array);
        let plane = fit_plane(&square).unwrap();
        assert_eq!(plane.normal, DVec3::Z);
        assert_eq!(plane.point, DVec3::new(1.5, 1.5, 2.0));
        assert!(is_planar(&square, &plane));
    }

    #[test]
    fn five_million_metres_away_nothing_is_lost() {
        let square =
            [[0., 0., 2.], [3., 0., 2.], [3., 3., 2.], [0., 3., 2.]].map(|p| FAR + DVec3::from_array(p));
        let plane = fit_plane(&square).unwrap();
        assert_eq!(plane.normal, DVec3::Z);
        assert!(is_planar(&square, &plane));
    }

    #[test]
    fn points_on_a_line_have_no_plane() {
        let line = [FAR, FAR + DVec3::ONE, FAR + DVec3::ONE * 7.0];
        assert!(fit_plane(&line).is_none());
        assert!(fit_plane(&[FAR; 4]).is_none());
        assert!(fit_plane(&[]).is_none());
    }

    #[test]
    fn a_bent_quad_is_not_planar() {
        let quad = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.1], [0., 1., 0.]].map(DVec3::from_array);
        assert!(!is_planar(&quad, &fit_plane(&quad).unwrap()));
    }
}
