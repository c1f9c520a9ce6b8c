//! The interface that the method needs of a rasteriser. `gpu` implements it; `software` is its CPU reference.

use std::ops::Range;

use super::projected_model::ProjectedModel;
use quadratura_base::error::Result;
use quadratura_base::task::Task;

/// Returns true where a fragment lies behind another by more than the tolerance, both given as inverse depth.
/// The comparison is in f32 and in exactly this form, so that every rasteriser decides alike.
#[inline]
pub fn is_behind(inverse_depth: f32, inverse_depth_of_other: f32, tolerance: f32) -> bool {
    inverse_depth * (1.0 + tolerance) < inverse_depth_of_other
}

/// An occlusion: `front` is nearer than `back` by more than the tolerance at `px` pixels that both cover.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Occlusion {
    /// Index of the nearer item in [`ProjectedModel::items`].
    pub front: u32,
    /// Index of the farther item in [`ProjectedModel::items`].
    pub back: u32,
    /// Support: the number of pixels.
    pub px: u32,
}

/// The relative tolerance within which fragments count as equally near. Rounding of depths in f32 and of
/// models written with four decimals (0.05 mm at 25 m) stays below it; the strip along which two adjoining
/// faces are within it is far narrower than a pixel.
pub const TIE: f32 = 2e-6;

/// The bit of a list entry that marks the item as visible: no item at this pixel is nearer by more than the
/// tolerance.
pub const VISIBLE: u32 = 1 << 31;

/// The fragment lists of a band of rows of the photo.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Band {
    /// The first row.
    pub y0: u32,
    /// One past the last row.
    pub y1: u32,
    /// The index in `entries` of each pixel's first entry, row by row from `y0`; one more value than there
    /// are pixels.
    pub offsets: Vec<u32>,
    /// Item indices, with [`VISIBLE`] set where the item is visible. The order within a pixel carries no
    /// meaning.
    pub entries: Vec<u32>,
}

impl Band {
    /// Returns the lists of some of its rows, `width` pixels wide.
    #[must_use]
    pub fn of_rows(&self, width: u32, rows: Range<u32>) -> Self {
        let pixel = |row: u32| ((row - self.y0) * width) as usize;
        let offsets = &self.offsets[pixel(rows.start)..=pixel(rows.end)];
        let first = offsets[0];
        let entries = self.entries[first as usize..offsets[offsets.len() - 1] as usize].to_vec();
        let offsets = offsets.iter().map(|offset| offset - first).collect();
        Self { y0: rows.start, y1: rows.end, offsets, entries }
    }
}

/// The fragments of the working set, as one list per pixel.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FragmentLists {
    /// Width of the photo in pixels.
    pub width: u32,
    /// Bands of whole rows, from the top, without gaps.
    pub bands: Vec<Band>,
}

impl FragmentLists {
    /// Returns the entries of the pixel in column `x`, row `y` of `band`.
    #[inline]
    pub fn pixel<'a>(&self, band: &'a Band, x: u32, y: u32) -> &'a [u32] {
        let i = ((y - band.y0) * self.width + x) as usize;
        &band.entries[band.offsets[i] as usize..band.offsets[i + 1] as usize]
    }

    /// Returns the item that owns a pixel: the last one in model order among those visible there; `None`
    /// where no item is.
    #[inline]
    pub fn owner(&self, x: u32, y: u32) -> Option<u32> {
        let band = self.bands.iter().find(|band| (band.y0..band.y1).contains(&y))?;
        let visible = self.pixel(band, x, y).iter().filter(|&&entry| entry & VISIBLE != 0);
        visible.max().map(|entry| entry & !VISIBLE)
    }

    /// Returns the number of fragments.
    #[inline]
    pub fn len(&self) -> u64 {
        self.bands.iter().map(|b| b.entries.len() as u64).sum()
    }

    /// Returns true when there is no fragment at all.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The state of one item of the view after rasterisation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Presence {
    /// The item is in the working set: it is nearest (within [`TIE`]) at one pixel at least.
    Working,
    /// The item covers pixels but is nearest at none of them. The first of these pixels, in row order, is
    /// (`x`, `y`); its owner is the item `by`.
    Hidden {
        /// The pixel's column.
        x: u32,
        /// The pixel's row.
        y: u32,
        /// The index of the owner in [`ProjectedModel::items`].
        by: u32,
    },
    /// The item covers no pixel centre.
    Nowhere,
}

/// The result of [`Rasteriser::fragments`].
#[derive(Debug, Clone, PartialEq)]
pub struct Fragments {
    /// The state of each item of the view.
    pub presence: Vec<Presence>,
    /// The fragment lists of the working set.
    pub lists: FragmentLists,
    /// All pairs of the working set in which one item occludes the other, sorted by (front, back), px > 0.
    pub occlusions: Vec<Occlusion>,
}

/// The result of [`Rasteriser::stencil_peeling`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StencilLayers {
    /// The layer of each item that took part, 0 nearest; `None` for the others.
    pub layer: Vec<Option<u32>>,
    /// The number of rounds in which the geometry was drawn.
    pub passes: u32,
    /// The number of items left when a round emptied the set; they are put into one last layer.
    pub locked: u32,
}

/// A rasteriser of views. Implementations compare depths only through [`InverseDepth::at`](quadratura_base::geometry::InverseDepth::at) and
/// [`is_behind`].
pub trait Rasteriser: Sync {
    /// Finds the working set, its fragment lists, and the table of all occluding pairs.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`] when the device fails, [`quadratura_base::Error::Cancelled`] on request.
    fn fragments(&self, view: &ProjectedModel, tolerance: f32, task: &Task) -> Result<Fragments>;

    /// Does one round of exact peeling on the items flagged in `alive`. Returns, per item, whether some
    /// fragment of it lies behind a fragment of another alive item by more than the tolerance. The `forgiven`
    /// pairs (front, back), sorted, are ignored.
    ///
    /// # Errors
    /// As [`Rasteriser::fragments`].
    fn occluded(
        &self,
        view: &ProjectedModel,
        tolerance: f32,
        alive: &[bool],
        forgiven: &[(u32, u32)],
    ) -> Result<Vec<bool>>;

    /// Does stencil peeling as published, on the items flagged in `working`.
    ///
    /// # Errors
    /// As [`Rasteriser::fragments`].
    fn stencil_peeling(
        &self,
        view: &ProjectedModel,
        tolerance: f32,
        working: &[bool],
        task: &Task,
    ) -> Result<StencilLayers>;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_some_rows_are_those_of_the_whole() {
        // Rows 5 to 7, two pixels wide.
        let offsets = vec![0, 1, 3, 3, 6, 7, 7];
        let band = Band { y0: 5, y1: 8, offsets, entries: vec![10, 20, 21, 30, 31, 32, 40] };
        let middle = Band { y0: 6, y1: 7, offsets: vec![0, 0, 3], entries: vec![30, 31, 32] };
        assert_eq!(band.of_rows(2, 6..7), middle);
        let last = Band { y0: 6, y1: 8, offsets: vec![0, 0, 3, 4, 4], entries: vec![30, 31, 32, 40] };
        assert_eq!(band.of_rows(2, 6..8), last);
        assert_eq!(band.of_rows(2, 5..8), band);
    }
}
