//! The packing of small grids into one texture, in rows of falling height.

use std::cmp::Reverse;

/// The least width of the texture in cells, which any device supports.
const WIDTH: u32 = 2048;

/// A packing of grids, each with its key.
#[derive(Debug)]
pub struct Packing<K> {
    /// The size of the texture in cells.
    pub size: [u32; 2],
    /// The position of each grid's first cell.
    pub positions: Vec<(K, [u32; 2])>,
}

impl<K: Copy + Ord> Packing<K> {
    /// Packs grids of these sizes; `longest` is the longest side that the device's textures may have. Grids with longer
    /// sides are left out.
    pub fn new(grids: impl Iterator<Item = (K, [u32; 2])>, longest: u32) -> Self {
        let mut grids: Vec<(K, [u32; 2])> = grids.filter(|(_, [w, h])| *w.max(h) <= longest).collect();
        grids.sort_by_key(|(key, [_, height])| (Reverse(*height), *key));
        let cells: f64 = grids.iter().map(|(_, [w, h])| f64::from(*w) * f64::from(*h)).sum();
        // About square where it is large, so that neither side reaches the device's limit unnecessarily.
        let square = (cells.sqrt().ceil() as u32).clamp(WIDTH, longest.max(WIDTH));
        let width = grids.iter().map(|(_, [w, _])| *w).fold(square, u32::max);
        let (mut x, mut y, mut row_height) = (0, 0, 0);
        let mut positions = Vec::with_capacity(grids.len());
        for (key, [w, h]) in grids {
            if x + w > width {
                (x, y, row_height) = (0, y + row_height, 0);
            }
            positions.push((key, [x, y]));
            x += w;
            row_height = row_height.max(h);
        }
        Self { size: [width, (y + row_height).max(1)], positions }
    }
}
