//! Selection of one height per cell from the costs of all heights: semi-global matching (Hirschmüller,
//! *Stereo Processing by Semiglobal Matching and Mutual Information*, 2008, section 2.3), along rows and
//! columns.

use rayon::prelude::*;

use super::options::ReliefOptions;
use quadratura_base::raster::robust::upper_median;

/// The cost of every cell and hypothesis: `costs[(row * columns + column) * hypotheses + hypothesis]`.
pub struct Volume {
    /// The number of cells in a row.
    pub columns: usize,
    /// The number of heights tried at a cell.
    pub hypotheses: usize,
    /// The costs, row by row.
    pub costs: Vec<f32>,
}

impl Volume {
    /// Blurs the costs: means over 3 x 3 cells, because a single cell is unreliable.
    pub fn blurred(self) -> Self {
        let (across, row) = (self.hypotheses, self.columns * self.hypotheses);
        let costs = blurred(&blurred(&self.costs, across, row), row, self.costs.len());
        Self { costs, ..self }
    }

    /// Finds the hypothesis of least cost for each cell, including the costs of differing from its
    /// neighbours, refined to a fraction of a step.
    pub fn least(&self, options: &ReliefOptions) -> Vec<f32> {
        let mut sums = vec![0.0; self.costs.len()];
        self.along_rows(&mut sums, options);
        for reverse in [false, true] {
            self.along_columns(&mut sums, options, reverse);
        }
        sums.par_chunks(self.hypotheses).map(refined_minimum).collect()
    }

    fn along_rows(&self, sums: &mut [f32], options: &ReliefOptions) {
        let row = self.columns * self.hypotheses;
        sums.par_chunks_mut(row).zip(self.costs.par_chunks(row)).for_each(|(sums, costs)| {
            for reverse in [false, true] {
                let (mut path, mut next) = (vec![0.0; self.hypotheses], vec![0.0; self.hypotheses]);
                for k in 0..self.columns {
                    let cell = if reverse { self.columns - 1 - k } else { k } * self.hypotheses;
                    let cell = cell..cell + self.hypotheses;
                    advance(&path, &costs[cell.clone()], options, &mut next);
                    add(&mut sums[cell], &next);
                    std::mem::swap(&mut path, &mut next);
                }
            }
        });
    }

    /// Accumulates the costs of paths along all columns at once, row after row.
    fn along_columns(&self, sums: &mut [f32], options: &ReliefOptions, reverse: bool) {
        let row = self.columns * self.hypotheses;
        let (mut paths, mut next) = (vec![0.0; row], vec![0.0; row]);
        let rows = self.costs.len() / row;
        for k in 0..rows {
            let y = if reverse { rows - 1 - k } else { k };
            let (sums, costs) = (&mut sums[y * row..(y + 1) * row], &self.costs[y * row..(y + 1) * row]);
            let cells = paths.par_chunks(self.hypotheses).zip(costs.par_chunks(self.hypotheses));
            let cells = cells.zip(next.par_chunks_mut(self.hypotheses)).with_min_len(64);
            cells.for_each(|((path, costs), next)| advance(path, costs, options, next));
            add(sums, &next);
            std::mem::swap(&mut paths, &mut next);
        }
    }
}

/// Advances a path by one cell: the least cost to reach each hypothesis. The part common to all is
/// subtracted, so that sums remain small.
#[inline]
fn advance(path: &[f32], costs: &[f32], options: &ReliefOptions, next: &mut [f32]) {
    let least = path.iter().copied().fold(f32::INFINITY, f32::min);
    let jump = least + options.jump_cost;
    let last = path.len() - 1;
    for (h, next) in next.iter_mut().enumerate() {
        let neighbouring = path[h.saturating_sub(1)].min(path[(h + 1).min(last)]) + options.slope_cost;
        *next = costs[h] + path[h].min(neighbouring).min(jump) - least;
    }
}

fn add(sums: &mut [f32], path: &[f32]) {
    for (sum, cost) in sums.iter_mut().zip(path) {
        *sum += cost;
    }
}

/// Computes means of three neighbours `stride` apart, within consecutive lines of `line` values.
fn blurred(values: &[f32], stride: usize, line: usize) -> Vec<f32> {
    let mean = |(i, &value): (usize, &f32)| {
        let at = i % line;
        let before = if at >= stride { values[i - stride] } else { value };
        let after = if at + stride < line { values[i + stride] } else { value };
        (before + value + after) / 3.0
    };
    values.par_iter().enumerate().map(mean).collect()
}

/// Returns the hypothesis of least cost; of equal ones the nearest to the middle, which is the plane itself.
/// A parabola through it and its neighbours gives the fraction.
fn refined_minimum(costs: &[f32]) -> f32 {
    let middle = costs.len() / 2;
    let by_cost = |&a: &usize, &b: &usize| {
        costs[a].total_cmp(&costs[b]).then(a.abs_diff(middle).cmp(&b.abs_diff(middle)))
    };
    let least = (0..costs.len()).min_by(by_cost).unwrap_or(middle);
    if least == 0 || least + 1 == costs.len() {
        return least as f32;
    }
    let [before, at, after] = [costs[least - 1], costs[least], costs[least + 1]];
    let bend = before - 2.0 * at + after;
    let fraction = if bend > 1e-6 { 0.5 * (before - after) / bend } else { 0.0 };
    least as f32 + fraction.clamp(-0.5, 0.5)
}

/// Applies a median over 3 x 3 cells, which removes isolated outliers.
pub fn median_of_nine(heights: &[f32], columns: usize) -> Vec<f32> {
    let rows = heights.len() / columns;
    let median = |i: usize| {
        let (x, y) = (i % columns, i / columns);
        let [xs, ys] = [(x, columns), (y, rows)].map(|(k, of)| [k.saturating_sub(1), k, (k + 1).min(of - 1)]);
        let mut around = [0.0; 9];
        for (k, value) in around.iter_mut().enumerate() {
            *value = heights[ys[k / 3] * columns + xs[k % 3]];
        }
        upper_median(&mut around).expect("nine values have a median")
    };
    (0..heights.len()).into_par_iter().map(median).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Builds one row whose cells prefer these hypotheses of five; with `None` all are equal.
    fn row(wanted: &[Option<usize>]) -> Volume {
        let cell = |wanted: &Option<usize>| {
            (0..5).map(|h| wanted.map_or(0.3, |w| if w == h { 0.0 } else { 0.3 })).collect::<Vec<_>>()
        };
        Volume { columns: wanted.len(), hypotheses: 5, costs: wanted.iter().flat_map(cell).collect() }
    }

    fn heights(volume: &Volume) -> Vec<usize> {
        volume.least(&ReliefOptions::default()).into_iter().map(|h| h.round() as usize).collect()
    }

    #[test]
    fn cells_that_know_nothing_follow_their_neighbours() {
        assert_eq!(heights(&row(&[Some(4), None, None, Some(4)])), [4; 4]);
    }

    #[test]
    fn one_cell_does_not_stand_alone_but_several_do() {
        let [low, high] = [Some(0), Some(4)];
        assert_eq!(heights(&row(&[low, low, high, low, low])), [0; 5]);
        assert_eq!(heights(&row(&[[low; 5], [high; 5]].concat())), [[0; 5], [4; 5]].concat());
    }

    #[test]
    fn columns_are_followed_as_rows_are() {
        let along = row(&[Some(1), None, Some(3), Some(3)]);
        let down = Volume { columns: 1, costs: along.costs.clone(), hypotheses: 5 };
        assert_eq!(heights(&along), heights(&down));
    }

    #[test]
    fn a_parabola_is_found_between_its_samples() {
        let costs: Vec<f32> = (0..9).map(|h| (h as f32 - 5.3).powi(2)).collect();
        assert!((refined_minimum(&costs) - 5.3).abs() < 1e-5);
        assert_eq!(refined_minimum(&[1.0; 9]), 4.0);
    }

    #[test]
    fn the_median_takes_single_cells_away() {
        let mut heights = vec![1.0; 25];
        heights[12] = 9.0;
        heights[0] = 7.0;
        assert_eq!(median_of_nine(&heights, 5), [1.0; 25]);
    }
}
