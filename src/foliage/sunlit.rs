//! The share of sunlight that reaches a tree past everything else in a site, such as buildings and other trees.

use glam::DVec3;
use rayon::prelude::*;

use super::bounds::BoundingBox;

/// The number of cells along x, y and z: shadows of buildings have soft edges in a crown, which leaves scatter.
pub const SUNLIT_CELLS: usize = 8;

/// The share of the sun's light that reaches the points of a grid around a plant, in the plant's frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Sunlit {
    space: BoundingBox,
    /// For each cell, x fastest, then y; 255 is all of it.
    shares: Vec<u8>,
}

impl Sunlit {
    /// Fills the grid of a space, of which `share` tells what reaches a point, 0 to 1; `None` where all of it reaches all points.
    pub fn new(space: BoundingBox, share: impl Fn(DVec3) -> f32 + Sync) -> Option<Self> {
        const CELLS: usize = SUNLIT_CELLS;
        let size = (space.high - space.low) / CELLS as f64;
        let of_cell = |cell: usize| {
            let place = [cell % CELLS, cell / CELLS % CELLS, cell / (CELLS * CELLS)];
            let middle = space.low + size * (DVec3::from_array(place.map(|place| place as f64)) + 0.5);
            (255.0 * share(middle).clamp(0.0, 1.0)).round() as u8
        };
        let shares: Vec<u8> = (0..CELLS * CELLS * CELLS).into_par_iter().map(of_cell).collect();
        shares.iter().any(|share| *share < u8::MAX).then_some(Self { space, shares })
    }

    /// Returns the share at a point, between the middles of cells; beyond the grid it goes on as at its border.
    pub fn at(&self, point: DVec3) -> f32 {
        const CELLS: usize = SUNLIT_CELLS;
        let within = (point - self.space.low) / (self.space.high - self.space.low) * CELLS as f64 - 0.5;
        let at = within.clamp(DVec3::ZERO, DVec3::splat((CELLS - 1) as f64));
        let first = at.floor();
        let share = (at - first).as_vec3();
        let low = first.to_array().map(|place| place as usize);
        let mut sum = 0.0;
        for corner in 0..8 {
            let high = [corner & 1, corner >> 1 & 1, corner >> 2];
            let [x, y, z] = [0, 1, 2].map(|axis| (low[axis] + high[axis]).min(CELLS - 1));
            let weight = |axis: usize| if high[axis] == 1 { share[axis] } else { 1.0 - share[axis] };
            let of_cell = f32::from(self.shares[(z * CELLS + y) * CELLS + x]) / 255.0;
            sum += of_cell * (weight(0) * weight(1) * weight(2));
        }
        sum
    }

    /// Returns the shares of the cells, x fastest, then y; 255 is all of it.
    pub fn shares(&self) -> &[u8] {
        &self.shares
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_lie_between_those_of_cells_and_a_plant_in_the_sun_has_no_grid() {
        let space = BoundingBox { low: DVec3::new(-4.0, 0.0, 0.0), high: DVec3::new(4.0, 8.0, 16.0) };
        assert_eq!(Sunlit::new(space, |_| 1.0), None);
        // The lower half is in the shade.
        let half = Sunlit::new(space, |point| if point.z > 8.0 { 1.0 } else { 0.0 }).unwrap();
        let at = |z: f64| half.at(DVec3::new(0.3, 7.9, z));
        // Cells are 2 high: the shadow's edge is soft from the middle of one to that of the next.
        for (z, expected) in [(-9.0, 0.0), (7.0, 0.0), (7.5, 0.25), (8.0, 0.5), (9.0, 1.0), (90.0, 1.0)] {
            assert!((at(z) - expected).abs() < 1e-6, "{} at {z}", at(z));
        }
        let along = Sunlit::new(space, |point| (point.x / 16.0 + 0.5) as f32).unwrap();
        let found = along.at(DVec3::new(1.0, 4.0, 4.0));
        // Shares are bytes.
        assert!((found - 0.5625).abs() <= 0.5 / 255.0, "{found}");
    }
}
