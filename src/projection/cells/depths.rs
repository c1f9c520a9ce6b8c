//! The depths at which a view shows a face in a cell. A cell at the horizon of a street holds hundreds of metres of ground, which
//! every photo of a town may serve somewhere; the few metres of them that no house hides are served by a few.

use std::collections::BTreeMap;

use glam::DVec3;

use super::{Cells, FaceCells, Finder, ServerCandidate, TexelBounds};

/// The number of ranges of depths per octave: photos are told apart well by bounds over a fifth of the distance.
const PER_OCTAVE: f64 = 4.0;

/// Cells with fewer candidates are not narrowed: they would save less than it costs.
const FEW: usize = 8;

/// A set of ranges of depths: bit `i` is that between `farthest * 2^(-(i + 1) / 4)` and `farthest * 2^(-i / 4)`. The first one reaches
/// to infinity, and the last one to the viewpoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ShownDepths(u64);

impl ShownDepths {
    /// All depths.
    pub const ALL: Self = Self(u64::MAX);

    /// Returns the depths between two inverse depths, in 1 / world unit; a negative one is beyond infinity.
    pub fn between_inverse([low, high]: [f64; 2], farthest: f64) -> Self {
        let place = |inverse: f64| {
            let octaves = (inverse.max(0.0) * farthest).log2();
            (PER_OCTAVE * octaves).floor().clamp(0.0, 63.0) as u32
        };
        let (first, last) = (place(low), place(high));
        Self((u64::MAX >> (63 - last)) & (u64::MAX << first))
    }

    /// Adds the depths of another set.
    pub fn add(&mut self, other: Self) {
        self.0 |= other.0;
    }

    /// Returns whether no depth is in the set.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Returns the ranges of depths.
    fn ranges(self, farthest: f64) -> impl Iterator<Item = [f64; 2]> {
        let depth = move |place: u32| farthest * (-f64::from(place) / PER_OCTAVE).exp2();
        (0..64).filter(move |place| self.0 >> place & 1 == 1).map(move |place| {
            let near = if place == 63 { 0.0 } else { depth(place + 1) };
            [near, if place == 0 { f64::INFINITY } else { depth(place) }]
        })
    }
}

impl<C: TexelBounds> Finder<'_, C> {
    /// Returns those candidates of a face in the cell with this column and row of the view that may have weight at the shown depths.
    pub fn at_depths(
        &self,
        cells: &Cells,
        face: &FaceCells,
        [column, row]: [u32; 2],
        shown: ShownDepths,
    ) -> Vec<ServerCandidate> {
        let listed = cells.of(face, column, row);
        if listed.len() < FEW || shown == ShownDepths::ALL || shown.is_empty() {
            return if shown.is_empty() { Vec::new() } else { listed.to_vec() };
        }
        let subject = self.subject(face.face, face.corner);
        let [x, y] = [column - face.corner[0], row - face.corner[1]];
        let polygon = self.clipped_to_cells(&subject, &self.outline(face.face), [x, y, x + 1, y + 1]);
        let servers: Vec<u32> = listed.iter().map(|candidate| candidate.server).collect();
        let mut found = BTreeMap::<u32, ServerCandidate>::new();
        for range in shown.ranges(cells.depths[1]) {
            let patch = self.patch(&subject, between(&polygon, range));
            for candidate in patch.iter().flat_map(|patch| self.candidates(&subject, patch, &servers)) {
                let all = found.entry(candidate.server).or_insert(candidate);
                all.least = all.least.min(candidate.least);
                all.rect = all.rect.union(&candidate.rect);
                all.finest = all.finest.min(candidate.finest);
            }
        }
        found.into_values().collect()
    }
}

/// Clips a polygon of the view's camera frame to a range of depths.
fn between(polygon: &[DVec3], [near, far]: [f64; 2]) -> Vec<DVec3> {
    let beyond = clipped(polygon, |p| p.z - near);
    if far.is_finite() { clipped(&beyond, |p| far - p.z) } else { beyond }
}

/// Clips a polygon to where an affine function is not negative.
fn clipped(polygon: &[DVec3], side: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 2);
    for (i, &p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (of_p, of_q) = (side(p), side(q));
        if of_p >= 0.0 {
            kept.push(p);
        }
        if (of_p < 0.0) != (of_q < 0.0) {
            kept.push(p.lerp(q, of_p / (of_p - of_q)));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_are_in_the_ranges_that_stand_for_them() {
        let farthest = 80.0;
        let set = |near: f64, far: f64| ShownDepths::between_inverse([1.0 / far, 1.0 / near], farthest);
        for (near, far) in [(3.0, 3.1), (0.2, 70.0), (79.0, 500.0), (1e-9, 2e-9)] {
            let ranges: Vec<[f64; 2]> = set(near, far).ranges(farthest).collect();
            assert!(ranges.last().unwrap()[0] <= near && ranges[0][1] >= far, "{near} {far}: {ranges:?}");
            assert!(ranges.windows(2).all(|two| two[0][0] == two[1][1]), "no gap: {ranges:?}");
        }
        assert_eq!(set(3.0, 3.1).ranges(farthest).count(), 1);
        let beyond = ShownDepths::between_inverse([-1.0, 1.0 / 79.0], farthest);
        assert_eq!(beyond.ranges(farthest).map(|[_, far]| far).collect::<Vec<_>>(), [f64::INFINITY]);
        assert_eq!(ShownDepths::between_inverse([-1.0, f64::INFINITY], farthest), ShownDepths::ALL);
    }

    #[test]
    fn a_polygon_is_clipped_to_a_range_of_depths() {
        let ground = [(-1.0, 1.0), (1.0, 1.0), (1.0, 9.0), (-1.0, 9.0)].map(|(x, z)| DVec3::new(x, 1.0, z));
        let part = between(&ground, [2.0, 3.0]);
        assert!(part.len() == 4 && part.iter().all(|p| (2.0..=3.0).contains(&p.z)), "{part:?}");
        assert!(between(&ground, [9.5, f64::INFINITY]).is_empty());
    }
}
