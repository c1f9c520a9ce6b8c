//! Boxes and balls around sub-objects.

use glam::{DAffine3, DVec3};

use super::primitive::Primitive;
use super::stretch::largest_stretch;

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
    /// Finds the bounds of primitives and of parts, given the maps and the bounds of these.
    pub(super) fn of<'a>(
        primitives: &[Primitive],
        parts: impl Iterator<Item = (&'a DAffine3, &'a Self)> + Clone,
    ) -> Self {
        let mut space = BoundingBox::NOTHING;
        for primitive in primitives {
            primitive.shape.each_ball(|middle, radius| space.add(middle, radius));
        }
        let parts = parts.filter(|(_, bounds)| !bounds.space.is_empty());
        for (map, bounds) in parts.clone() {
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
        for (map, bounds) in parts {
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
