//! Rectangles of a face's cells, which are examined as a whole before their cells.

use glam::DVec3;

/// A rectangle of a face's cells, examined block by block.
pub(super) struct CellBlock<'a> {
    /// The part of the face in the rectangle, in the view's camera frame.
    pub polygon: &'a [DVec3],
    /// The servers that may contribute in the rectangle.
    pub servers: &'a [u32],
    /// Columns and rows from (first two) and to (last two, exclusive), in the face's cells.
    pub cells: [u32; 4],
    /// Sides of the blocks within, in cells, from coarse to fine; empty for single cells.
    pub steps: &'a [u32],
}

impl CellBlock<'_> {
    /// Returns the blocks within, or the single cells, row by row.
    pub fn parts(&self) -> Vec<[u32; 4]> {
        let [x0, y0, x1, y1] = self.cells;
        let step = self.steps.first().copied().unwrap_or(1);
        let rows = (y0..y1).step_by(step as usize);
        let of_row = |y: u32| {
            let columns = (x0..x1).step_by(step as usize);
            columns.map(move |x| [x, y, (x + step).min(x1), (y + step).min(y1)])
        };
        rows.flat_map(of_row).collect()
    }
}
