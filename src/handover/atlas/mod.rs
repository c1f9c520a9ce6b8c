//! A texture atlas for planar faces: each chart is faces in their own plane, without distortion, so nothing is unwrapped by an optimiser.
//!
//! | module | contents |
//! |---|---|
//! | [`chart`] | which faces share a chart, and the axes of its plane |
//! | [`density`] | texels per unit of each chart, from what photos show and what an atlas may hold |
//! | [`pack`] | the cells of charts on pages |
//! | [`pad`] | colours carried outwards from a chart to the border of its cell |
//!
//! Cells begin and end at multiples of [`CELL`] texels, and a chart keeps [`GUTTER`] texels from the border of its cell. So a texel of
//! mip level 4, [`CELL`] texels wide, lies in one cell, and bilinear lookups in that level, half a texel of it inside, do as well.

pub mod chart;
pub mod density;
pub mod pack;
pub mod pad;

/// The side of the grid of cells, in texels: of mip level 4.
pub const CELL: u32 = 16;

/// The least distance of a chart from the border of its cell, in texels.
pub const GUTTER: u32 = CELL / 2;

/// Returns the cells along one side of a chart, by its length in texels.
pub fn cells_of(texels: f64) -> u32 {
    ((texels.ceil() as u32).max(1) + 2 * GUTTER).div_ceil(CELL)
}
