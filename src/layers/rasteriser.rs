//! What the method needs of a rasteriser. `gpu` implements it; `software` is its plain twin.

use super::view::View;
use crate::error::Result;
use crate::task::Task;

/// True where a fragment lies behind another by more than the tolerance, both given as inverse
/// depth. In f32 and in this form, so that every rasteriser decides alike.
#[inline]
pub fn is_behind(inverse_depth: f32, inverse_depth_of_other: f32, tolerance: f32) -> bool {
    inverse_depth * (1.0 + tolerance) < inverse_depth_of_other
}

/// `front` is nearer than `back` by more than the tolerance at `px` pixels that both cover.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Occlusion {
    /// Index of the nearer item in [`View::items`].
    pub front: u32,
    /// Index of the farther item.
    pub back: u32,
    /// Support: number of pixels.
    pub px: u32,
}

/// The tolerance within which fragments are nearest together, relative. Rounding of depths in f32
/// and of models written with four decimals (0.05 mm at 25 m) stays below; the strip along which
/// two faces that meet are within it is far narrower than a pixel.
pub const TIE: f32 = 2e-6;

/// The bit of a list entry that says: no item is nearer here by more than the tolerance.
pub const VISIBLE: u32 = 1 << 31;

/// The fragments of some rows of the photo.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Band {
    /// First row.
    pub y0: u32,
    /// One past the last row.
    pub y1: u32,
    /// Where each pixel's entries begin, row by row from `y0`; one more than there are pixels.
    pub offsets: Vec<u32>,
    /// Item index, with [`VISIBLE`] where it is visible. The order within a pixel means nothing.
    pub entries: Vec<u32>,
}

/// Per pixel, the fragments of the working set.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FragmentLists {
    /// Width of the photo in pixels.
    pub width: u32,
    /// Whole rows, from the top, without gaps.
    pub bands: Vec<Band>,
}

impl FragmentLists {
    /// The entries of the pixel in column `x`, row `y` of `band`.
    pub fn pixel<'a>(&self, band: &'a Band, x: u32, y: u32) -> &'a [u32] {
        let i = ((y - band.y0) * self.width + x) as usize;
        &band.entries[band.offsets[i] as usize..band.offsets[i + 1] as usize]
    }

    /// The owner of a pixel: of the items visible there the last in model order.
    pub fn owner(&self, x: u32, y: u32) -> Option<u32> {
        let band = self.bands.iter().find(|band| (band.y0..band.y1).contains(&y))?;
        let visible = self.pixel(band, x, y).iter().filter(|&&entry| entry & VISIBLE != 0);
        visible.max().map(|entry| entry & !VISIBLE)
    }

    /// Number of fragments.
    pub fn len(&self) -> u64 {
        self.bands.iter().map(|b| b.entries.len() as u64).sum()
    }

    /// No fragment at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// What became of an item of the view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Presence {
    /// In the working set: nearest (within [`TIE`]) at one pixel at least.
    Working,
    /// Covers pixels, nearest nowhere; at the first of them (in row order), `x`, `y`, the
    /// owner is `by`.
    Hidden { x: u32, y: u32, by: u32 },
    /// Covers no pixel centre.
    Nowhere,
}

/// The result of [`Rasteriser::fragments`].
#[derive(Debug, Clone, PartialEq)]
pub struct Fragments {
    /// One per item of the view.
    pub presence: Vec<Presence>,
    /// The lists of the working set.
    pub lists: FragmentLists,
    /// Every pair of the working set, sorted by (front, back), px > 0.
    pub occlusions: Vec<Occlusion>,
}

/// The result of [`Rasteriser::stencil_peeling`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StencilLayers {
    /// The layer of each item that took part; `None` for the others.
    pub layer: Vec<Option<u32>>,
    /// Rounds of drawing the geometry.
    pub passes: u32,
    /// Items that were left when a round emptied the set, put into one last layer.
    pub locked: u32,
}

/// Draws views. Depths are compared through [`super::InverseDepth::at`] and [`is_behind`] only.
pub trait Rasteriser: Sync {
    /// The working set, its fragment lists, and the table of all pairs.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] when the device fails, [`crate::Error::Cancelled`] on request.
    fn fragments(&self, view: &View, tolerance: f32, task: &Task) -> Result<Fragments>;

    /// Exact peeling of the items flagged in `alive`: one round. Returns, per item, whether some
    /// fragment of it lies behind a fragment of another alive item by more than the tolerance.
    /// `forgiven` pairs (front, back), sorted, are left out.
    ///
    /// # Errors
    /// As [`Rasteriser::fragments`].
    fn occluded(
        &self,
        view: &View,
        tolerance: f32,
        alive: &[bool],
        forgiven: &[(u32, u32)],
    ) -> Result<Vec<bool>>;

    /// Stencil peeling as published, of the items flagged in `working`.
    ///
    /// # Errors
    /// As [`Rasteriser::fragments`].
    fn stencil_peeling(
        &self,
        view: &View,
        tolerance: f32,
        working: &[bool],
        task: &Task,
    ) -> Result<StencilLayers>;
}
