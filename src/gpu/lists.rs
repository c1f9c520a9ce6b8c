//! Construction of the fragment lists: count, prefix sum, fill, and the pairs in them, one band at a time.

use std::ops::Range;

use super::drawing::Attachments;
use super::frame::{BoundRows, PhotoRows};
use super::pairs::{PairSlice, PairTable, pair_slices};
use super::rasteriser::GpuRasteriser;
use super::readback;
use super::run::DrawnItems;
use super::workspace::Workspace;
use quadratura_base::error::{Error, Result};
use quadratura_layers::rasteriser::Band;
use quadratura_layers::{FragmentLists, Occlusion, count_pairs};

/// A part of a band: rows whose entries fit into a buffer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BandPart {
    /// The rows.
    pub frame: PhotoRows,
    /// The number of their entries.
    pub entries: u64,
}

impl GpuRasteriser {
    /// Counts the fragments of a band and computes their offsets. The nearest depths are drawn first, unless
    /// `nearest_is_drawn`. Returns the parts of the band from the bottom, the order in which they have to be
    /// filled.
    pub(super) fn places(
        &self,
        run: &DrawnItems,
        space: &Workspace,
        rows: &Range<u32>,
        nearest_is_drawn: bool,
    ) -> Result<Vec<BandPart>> {
        let frame = PhotoRows::band(run.view, rows.clone());
        let shared = self.share(run, &frame);
        let bound = BoundRows { rows: &frame, group: &shared };
        self.submit(|encoder| {
            if !nearest_is_drawn {
                let canvas = Attachments { depth: &space.depth, items: None };
                self.nearest.record(encoder, canvas, bound, &run.triangles);
            }
            self.count.record(&self.gpu, encoder, space, bound, &run.triangles);
            self.scan.record(&self.gpu, encoder, space, bound);
        });
        let [total] = readback::read(&self.gpu, [(&space.places, frame.pixels()..frame.pixels() + 1)])?;
        if u64::from(total[0]) <= self.most_entries {
            return Ok(vec![BandPart { frame, entries: u64::from(total[0]) }]);
        }
        let [ends] = readback::read(&self.gpu, [(&space.places, 0..frame.pixels())])?;
        let mut parts = parts(&frame, &ends, self.most_entries)?;
        parts.reverse();
        Ok(parts)
    }

    /// Fills a part's entries, which remain in the workspace.
    pub(super) fn fill(&self, run: &DrawnItems, space: &mut Workspace, part: &BandPart) {
        space.reserve(&self.gpu, part.entries);
        let shared = self.share(run, &part.frame);
        self.submit(|encoder| {
            let bound = BoundRows { rows: &part.frame, group: &shared };
            self.fill_pass.record(&self.gpu, encoder, space, bound, &run.triangles);
        });
    }

    /// Returns the pairs in a filled part, whose lists these are, in no particular order; a pair may come more than once. `table_bits` grows
    /// where necessary. Rows on which the device would work for long without a pause are left to the processor.
    pub(super) fn pairs(
        &self,
        run: &DrawnItems,
        space: &Workspace,
        part: &BandPart,
        lists: &Band,
        table_bits: &mut u32,
    ) -> Result<Vec<Occlusion>> {
        let (here, there): (Vec<_>, Vec<_>) =
            pair_slices(run.view.width, lists).into_iter().partition(|slice| slice.on_processor);
        let frames: Vec<PhotoRows> =
            there.into_iter().map(|slice| PhotoRows { rows: slice.rows, ..part.frame.clone() }).collect();
        let on_processor = || {
            let of_rows = |slice: &PairSlice| lists.of_rows(run.view.width, slice.rows.clone());
            let bands = here.iter().map(of_rows).collect();
            count_pairs(run.view, &FragmentLists { width: run.view.width, bands }, run.tolerance)
        };
        if frames.is_empty() {
            return Ok(on_processor());
        }
        let mut found = None;
        loop {
            let table = PairTable::new(&self.gpu, *table_bits)?;
            for frame in &frames {
                let shared = self.share(run, frame);
                // Each is a submission of its own, between which the device serves others, such as the screen.
                self.submit(|encoder| {
                    let bound = BoundRows { rows: frame, group: &shared };
                    self.pairs_pass.record(&self.gpu, encoder, space, bound, &table);
                });
            }
            // The processor counts while the device does.
            let mut all = found.take().unwrap_or_else(on_processor);
            if let Some(pairs) = table.read(&self.gpu, &run.items)? {
                all.extend(pairs);
                return Ok(all);
            }
            found = Some(all);
            *table_bits += 1;
        }
    }

    /// Reads back the lists of a filled part.
    pub(super) fn read_lists(&self, space: &Workspace, part: &BandPart) -> Result<Band> {
        let BandPart { frame, entries } = part;
        let pixel = |row: u32| u64::from(row - frame.band.start) * u64::from(frame.size[0]);
        let pixel_range = pixel(frame.rows.start)..pixel(frame.rows.end) + 1;
        let wanted = [(&space.places, pixel_range), (&space.entries, 0..*entries)];
        let [mut offsets, entries] = readback::read(&self.gpu, wanted)?;
        if frame.first_entry > 0 {
            offsets.iter_mut().for_each(|offset| *offset -= frame.first_entry);
        }
        Ok(Band { y0: frame.rows.start, y1: frame.rows.end, offsets, entries })
    }
}

/// Divides a band into parts of at most `most` entries, from the top. `ends` holds the offsets at which the
/// entries of each pixel end.
fn parts(band: &PhotoRows, ends: &[u32], most: u64) -> Result<Vec<BandPart>> {
    let width = band.size[0] as usize;
    let row_ends: Vec<u32> = ends.iter().skip(width - 1).step_by(width).copied().collect();
    let mut parts = Vec::new();
    let mut first_row = 0;
    let mut first_entry = 0;
    while first_row < row_ends.len() {
        let fits = |&end: &u32| u64::from(end - first_entry) <= most;
        let end_row = first_row + row_ends[first_row..].partition_point(fits);
        if end_row == first_row {
            return Err(Error::Gpu(format!(
                "the faces over row {} of the photo have more fragments than the adapter's buffers \
                 hold ({most}); simplify the model, or make the photo smaller",
                band.rows.start + first_row as u32
            )));
        }
        let row = |index: usize| band.rows.start + index as u32;
        let end_entry = row_ends[end_row - 1];
        parts.push(BandPart {
            frame: PhotoRows { rows: row(first_row)..row(end_row), first_entry, ..band.clone() },
            entries: u64::from(end_entry - first_entry),
        });
        (first_row, first_entry) = (end_row, end_entry);
    }
    Ok(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BAND: PhotoRows = PhotoRows { size: [2, 9], band: 4..8, rows: 4..8, first_entry: 0 };

    #[test]
    fn parts_are_whole_rows_that_hold_all_entries() {
        // The rows have 3, 1, 0 and 4 entries.
        let cut = parts(&BAND, &[1, 3, 3, 4, 4, 4, 6, 8], 4).expect("every row fits");
        let summary: Vec<_> =
            cut.iter().map(|part| (part.frame.rows.clone(), part.frame.first_entry, part.entries)).collect();
        assert_eq!(summary, [(4..7, 0, 4), (7..8, 4, 4)]);
    }

    #[test]
    fn a_row_that_does_not_fit_is_named() {
        let message = parts(&BAND, &[0, 0, 9, 9, 9, 9, 9, 9], 4).expect_err("9 are more than 4").to_string();
        assert!(message.contains("row 5"), "{message}");
    }
}
