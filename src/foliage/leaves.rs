//! How long the leaves of a sub-object are.

use glam::{DAffine3, DVec3};

use super::primitive::{Primitive, Shape};
use super::stretch::largest_stretch;

/// The lengths of the leaves of a sub-object with all that it uses, every instance counted: the length of a leaf is the diagonal of
/// its polygon's box.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Leaves {
    /// The sum of the lengths, in the sub-object's unit.
    sum: f64,
    /// Their number.
    count: f64,
}

impl Leaves {
    /// Measures the leaves of primitives and of parts, given the maps and the leaves of these.
    pub(super) fn of<'a>(
        primitives: &[Primitive],
        parts: impl Iterator<Item = (&'a DAffine3, &'a Self)>,
    ) -> Self {
        let mut of = Self::default();
        for primitive in primitives.iter().filter(|primitive| primitive.material.leaf) {
            each_length(&primitive.shape, |length| of.add(length, 1.0));
        }
        for (map, Self { sum, count }) in parts {
            of.add(sum * largest_stretch(&map.matrix3), *count);
        }
        of
    }

    fn add(&mut self, sum: f64, count: f64) {
        (self.sum, self.count) = (self.sum + sum, self.count + count);
    }

    /// Returns the mean length; `None` where there are none.
    pub fn mean(&self) -> Option<f64> {
        let Self { sum, count } = *self;
        (count > 0.0 && sum > 0.0 && sum.is_finite()).then(|| sum / count)
    }
}

/// Calls `visit` with the diagonal of each polygon's box.
fn each_length(shape: &Shape, mut visit: impl FnMut(f64)) {
    let diagonal = |corners: &mut dyn Iterator<Item = DVec3>| {
        let ends = corners
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        (ends.1 - ends.0).max(DVec3::ZERO).length()
    };
    match shape {
        Shape::Polygon(corners) => visit(diagonal(&mut corners.iter().map(|corner| corner.position))),
        Shape::Triangles(list) => list.triangles.iter().for_each(|triangle| {
            visit(diagonal(&mut triangle.iter().map(|corner| list.corners[*corner as usize].position)));
        }),
        Shape::Limb(_) => {}
    }
}
