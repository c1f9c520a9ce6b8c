//! Sums over the square around each cell of a grid, which blur it.

use std::ops::Range;

/// Returns the columns or rows, of so many, that are within `reach` of one of them.
#[inline]
pub fn box_range(at: usize, count: usize, reach: usize) -> Range<usize> {
    at.saturating_sub(reach)..(at + reach + 1).min(count)
}

/// Returns the sums of pairs of values, row by row, over the cells within `reach` columns and rows of each one; cells
/// beyond the border count nothing. `size` is the number of columns and rows.
pub fn box_sums(cells: &[(f32, f32)], [width, height]: [usize; 2], reach: usize) -> Vec<(f32, f32)> {
    let sum = |index: usize| {
        let columns = box_range(index % width, width, reach);
        let rows = box_range(index / width, height, reach);
        let places = rows.flat_map(|row| columns.clone().map(move |column| row * width + column));
        places.fold((0.0, 0.0), |sum, place| (sum.0 + cells[place].0, sum.1 + cells[place].1))
    };
    (0..cells.len()).map(sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_count_the_cells_within_reach_and_none_beyond_the_border() {
        let sums = box_sums(&[(1.0, 2.0); 12], [4, 3], 1);
        let of_row: Vec<f32> = sums[..4].iter().map(|sum| sum.0).collect();
        assert_eq!(of_row, [4.0, 6.0, 6.0, 4.0]);
        assert_eq!((sums[5], box_range(3, 4, 2)), ((9.0, 18.0), 1..4));
    }
}
