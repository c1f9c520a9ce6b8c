//! Triangles in space: nearest point, ray intersection, and how deeply two intersect.

use glam::DVec3;

/// A triangle by its three corners.
pub type Triangle = [DVec3; 3];

/// Returns the normal scaled to twice the triangle's area.
#[inline]
pub fn area_vector([a, b, c]: &Triangle) -> DVec3 {
    (b - a).cross(c - a)
}

/// Returns the point of the triangle that is nearest to `p`, by the Voronoi region of corners, edges and inside
/// that `p` lies in (Ericson, Real-Time Collision Detection, 5.1.5).
pub fn nearest_point(p: DVec3, &[a, b, c]: &Triangle) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    a + ab * (vb / (va + vb + vc)) + ac * (vc / (va + vb + vc))
}

/// Returns the t > 0 at which the ray `origin + t direction` meets the triangle, from either side (Moller and
/// Trumbore 1997).
pub fn ray_hit(origin: DVec3, direction: DVec3, &[a, b, c]: &Triangle) -> Option<f64> {
    let (ab, ac) = (b - a, c - a);
    let across = direction.cross(ac);
    let determinant = ab.dot(across);
    if determinant == 0.0 {
        return None;
    }
    let from_a = origin - a;
    let u = from_a.dot(across) / determinant;
    // Most misses are found by this coordinate already.
    if !(0.0..=1.0).contains(&u) {
        return None;
    }
    let around = from_a.cross(ab);
    let v = direction.dot(around) / determinant;
    let t = ac.dot(around) / determinant;
    (v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
}

/// Returns how deeply two triangles intersect, in their unit: the least of how far each reaches through the other's
/// plane and of the length of their common line. It is 0 where they do not intersect or only touch.
pub fn crossing_depth(a: &Triangle, b: &Triangle) -> f64 {
    let (Some(normal_a), Some(normal_b)) = (area_vector(a).try_normalize(), area_vector(b).try_normalize())
    else {
        return 0.0;
    };
    let (Some((depth_a, cut_a)), Some((depth_b, cut_b))) = (cut(a, normal_b, b[0]), cut(b, normal_a, a[0]))
    else {
        return 0.0;
    };
    let Some(line) = normal_a.cross(normal_b).try_normalize() else { return 0.0 };
    let span = |cut: [DVec3; 2]| {
        let [s, e] = cut.map(|p| line.dot(p - a[0]));
        [s.min(e), s.max(e)]
    };
    let ([a_from, a_to], [b_from, b_to]) = (span(cut_a), span(cut_b));
    let common = a_to.min(b_to) - a_from.max(b_from);
    depth_a.min(depth_b).min(common).max(0.0)
}

/// Returns how far the triangle's shorter side reaches beyond a plane, and the segment in which it meets the plane;
/// `None` when it lies on one side.
fn cut(triangle: &Triangle, normal: DVec3, point: DVec3) -> Option<(f64, [DVec3; 2])> {
    let d = triangle.map(|p| normal.dot(p - point));
    let depth = d[0].max(d[1]).max(d[2]).min(-d[0].min(d[1]).min(d[2]));
    if depth <= 0.0 {
        return None;
    }
    // The corner that is alone on its side; a corner in the plane counts to the larger side.
    let alone = (0..3).find(|&i| {
        let others = [d[(i + 1) % 3], d[(i + 2) % 3]];
        (d[i] > 0.0 && others.iter().all(|&o| o <= 0.0)) || (d[i] < 0.0 && others.iter().all(|&o| o >= 0.0))
    })?;
    let toward = |k: usize| {
        let other = (alone + k) % 3;
        triangle[alone] + (triangle[other] - triangle[alone]) * (d[alone] / (d[alone] - d[other]))
    };
    Some((depth, [toward(1), toward(2)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: Triangle = [DVec3::ZERO, DVec3::new(4.0, 0.0, 0.0), DVec3::new(0.0, 4.0, 0.0)];

    #[test]
    fn the_nearest_point_is_a_corner_an_edge_or_the_foot() {
        for (p, nearest) in [
            ([1., 1., 5.], [1., 1., 0.]),
            ([-1., -2., 3.], [0., 0., 0.]),
            ([2., -7., 1.], [2., 0., 0.]),
            ([4., 4., 0.], [2., 2., 0.]),
            ([9., -1., 2.], [4., 0., 0.]),
            ([-3., 1., 0.], [0., 1., 0.]),
        ] {
            assert!((nearest_point(DVec3::from_array(p), &T) - DVec3::from_array(nearest)).length() < 1e-12);
        }
    }

    #[test]
    fn rays_hit_from_both_sides_and_not_backwards() {
        let above = DVec3::new(1.0, 1.0, 2.0);
        assert_eq!(ray_hit(above, DVec3::NEG_Z, &T), Some(2.0));
        assert_eq!(ray_hit(-above + DVec3::new(2.0, 2.0, 0.0), DVec3::Z * 2.0, &T), Some(1.0));
        assert_eq!(ray_hit(above, DVec3::Z, &T), None);
        assert_eq!(ray_hit(above, DVec3::X, &T), None);
        assert_eq!(ray_hit(DVec3::new(3.0, 3.0, 1.0), DVec3::NEG_Z, &T), None);
    }

    #[test]
    fn depth_of_crossing_is_zero_for_what_only_touches() {
        let upright = |x: f64, low: f64| {
            [DVec3::new(x, 1.0, low), DVec3::new(x, 2.0, low), DVec3::new(x, 1.5, low + 3.0)]
        };
        assert!((crossing_depth(&T, &upright(1.0, -0.25)) - 0.25).abs() < 1e-12);
        assert_eq!(crossing_depth(&T, &upright(1.0, 0.0)), 0.0, "stands on it");
        assert_eq!(crossing_depth(&T, &upright(3.5, -0.25)), 0.0, "passes beside it");
        assert_eq!(crossing_depth(&T, &T), 0.0, "lies in it");
    }
}
