//! Smooth interpolation of scattered values over a grid by push and pull: averages are pulled up a pyramid
//! until they cover the grid, and pushed down to the cells without a known value (Gortler, Grzeszczuk,
//! Szeliski and Cohen, *The Lumigraph*, 1996, section 4.3.2; as a membrane: Farbman, Fattal and Lischinski,
//! *Convolution Pyramids*, 2011, section 4). The running time is proportional to the number of cells.

use rayon::prelude::*;

use quadratura_base::raster::halving::{OddSide, halved};

/// A grid of values, row by row, each with a weight: 0 unknown, 1 known.
#[derive(Debug, Clone, PartialEq)]
pub struct WeightedGrid {
    /// The number of columns and rows.
    pub size: [usize; 2],
    /// The values; those of weight 0 carry no meaning.
    pub values: Vec<[f32; 3]>,
    /// The weights, in 0..1.
    pub weights: Vec<f32>,
}

/// The number of smoothing steps on each level, which turn squares into a membrane.
const STEPS: usize = 2;

impl WeightedGrid {
    /// Builds a grid without known values.
    pub fn new(size: [usize; 2]) -> Self {
        let count = size[0] * size[1];
        Self { size, values: vec![[0.0; 3]; count], weights: vec![0.0; count] }
    }

    /// Computes a value for every cell, exact where the weight is 1; `None` where no value is known at all.
    pub fn filled(self) -> Option<Vec<[f32; 3]>> {
        let [width, height] = self.size;
        if self.weights.iter().all(|weight| *weight > 0.0) {
            return Some(self.values);
        }
        if width == 1 && height == 1 {
            return None;
        }
        let above = self.halved();
        let size = above.size;
        let above = above.filled()?;
        let mut values = self.pushed(&above, size);
        for _ in 0..STEPS {
            values = self.smoothed(&values);
        }
        Some(values)
    }

    /// Halves the grid: each cell is the weighted mean of two by two cells. Weights add up, to 1 at most; an
    /// odd side is rounded up.
    fn halved(&self) -> Self {
        let mean = |four: &[usize]| {
            let (mut sum, mut weight) = ([0.0; 3], 0.0);
            for &at in four {
                let (value, w) = (self.values[at], self.weights[at]);
                (0..3).for_each(|c| sum[c] += w * value[c]);
                weight += w;
            }
            if weight > 0.0 { (sum.map(|sum| sum / weight), weight.min(1.0)) } else { ([0.0; 3], 0.0) }
        };
        let (values, weights) = halved(self.size, OddSide::Alone, mean).into_iter().unzip();
        Self { size: OddSide::Alone.half_size(self.size), values, weights }
    }

    /// Interpolates the coarser level at cells that are not fully known.
    fn pushed(&self, above: &[[f32; 3]], size: [usize; 2]) -> Vec<[f32; 3]> {
        let width = self.size[0];
        let mut values = self.values.clone();
        values.par_chunks_mut(width).zip(self.weights.par_chunks(width)).enumerate().for_each(
            |(y, (values, weights))| {
                for (x, (value, weight)) in values.iter_mut().zip(weights).enumerate() {
                    if *weight < 1.0 {
                        let from = between(above, size, x, y);
                        *value = [0, 1, 2].map(|c| weight * value[c] + (1.0 - weight) * from[c]);
                    }
                }
            },
        );
        values
    }

    /// Does one smoothing step: unknown cells become the mean of their four neighbours.
    fn smoothed(&self, values: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let [width, height] = self.size;
        let mut smooth = values.to_vec();
        smooth.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            for (x, value) in row.iter_mut().enumerate() {
                let weight = self.weights[y * width + x];
                if weight >= 1.0 {
                    continue;
                }
                let left = values[y * width + x.saturating_sub(1)];
                let right = values[y * width + (x + 1).min(width - 1)];
                let above = values[y.saturating_sub(1) * width + x];
                let below = values[(y + 1).min(height - 1) * width + x];
                let own = self.values[y * width + x];
                *value = [0, 1, 2].map(|c| {
                    let mean = (left[c] + right[c] + above[c] + below[c]) / 4.0;
                    weight * own[c] + (1.0 - weight) * mean
                });
            }
        });
        smooth
    }
}

/// Interpolates the coarser level at a cell of the level below it.
fn between(above: &[[f32; 3]], [width, height]: [usize; 2], x: usize, y: usize) -> [f32; 3] {
    let near = |at: usize, count: usize| {
        let first = at / 2;
        let other = if at % 2 == 1 { (first + 1).min(count - 1) } else { first.saturating_sub(1) };
        (first, other)
    };
    let ((x0, x1), (y0, y1)) = (near(x, width), near(y, height));
    let value = |x: usize, y: usize| above[y * width + x];
    let (a, b, c, d) = (value(x0, y0), value(x1, y0), value(x0, y1), value(x1, y1));
    [0, 1, 2].map(|i| (9.0 * a[i] + 3.0 * b[i] + 3.0 * c[i] + d[i]) / 16.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values_stay_and_unknown_ones_lie_between() {
        let mut grid = WeightedGrid::new([37, 23]);
        for (i, value) in [(0, 1.0), (36, 3.0), (22 * 37 + 5, 2.0)] {
            (grid.values[i], grid.weights[i]) = ([value; 3], 1.0);
        }
        let known = grid.clone();
        let filled = grid.filled().unwrap();
        for (i, value) in filled.iter().enumerate() {
            assert!((1.0..=3.0).contains(&value[0]), "{value:?} at {i}");
            if known.weights[i] > 0.0 {
                assert_eq!(*value, known.values[i]);
            }
        }
        assert!(filled[2][0] < filled[34][0]);
    }

    #[test]
    fn of_nothing_nothing_is_made() {
        assert_eq!(WeightedGrid::new([5, 9]).filled(), None);
    }
}
