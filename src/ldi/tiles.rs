//! Tiles of a level, by which whole groups of depth pixels are left out of a picture.

use rayon::prelude::*;

use super::layout::ResolutionLevel;
use quadratura_base::geometry::Pinhole;

/// Columns of a tile. Their number decides the order of depth pixels that neither is before the other, so it is fixed. It
/// divides the columns of a run ([`super::transfer::RUN`]).
pub const COLUMNS: u32 = 64;
/// Rows of a tile.
pub const ROWS: u32 = 16;

/// A rectangle of a level's frame, with the depth pixels in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Tile {
    /// The first column; a multiple of [`COLUMNS`].
    pub x: u32,
    /// The first row; a multiple of [`ROWS`].
    pub y: u32,
    /// The least inverse depth; larger than `largest` where the tile holds no depth pixel.
    pub least: f32,
    /// The largest inverse depth.
    pub largest: f32,
    /// True when no layered depth pixel in it has more than one layer.
    pub single: bool,
    /// The numbers of the surfaces in it, in their order; see [`super::layout::DepthPixel::surface`].
    pub surfaces: Box<[u16]>,
    /// The first and one past the last depth pixel in each row of the tile; rows below the frame have none.
    pub rows: [[u32; 2]; ROWS as usize],
}

impl Tile {
    /// Makes the tiles of a level, row by row from the top left.
    pub fn all_of(level: &ResolutionLevel) -> Vec<Self> {
        let Pinhole { width, height, .. } = level.camera;
        let of_rows =
            |row: u32| (0..width).step_by(COLUMNS as usize).map(move |x| Self::of(level, x, row * ROWS));
        (0..height.div_ceil(ROWS)).into_par_iter().flat_map_iter(of_rows).collect()
    }

    fn of(level: &ResolutionLevel, x: u32, y: u32) -> Self {
        let (least, largest, rows) = (f32::INFINITY, f32::NEG_INFINITY, [[0; 2]; ROWS as usize]);
        let mut tile = Self { x, y, least, largest, single: true, surfaces: Box::default(), rows };
        let mut surfaces: Vec<u16> = Vec::new();
        for (row, at) in (y..level.camera.height.min(y + ROWS)).zip(&mut tile.rows) {
            let range = level.row_within(row, &(x..x + COLUMNS));
            *at = [range.start as u32, range.end as u32];
            tile.single &= level.columns[range.clone()].windows(2).all(|pair| pair[0] < pair[1]);
            for &depth in &level.inverse_depths[range.clone()] {
                tile.least = tile.least.min(depth);
                tile.largest = tile.largest.max(depth);
            }
            surfaces.extend(level.surfaces[range].chunk_by(|a, b| a == b).map(|alike| alike[0]));
        }
        surfaces.sort_unstable();
        surfaces.dedup();
        tile.surfaces = surfaces.into();
        tile
    }

    /// Returns the number of depth pixels in it.
    pub fn len(&self) -> u32 {
        self.rows.iter().map(|[from, to]| to - from).sum()
    }

    /// Returns true when it holds no depth pixel.
    pub fn is_empty(&self) -> bool {
        self.least > self.largest
    }
}

/// Returns the number of tiles in a row of tiles of a frame.
pub fn columns_of(width: u32) -> u32 {
    width.div_ceil(COLUMNS)
}
