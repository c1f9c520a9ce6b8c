//! A region and its surroundings in cells of a few pixels, in which a photo is compared with its filling and
//! smooth values are interpolated.

use glam::DVec2;

use super::push_pull::WeightedGrid;
use super::region::Region;
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::Image;
use quadratura_base::raster::bilinear::Clamped;

/// Side of a cell in pixels: large enough that misregistration by a pixel or two has little effect.
pub const CELL_PX: i32 = 4;

/// The level of detail at which a pixel is as large as a cell.
pub const CELL_LEVEL: usize = 2;

/// The number of cells around the occluded part that are compared; farther ones show other things.
const REACH_CELLS: i32 = 6;

/// The cells of a region and around it.
pub struct RegionCells {
    /// Which are near the hidden part.
    near: Image<bool>,
}

impl RegionCells {
    /// Builds the cells of a region and its surroundings, within a photo.
    pub fn around(region: &Region, photo: PixelRect) -> Self {
        let reach = (REACH_CELLS * CELL_PX) as u32;
        let rect = region.rect().grown(reach).intersection(&photo);
        let [left, top] = [rect.x, rect.y].map(|at| at.div_euclid(CELL_PX));
        let [right, bottom] = [rect.right() - 1, rect.bottom() - 1].map(|at| at.div_euclid(CELL_PX) + 1);
        let mut holds = Image::filled(PixelRect::from_edges(left, top, right, bottom), false);
        for span in region.spans.iter().map(|s| s.span) {
            let row = (span.y as i32).div_euclid(CELL_PX);
            let [from, to] =
                [span.x0, span.x1 - 1].map(|x| holds.rect().offset((x as i32).div_euclid(CELL_PX), row));
            holds.pixels_mut()[from..=to].fill(true);
        }
        Self { near: Image::new(holds.rect(), grown(holds.pixels(), holds.size(), REACH_CELLS as usize)) }
    }

    /// Returns a mask of the cells that hold one of these pixels of the photo, or are adjacent to one that
    /// does.
    pub fn touching(&self, pixels: impl Iterator<Item = (u32, u32)>) -> Vec<bool> {
        let mut holds = vec![false; self.near.pixels().len()];
        pixels.filter_map(|(x, y)| self.place(x, y)).for_each(|index| holds[index] = true);
        grown(&holds, self.near.size(), 1)
    }

    /// Iterates over the cells near the occluded part: their index, and their centre in photo pixels.
    pub fn near(&self) -> impl Iterator<Item = (usize, DVec2)> {
        let middle = |cell: i32| f64::from(cell * CELL_PX) + f64::from(CELL_PX) / 2.0;
        let near = self.near.iter().enumerate().filter(|(_, (_, near))| **near);
        near.map(move |(index, ((x, y), _))| (index, DVec2::new(middle(x), middle(y))))
    }

    /// Returns the index of the cell that holds a pixel; `None` outside of the cells.
    pub fn place(&self, x: u32, y: u32) -> Option<usize> {
        self.near.rect().index(x as i32 / CELL_PX, y as i32 / CELL_PX)
    }

    /// Interpolates values over all cells from the known ones: index, value and weight (1 at most). Returns
    /// `None` when none is known.
    pub fn propagated(&self, known: impl IntoIterator<Item = (usize, [f32; 3], f32)>) -> Option<SmoothField> {
        let mut grid = WeightedGrid::new(self.near.size());
        for (index, value, weight) in known {
            (grid.values[index], grid.weights[index]) = (value, weight);
        }
        Some(SmoothField { values: Image::new(self.near.rect(), grid.filled()?) })
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
pub struct SmoothField {
    /// By cell.
    values: Image<[f32; 3]>,
}

impl SmoothField {
    /// Interpolates the value at a pixel between the cells' centres.
    pub fn at(&self, x: u32, y: u32) -> [f32; 3] {
        let (rect, size) = (self.values.rect(), self.values.size());
        let cell = |at: u32, first: i32| (f64::from(at) + 0.5) / f64::from(CELL_PX) - f64::from(first);
        let between = Clamped::new(DVec2::new(cell(x, rect.x), cell(y, rect.y)), size);
        [0, 1, 2].map(|c| between.mix(|x, y| self.values.pixels()[y * size[0] + x][c]))
    }
}
