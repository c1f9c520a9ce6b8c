//! A region and its surroundings in cells of a few pixels, in which a photo is compared with its filling and
//! smooth values are interpolated.

use glam::DVec2;

use super::push_pull::Grid;
use super::region::Region;
use crate::geometry::PixelRect;

/// Side of a cell in pixels: large enough that misregistration by a pixel or two has little effect.
pub const CELL_PX: i32 = 4;

/// The level of detail at which a pixel is as large as a cell.
pub const CELL_LEVEL: usize = 2;

/// The number of cells around the occluded part that are compared; farther ones show other things.
const REACH_CELLS: i32 = 6;

/// The cells of a region and around it.
pub struct Cells {
    corner: [i32; 2],
    size: [usize; 2],
    near: Vec<bool>,
}

impl Cells {
    /// Builds the cells of a region and its surroundings, within a photo.
    pub fn around(region: &Region, photo: PixelRect) -> Self {
        let reach = (REACH_CELLS * CELL_PX) as u32;
        let rect = region.rect().grown(reach).intersection(&photo);
        let corner = [rect.x, rect.y].map(|at| at.div_euclid(CELL_PX));
        let last = [rect.right() - 1, rect.bottom() - 1].map(|at| at.div_euclid(CELL_PX));
        let size = [0, 1].map(|i| (last[i] - corner[i] + 1) as usize);
        let mut holds = vec![false; size[0] * size[1]];
        for span in region.spans.iter().map(|s| s.span) {
            let row = (span.y as i32).div_euclid(CELL_PX) - corner[1];
            let [x0, x1] = [span.x0, span.x1 - 1].map(|x| (x as i32).div_euclid(CELL_PX) - corner[0]);
            let from = row as usize * size[0];
            holds[from + x0 as usize..=from + x1 as usize].fill(true);
        }
        Self { corner, size, near: grown(&holds, size, REACH_CELLS as usize) }
    }

    /// Returns a mask of the cells that hold one of these pixels of the photo, or are adjacent to one that
    /// does.
    pub fn touching(&self, pixels: impl Iterator<Item = (u32, u32)>) -> Vec<bool> {
        let mut holds = vec![false; self.near.len()];
        pixels.filter_map(|(x, y)| self.place(x, y)).for_each(|index| holds[index] = true);
        grown(&holds, self.size, 1)
    }

    /// Iterates over the cells near the occluded part: their index, and their centre in photo pixels.
    pub fn near(&self) -> impl Iterator<Item = (usize, DVec2)> {
        let near = self.near.iter().enumerate().filter(|(_, near)| **near);
        near.map(|(index, _)| {
            let [x, y] = [index % self.size[0], index / self.size[0]];
            let at = |corner: i32, cell: usize| {
                f64::from((corner + cell as i32) * CELL_PX) + f64::from(CELL_PX) / 2.0
            };
            (index, DVec2::new(at(self.corner[0], x), at(self.corner[1], y)))
        })
    }

    /// Returns the index of the cell that holds a pixel; `None` outside of the cells.
    pub fn place(&self, x: u32, y: u32) -> Option<usize> {
        let [column, row] = [0, 1].map(|i| [x, y][i] as i32 / CELL_PX - self.corner[i]);
        let inside =
            column >= 0 && row >= 0 && (column as usize) < self.size[0] && (row as usize) < self.size[1];
        inside.then(|| row as usize * self.size[0] + column as usize)
    }

    /// Interpolates values over all cells from the known ones: index, value and weight (1 at most). Returns
    /// `None` when none is known.
    pub fn spread(&self, known: impl IntoIterator<Item = (usize, [f32; 3], f32)>) -> Option<Field> {
        let mut grid = Grid::new(self.size);
        for (index, value, weight) in known {
            (grid.values[index], grid.weights[index]) = (value, weight);
        }
        Some(Field { corner: self.corner, size: self.size, values: grid.filled()? })
    }
}

/// Dilates a mask by `reach` cells to all sides.
fn grown(marks: &[bool], [width, height]: [usize; 2], reach: usize) -> Vec<bool> {
    let mut wide = vec![false; marks.len()];
    for (i, _) in marks.iter().enumerate().filter(|(_, mark)| **mark) {
        let (x, row) = (i % width, i / width * width);
        wide[row + x.saturating_sub(reach)..row + (x + reach + 1).min(width)].fill(true);
    }
    let mut grown = vec![false; marks.len()];
    for y in 0..height {
        for row in y.saturating_sub(reach)..(y + reach + 1).min(height) {
            for x in 0..width {
                grown[y * width + x] |= wide[row * width + x];
            }
        }
    }
    grown
}

/// A grid of smooth values over a region.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    corner: [i32; 2],
    size: [usize; 2],
    values: Vec<[f32; 3]>,
}

impl Field {
    /// Interpolates the value at a pixel between the cells' centres.
    pub fn at(&self, x: u32, y: u32) -> [f32; 3] {
        let along = |at: u32, corner: i32, count: usize| {
            let position = (at as f32 + 0.5) / CELL_PX as f32 - 0.5 - corner as f32;
            let position = position.clamp(0.0, (count - 1) as f32);
            let first = position as usize;
            (first, (first + 1).min(count - 1), position - first as f32)
        };
        let (x0, x1, sx) = along(x, self.corner[0], self.size[0]);
        let (y0, y1, sy) = along(y, self.corner[1], self.size[1]);
        let value = |x: usize, y: usize, c: usize| self.values[y * self.size[0] + x][c];
        [0, 1, 2].map(|c| {
            let above = value(x0, y0, c) * (1.0 - sx) + value(x1, y0, c) * sx;
            let below = value(x0, y1, c) * (1.0 - sx) + value(x1, y1, c) * sx;
            above * (1.0 - sy) + below * sy
        })
    }
}
