//! Triangles that reach out of what can be projected are cut to it.

use glam::DVec3;

use super::view::HalfSpace;

/// A corner of what is left of a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClippedCorner {
    /// The position in the view's frame.
    pub position: DVec3,
    /// The weights of the triangle's corners that give the position; they sum to 1.
    pub weights: DVec3,
}

/// Returns the convex polygon that half spaces leave of a triangle, wound like it; empty where nothing is left
/// (Sutherland and Hodgman 1974).
pub fn clipped(triangle: [DVec3; 3], half_spaces: &[HalfSpace]) -> Vec<ClippedCorner> {
    let weights = [DVec3::X, DVec3::Y, DVec3::Z];
    let corner = |i: usize| ClippedCorner { position: triangle[i], weights: weights[i] };
    half_spaces.iter().fold((0..3).map(corner).collect(), |polygon, half_space| cut(&polygon, half_space))
}

fn cut(polygon: &[ClippedCorner], half_space: &HalfSpace) -> Vec<ClippedCorner> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, p) in polygon.iter().enumerate() {
        let q = &polygon[(i + 1) % polygon.len()];
        let (inside_p, inside_q) = (half_space.inside(p.position), half_space.inside(q.position));
        if inside_p >= 0.0 {
            kept.push(*p);
        }
        if (inside_p > 0.0 && inside_q < 0.0) || (inside_p < 0.0 && inside_q > 0.0) {
            let t = inside_p / (inside_p - inside_q);
            kept.push(ClippedCorner {
                position: p.position.lerp(q.position, t),
                weights: p.weights.lerp(q.weights, t),
            });
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_corner_that_is_cut_off_gives_a_quad_whose_weights_say_where_it_is() {
        let triangle = [DVec3::new(0.0, 0.0, -1.0), DVec3::new(4.0, 0.0, 3.0), DVec3::new(0.0, 4.0, 3.0)];
        let near = HalfSpace { normal: DVec3::Z, offset: 1.0 };
        let left = clipped(triangle, &[near]);
        assert_eq!(left.len(), 4);
        for corner in &left {
            let DVec3 { x, y, z } = corner.weights;
            let again = x * triangle[0] + y * triangle[1] + z * triangle[2];
            // Rounding of a few operations on numbers below 4.
            assert!(again.distance(corner.position) < 1e-12 && corner.position.z >= 1.0 - 1e-12);
        }
        assert!(clipped(triangle, &[HalfSpace { normal: DVec3::Z, offset: 3.5 }]).is_empty());
    }
}
