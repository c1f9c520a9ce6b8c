//! Fragment lists as runs: neighbouring pixels of a row that hold the same items in the same states are one
//! run. A photo of six million pixels has a few hundred thousand runs, and all steps after the rasterisation
//! work on runs.

use rayon::prelude::*;

use super::rasteriser::{Band, FragmentLists, VISIBLE};

/// A run: pixels `x0..x1` of one row, all with the same entries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// The first column.
    pub x0: u32,
    /// One past the last column.
    pub x1: u32,
    first: u32,
    count: u32,
}

impl Run {
    /// Returns the number of pixels.
    #[inline]
    pub fn len(&self) -> u32 {
        self.x1 - self.x0
    }

    /// Returns true when the run holds no pixel, which never happens for runs of a [`RowRuns`].
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.x1 <= self.x0
    }
}

/// The runs of one row; pixels without fragments are in none.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RowRuns {
    /// The runs, from left to right.
    pub runs: Vec<Run>,
    entries: Vec<u32>,
}

impl RowRuns {
    /// Returns the entries of a run in rising order of items: item indices, with [`VISIBLE`] set where the
    /// item is visible.
    #[inline]
    pub fn entries(&self, run: &Run) -> &[u32] {
        &self.entries[run.first as usize..(run.first + run.count) as usize]
    }
}

/// The fragments of a photo as runs.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Runs {
    /// The rows of pixels, from the top.
    pub rows: Vec<RowRuns>,
}

/// Returns the item index of an entry, without the flag [`VISIBLE`].
#[inline]
pub fn item_of(entry: u32) -> u32 {
    entry & !VISIBLE
}

/// Returns true where the entry's item is visible.
#[inline]
pub fn is_visible(entry: u32) -> bool {
    entry & VISIBLE != 0
}

impl Runs {
    /// Converts fragment lists to runs. The lists are consumed band by band, so that not all data is held
    /// twice.
    #[inline]
    pub fn new(lists: FragmentLists) -> Self {
        let width = lists.width as usize;
        let mut rows = Vec::new();
        for band in lists.bands {
            let height = (band.y1 - band.y0) as usize;
            rows.par_extend((0..height).into_par_iter().map(|y| RowRuns::from_band(&band, y * width, width)));
        }
        Self { rows }
    }

    /// Returns the number of fragments.
    #[inline]
    pub fn fragments(&self) -> u64 {
        let of_row = |row: &RowRuns| row.runs.iter().map(|r| u64::from(r.len() * r.count)).sum::<u64>();
        self.rows.iter().map(of_row).sum()
    }

    /// Iterates over all runs with their row and entries.
    #[inline]
    pub fn iter(&self) -> impl Iterator<Item = (u32, Run, &[u32])> {
        self.rows
            .iter()
            .enumerate()
            .flat_map(|(y, row)| row.runs.iter().map(move |run| (y as u32, *run, row.entries(run))))
    }
}

impl RowRuns {
    /// Builds the row of `width` pixels that begins at pixel `begin` of the band.
    fn from_band(band: &Band, begin: usize, width: usize) -> Self {
        let mut row = Self::default();
        let mut sorted: Vec<u32> = Vec::new();
        let offsets = &band.offsets[begin..=begin + width];
        let mut last: &[u32] = &[];
        for x in 0..width {
            let raw = &band.entries[offsets[x] as usize..offsets[x + 1] as usize];
            // Most pixels repeat their left neighbour's list exactly.
            if raw.is_empty() || (x > 0 && raw == last && row.extend_to(x)) {
                last = raw;
                continue;
            }
            last = raw;
            sorted.clear();
            sorted.extend_from_slice(raw);
            sorted.sort_unstable_by_key(|&e| item_of(e));
            row.push(x, &sorted);
        }
        row.runs.shrink_to_fit();
        row.entries.shrink_to_fit();
        row
    }

    /// Adds column `x` to the last run if that run ends there; returns whether it did.
    fn extend_to(&mut self, x: usize) -> bool {
        match self.runs.last_mut() {
            Some(run) if run.x1 as usize == x => {
                run.x1 += 1;
                true
            }
            _ => false,
        }
    }

    fn push(&mut self, x: usize, sorted: &[u32]) {
        if let Some(last) = self.runs.last().copied()
            && self.entries(&last) == sorted
            && self.extend_to(x)
        {
            return;
        }
        let first = self.entries.len() as u32;
        self.entries.extend_from_slice(sorted);
        self.runs.push(Run { x0: x as u32, x1: x as u32 + 1, first, count: sorted.len() as u32 });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_neighbours_become_one_run_whatever_the_order_in_their_lists() {
        let entries = vec![1, 2 | VISIBLE, 2 | VISIBLE, 1, 7, 7];
        let band = Band { y0: 0, y1: 1, offsets: vec![0, 2, 4, 4, 5, 6], entries };
        let runs = Runs::new(FragmentLists { width: 5, bands: vec![band] });
        let found: Vec<_> = runs.iter().map(|(y, r, e)| (y, r.x0, r.x1, e.to_vec())).collect();
        assert_eq!(found, [(0, 0, 2, vec![1, 2 | VISIBLE]), (0, 3, 5, vec![7])]);
    }
}
