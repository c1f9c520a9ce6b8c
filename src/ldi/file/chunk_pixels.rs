//! The depth pixels of a chunk: cut out of a level, checked, and added to one.

use std::ops::Range;

use super::header::CHUNK_ROWS;
use crate::layout::LARGEST_INVERSE_DEPTH;
use crate::{ResolutionLevel, Splat};

/// The bytes of a depth pixel in each stream after the first.
const SIZES: [u64; 4] = [4, 4, 2, 1];

/// Returns the sizes of the streams of a chunk, unpacked, in bytes.
pub(super) fn stream_sizes(layered: u64, depth_pixels: u64) -> [u64; 5] {
    let [inverse_depths, colours, surfaces, splats] = SIZES.map(|size| size * depth_pixels);
    [layered, inverse_depths, colours, surfaces, splats]
}

/// Where the depth pixels of a chunk are.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Places {
    /// The first row in the level.
    pub first_row: u32,
    /// The depth pixels of each row, counted in the chunk.
    pub rows: Vec<Range<usize>>,
    /// The column of each depth pixel.
    pub columns: Vec<u16>,
}

/// The depth pixels of a chunk, in arrays as in [`ResolutionLevel`].
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct ChunkPixels {
    pub places: Places,
    pub inverse_depths: Vec<f32>,
    pub colours: Vec<[u8; 4]>,
    pub surfaces: Vec<u16>,
    pub splats: Vec<Splat>,
}

impl Places {
    /// Makes places of the numbers of depth pixels at each position, row by row.
    pub fn of_counts(first_row: u32, width: u32, counts: &[u8]) -> Self {
        let mut places = Self { first_row, ..Self::default() };
        for row in counts.chunks_exact(width as usize) {
            let start = places.columns.len();
            for (column, count) in (0u16..).zip(row) {
                places.columns.extend(std::iter::repeat_n(column, usize::from(*count)));
            }
            places.rows.push(start..places.columns.len());
        }
        places
    }

    /// Returns the number of depth pixels at each position, row by row.
    ///
    /// # Errors
    /// What was found, where a position has more than 255.
    pub fn counts(&self, width: u32) -> Result<Vec<u8>, String> {
        let mut counts = vec![0u8; self.rows.len() * width as usize];
        for ((y, row), counts) in
            (self.first_row..).zip(&self.rows).zip(counts.chunks_exact_mut(width as usize))
        {
            for &column in &self.columns[row.clone()] {
                let count = &mut counts[usize::from(column)];
                *count = count.checked_add(1).ok_or_else(|| {
                    format!(
                        "column {column}, row {y} has more depth pixels than 255, \
                         the largest number in a file"
                    )
                })?;
            }
        }
        Ok(counts)
    }
}

impl ChunkPixels {
    /// Returns chunk `index` of a level.
    pub fn of(level: &ResolutionLevel, index: usize) -> Self {
        let first_row = index as u32 * CHUNK_ROWS;
        let rows = first_row..(first_row + CHUNK_ROWS).min(level.camera.height);
        let all = level.row(rows.start).start..level.row(rows.end - 1).end;
        let in_chunk = |row: Range<usize>| row.start - all.start..row.end - all.start;
        let places = Places {
            first_row,
            rows: rows.map(|y| in_chunk(level.row(y))).collect(),
            columns: level.columns[all.clone()].to_vec(),
        };
        Self {
            places,
            inverse_depths: level.inverse_depths[all.clone()].to_vec(),
            colours: level.colours[all.clone()].to_vec(),
            surfaces: level.surfaces[all.clone()].to_vec(),
            splats: level.splats[all].to_vec(),
        }
    }

    /// Adds its rows to the end of a level.
    pub fn add_to(&self, level: &mut ResolutionLevel) {
        let start = level.len();
        level.rows.extend(self.places.rows.iter().map(|row| (start + row.end) as u32));
        level.columns.extend_from_slice(&self.places.columns);
        level.inverse_depths.extend_from_slice(&self.inverse_depths);
        level.colours.extend_from_slice(&self.colours);
        level.surfaces.extend_from_slice(&self.surfaces);
        level.splats.extend_from_slice(&self.splats);
    }

    /// Returns the largest and the least inverse depth; 0 without depth pixels.
    pub fn near_and_far(&self) -> (f32, f32) {
        let depths = self.inverse_depths.iter().copied();
        (depths.clone().reduce(f32::max).unwrap_or(0.0), depths.reduce(f32::min).unwrap_or(0.0))
    }

    /// Checks the content of the arrays. Depth pixels can name `surfaces` surfaces.
    ///
    /// # Errors
    /// What was found and where, and what was expected.
    pub fn check(&self, surfaces: usize) -> Result<(), String> {
        for (y, row) in (self.places.first_row..).zip(&self.places.rows) {
            for index in row.clone() {
                let place = || format!("column {}, row {y}", self.places.columns[index]);
                self.check_pixel(index, surfaces).map_err(|found| format!("{}: {found}", place()))?;
                let continues =
                    index > row.start && self.places.columns[index] == self.places.columns[index - 1];
                if continues && self.inverse_depths[index] > self.inverse_depths[index - 1] {
                    return Err(format!(
                        "{}: a depth pixel is behind a farther one; expected the nearest first",
                        place()
                    ));
                }
            }
        }
        Ok(())
    }

    fn check_pixel(&self, index: usize, surfaces: usize) -> Result<(), String> {
        let depth = self.inverse_depths[index];
        if !(0.0..=LARGEST_INVERSE_DEPTH).contains(&depth) {
            return Err(format!("the inverse depth {depth}; expected 0 to {LARGEST_INVERSE_DEPTH:e}"));
        }
        let surface = self.surfaces[index];
        if usize::from(surface) > surfaces {
            return Err(format!("surface {surface}; expected 0 to {surfaces}"));
        }
        Ok(())
    }
}
