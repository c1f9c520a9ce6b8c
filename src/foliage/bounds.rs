//! Boxes and balls around sub-objects.

use glam::{DAffine3, DMat3, DVec3};

use super::plant::{SubObject, Use};
use super::primitive::Primitive;

/// An axis-aligned box. The box around nothing has `low` above `high`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundingBox {
    /// The smallest coordinates.
    pub low: DVec3,
    /// The largest coordinates.
    pub high: DVec3,
}

/// A ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// The middle.
    pub middle: DVec3,
    /// The radius; 0 around nothing.
    pub radius: f64,
}

/// A box and a ball that both hold a sub-object with everything that it uses, in its own frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// The box.
    pub space: BoundingBox,
    /// The ball, whose middle is that of the box.
    pub ball: Ball,
}

/// Rounding of the few operations between a stored corner and a drawn one, relative to its size.
const SLACK: f64 = 1e-12;

impl BoundingBox {
    const NOTHING: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    /// Returns true where the box holds no point.
    pub fn is_empty(&self) -> bool {
        self.low.x > self.high.x
    }

    fn add(&mut self, middle: DVec3, radius: f64) {
        self.low = self.low.min(middle - radius);
        self.high = self.high.max(middle + radius);
    }

    fn include(&mut self, other: &Self) {
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
    }

    fn corners(&self) -> [DVec3; 8] {
        let choose = |bit: usize, low: f64, high: f64| if bit == 0 { low } else { high };
        std::array::from_fn(|i| {
            let (low, high) = (self.low, self.high);
            DVec3::new(
                choose(i & 1, low.x, high.x),
                choose(i & 2, low.y, high.y),
                choose(i & 4, low.z, high.z),
            )
        })
    }
}

impl Ball {
    /// Returns a ball that holds this one after an affine map.
    pub fn mapped(&self, map: &DAffine3) -> Self {
        let radius = largest_stretch(&map.matrix3) * self.radius;
        Self { middle: map.transform_point3(self.middle), radius }
    }
}

impl Bounds {
    /// Finds the bounds of primitives and of uses of `objects`, whose bounds are known.
    pub(super) fn of(primitives: &[Primitive], uses: &[Use], objects: &[SubObject]) -> Self {
        let mut space = BoundingBox::NOTHING;
        for primitive in primitives {
            primitive.shape.each_ball(|middle, radius| space.add(middle, radius));
        }
        let children = || {
            let parts = uses.iter().map(|of| (&of.parent_from_child, &objects[of.child].bounds));
            parts.filter(|(_, bounds)| !bounds.space.is_empty())
        };
        for (map, bounds) in children() {
            space.include(&bounds.mapped_space(map));
        }
        if space.is_empty() {
            return Self { space, ball: Ball { middle: DVec3::ZERO, radius: 0.0 } };
        }
        let middle = 0.5 * (space.low + space.high);
        let mut radius = 0.0f64;
        for primitive in primitives {
            primitive.shape.each_ball(|at, more| radius = radius.max(middle.distance(at) + more));
        }
        for (map, bounds) in children() {
            radius = radius.max(bounds.reach(map, middle));
        }
        // Both the balls of the parts and the box hold everything: the smaller one serves.
        radius = radius.min(middle.distance(space.high)) + SLACK * (middle.length() + radius);
        Self { space, ball: Ball { middle, radius } }
    }
}

impl Bounds {
    /// Returns a box that holds both the box and the ball after an affine map: where a map turns, the ball is tighter.
    fn mapped_space(&self, map: &DAffine3) -> BoundingBox {
        let mut space = BoundingBox::NOTHING;
        self.space.corners().iter().for_each(|&corner| space.add(map.transform_point3(corner), 0.0));
        let rows = map.matrix3.transpose();
        // A map takes a ball to an ellipsoid, which reaches as far along an axis as the row is long.
        let reach = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
        let middle = map.transform_point3(self.ball.middle);
        let reach = self.ball.radius * reach;
        BoundingBox { low: space.low.max(middle - reach), high: space.high.min(middle + reach) }
    }

    /// Returns a distance from a point that nothing of this exceeds after an affine map.
    fn reach(&self, map: &DAffine3, from: DVec3) -> f64 {
        let ball = self.ball.mapped(map);
        let corners = self.space.corners().map(|corner| map.transform_point3(corner).distance(from));
        let of_box = corners.into_iter().fold(0.0, f64::max);
        of_box.min(ball.middle.distance(from) + ball.radius)
    }
}

/// Returns the factor by which a linear map stretches at most: its largest singular value, the root of the largest
/// eigenvalue of `map^T map`, in closed form (Smith, *Eigenvalues of a symmetric 3 x 3 matrix*, 1961).
pub fn largest_stretch(map: &DMat3) -> f64 {
    // A common factor keeps squares of large and small numbers within range.
    let scale = map.to_cols_array().iter().fold(0.0f64, |most, value| most.max(value.abs()));
    if scale == 0.0 {
        return 0.0;
    }
    let map = *map * scale.recip();
    let square = map.transpose() * map;
    let mean = (square.x_axis.x + square.y_axis.y + square.z_axis.z) / 3.0;
    let rest = square - DMat3::from_diagonal(DVec3::splat(mean));
    let spread = (rest.to_cols_array().iter().map(|value| value * value).sum::<f64>() / 6.0).sqrt();
    if spread <= f64::EPSILON * mean {
        return scale * mean.sqrt();
    }
    let half = (0.5 * (rest * spread.recip()).determinant()).clamp(-1.0, 1.0);
    scale * (mean + 2.0 * spread * (half.acos() / 3.0).cos()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    #[test]
    fn no_direction_is_stretched_more_than_the_largest_stretch_and_one_nearly_as_much() {
        let mut rng = Rng::new(4);
        for case in 0..200 {
            let scale = 10f64.powi(case % 13 - 6);
            let map = DMat3::from_cols_array(&std::array::from_fn(|_| scale * rng.between(-1.0, 1.0)));
            let most = largest_stretch(&map);
            let mut seen = 0.0f64;
            let mut direction = DVec3::new(rng.unit() + 0.1, rng.unit(), rng.unit()).normalize();
            for _ in 0..2000 {
                seen = seen.max((map * direction).length());
                // Power iteration towards the direction that is stretched most.
                direction = (map.transpose() * (map * direction)).normalize();
            }
            // The closed form loses half of the digits where two singular values are nearly equal.
            assert!(
                seen <= most * (1.0 + 1e-7) && seen >= most * (1.0 - 1e-4),
                "case {case}: {seen}, {most}"
            );
        }
    }

    #[test]
    fn a_rotation_stretches_nothing_and_zero_everything_to_nothing() {
        let turn = DMat3::from_rotation_x(0.3) * DMat3::from_rotation_z(1.2);
        assert!((largest_stretch(&turn) - 1.0).abs() < 1e-7);
        assert_eq!(largest_stretch(&DMat3::ZERO), 0.0);
        assert_eq!(largest_stretch(&DMat3::from_diagonal(DVec3::new(-3.0, 1.0, 0.5))), 3.0);
    }
}
