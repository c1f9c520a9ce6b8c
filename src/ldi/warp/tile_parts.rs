//! The parts of tiles in drawing order, with the part of the picture that each can reach.

use std::ops::Range;

use glam::DVec2;

use crate::layout::ResolutionLevel;
use crate::order::{Quadrant, quadrants, reversed as reversed_quadrants};
use crate::stretch::CLOSED;
use crate::tiles::{COLUMNS, ROWS, Tile, columns_of};
use crate::transfer::Transfer;

/// How much larger the reach of a tile is taken than computed, in pixels: more than positions in single precision err.
const MARGIN: f64 = 0.01;

/// The part of a tile that is in one quadrant.
#[derive(Debug, Clone)]
pub struct TilePart {
    /// The index of the tile in [`ResolutionLevel::tiles`].
    pub tile: usize,
    columns: Range<u32>,
    rows: Range<u32>,
    /// True when columns are walked to the right.
    pub right: bool,
    down: bool,
    /// True when the part has all columns of its tile.
    whole: bool,
    /// The rectangle of the picture in which its points are, in pixels: low u and v, high u and v.
    reach: [f32; 4],
    /// No point has a smaller omega; 0 where some are behind the picture's camera.
    pub least_omega: f32,
    /// No point has a larger spacing, in pixels; not known before the picture's splats are.
    pub largest_spacing: f32,
    /// No point that is drawn has a larger root of the sum of the squares of J, see [`crate::stretch`]; likewise.
    pub largest_stretch: f32,
    width: f32,
}

/// Returns the parts of all tiles that hold depth pixels before the picture's camera, in drawing order.
pub fn tile_parts_in_order(level: &ResolutionLevel, transfer: &Transfer, reversed: bool) -> Vec<TilePart> {
    let mut order = quadrants([level.camera.width, level.camera.height], transfer.epipole);
    if reversed {
        order = reversed_quadrants(&order);
    }
    let mut parts = Vec::new();
    for quadrant in order {
        add_tile_parts(level, transfer, &quadrant, &mut parts);
    }
    parts
}

/// Returns the indices of the tiles that meet a range, in the direction in which they are walked.
fn walked(range: &Range<u32>, side: u32, forward: bool) -> Vec<u32> {
    let tiles = range.start / side..range.end.div_ceil(side);
    if forward { tiles.collect() } else { tiles.rev().collect() }
}

fn add_tile_parts(
    level: &ResolutionLevel,
    transfer: &Transfer,
    quadrant: &Quadrant,
    parts: &mut Vec<TilePart>,
) {
    let across = columns_of(level.camera.width);
    for tile_row in walked(&quadrant.rows, ROWS, quadrant.down) {
        for tile_column in walked(&quadrant.columns, COLUMNS, quadrant.right) {
            let index = (tile_row * across + tile_column) as usize;
            let tile = &level.tiles[index];
            let Some((reach, least_omega)) = (!tile.is_empty()).then(|| reach_of(tile, transfer)).flatten()
            else {
                continue;
            };
            let columns = tile.x.max(quadrant.columns.start)..(tile.x + COLUMNS).min(quadrant.columns.end);
            let rows = tile.y.max(quadrant.rows.start)..(tile.y + ROWS).min(quadrant.rows.end);
            let whole = tile.x == columns.start && columns.end == (tile.x + COLUMNS).min(level.camera.width);
            let (right, down) = (quadrant.right, quadrant.down);
            let width = transfer.size[0] as f32;
            let tile = index;
            let (largest_spacing, largest_stretch) = (f32::INFINITY, f32::INFINITY);
            parts.push(TilePart {
                tile,
                columns,
                rows,
                right,
                down,
                whole,
                reach,
                least_omega,
                largest_spacing,
                largest_stretch,
                width,
            });
        }
    }
}

/// Returns the rectangle of the picture in which the points of a tile are, and the least omega; `None` when all are behind the
/// camera. The projective map of a box is convex, so its corners bound it as long as all are before the camera.
fn reach_of(tile: &Tile, transfer: &Transfer) -> Option<([f32; 4], f32)> {
    const EVERYWHERE: [f32; 4] = [f32::NEG_INFINITY, f32::NEG_INFINITY, f32::INFINITY, f32::INFINITY];
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    let (mut behind, mut least_omega) = (0, f64::INFINITY);
    let [xs, ys] = [[tile.x, tile.x + COLUMNS], [tile.y, tile.y + ROWS]];
    for (x, y) in xs.into_iter().flat_map(|x| ys.map(|y| (x, y))) {
        for depth in [tile.least, tile.largest] {
            match transfer.position(DVec2::new(f64::from(x), f64::from(y)), f64::from(depth)) {
                Some((position, omega)) => {
                    (low, high) = (low.min(position), high.max(position));
                    least_omega = least_omega.min(omega);
                }
                None => behind += 1,
            }
        }
    }
    match behind {
        0 => {
            let (low, high) = (low - MARGIN, high + MARGIN);
            Some(([low.x as f32, low.y as f32, high.x as f32, high.y as f32], least_omega as f32))
        }
        8 => None,
        _ => Some((EVERYWHERE, 0.0)),
    }
}

impl TilePart {
    /// Returns whether any of its depth pixels can be stretched.
    #[inline]
    pub fn can_be_stretched(&self) -> bool {
        self.largest_stretch > CLOSED
    }

    /// Returns whether it can draw on rows `low..high` of the picture with splats that reach so far.
    #[inline]
    pub fn meets(&self, (low, high): (f32, f32), reach: f32) -> bool {
        let [left, top, right, bottom] = self.reach;
        top < high && bottom > low && left < self.width + reach && right > -reach
    }

    /// Returns whether all of it is on rows `low..high` of the picture.
    #[inline]
    pub fn is_within(&self, (low, high): (f32, f32)) -> bool {
        self.reach[1] >= low && self.reach[3] <= high
    }

    /// Returns whether depth pixels of row `y` of the frame can be on rows `low..high` of the picture: as for the whole tile.
    pub fn row_meets(
        &self,
        level: &ResolutionLevel,
        transfer: &Transfer,
        y: u32,
        (low, high): (f32, f32),
    ) -> bool {
        let tile = &level.tiles[self.tile];
        let (mut least, mut largest) = (f64::INFINITY, f64::NEG_INFINITY);
        for x in [tile.x, tile.x + COLUMNS] {
            for depth in [tile.least, tile.largest] {
                let position = DVec2::new(f64::from(x), f64::from(y) + 0.5);
                let Some((position, _)) = transfer.position(position, f64::from(depth)) else { return true };
                (least, largest) = (least.min(position.y), largest.max(position.y));
            }
        }
        least - MARGIN < f64::from(high) && largest + MARGIN > f64::from(low)
    }

    /// Returns the row of the frame that is drawn after `before` others; `None` after the last one.
    #[inline]
    pub fn row_in_order(&self, before: u32) -> Option<u32> {
        let Range { start, end } = self.rows;
        let row = if self.down { start + before } else { (end - 1).wrapping_sub(before) };
        (before < end - start).then_some(row)
    }

    /// Returns the depth pixels of a row of the frame that are in the part.
    #[inline(always)]
    pub fn row(&self, level: &ResolutionLevel, y: u32) -> Range<usize> {
        let tile = &level.tiles[self.tile];
        let [from, to] = tile.rows[(y - tile.y) as usize];
        let (from, to) = (from as usize, to as usize);
        if self.whole {
            return from..to;
        }
        let columns = &level.columns[from..to];
        let before = |end: u32| from + columns.partition_point(|&column| u32::from(column) < end);
        before(self.columns.start)..before(self.columns.end)
    }

    /// Returns the rows of the frame that it is in.
    pub fn rows(&self) -> Range<u32> {
        self.rows.clone()
    }

    /// Returns the middle of the part in the frame, in pixels.
    pub fn centre(&self) -> DVec2 {
        let middle = |range: &Range<u32>| f64::midpoint(f64::from(range.start), f64::from(range.end));
        DVec2::new(middle(&self.columns), middle(&self.rows))
    }
}
