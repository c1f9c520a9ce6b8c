//! What depth pixels are drawn with: one pixel, the published masks ([`over`]), or sums of weights ([`sums`]).

pub mod over;
pub mod pixel;
pub mod sums;

use super::layout::DepthPixelOrigin;
use super::stretch::Stretch;

/// A depth pixel at its position in the rows of the picture that are drawn on.
#[derive(Debug, Clone, Copy)]
pub struct Dot<'a> {
    /// The column in pixels.
    pub u: f32,
    /// The row in pixels, from the first of these rows.
    pub v: f32,
    /// Inverse depth in the picture's camera, in 1/world unit; not computed where the canvas does not ask for the spacing.
    pub q: f32,
    /// The spacing in pixels, negative where the depth pixel is stretched; not computed where the canvas does not ask for it.
    pub s: f32,
    /// How it is stretched, where the spacing is negative.
    pub stretch: &'a Stretch,
    /// The index of the depth pixel in its level.
    pub index: usize,
    /// Its index in the batch of depth pixels that was begun.
    pub at: usize,
    /// sRGB and opacity.
    pub colour: [u8; 4],
    /// The number of its surface, 0 where that is unknown; not looked up where the canvas does not ask for the spacing.
    pub surface: u32,
    /// How much the surface's inverse depth changes from pixel to pixel, see [`super::spacing::slope`]; likewise.
    pub slope: f32,
    /// Where the colour is from; not looked up where the canvas does not ask for it.
    pub origin: DepthPixelOrigin,
}

/// Where the depth pixels of a batch are: slices of equal length.
#[derive(Debug, Clone, Copy)]
pub struct BatchPositions<'a> {
    /// Columns of the picture, in pixels; NaN where a depth pixel is not to be seen.
    pub u: &'a [f32],
    /// Rows of the picture, in pixels; NaN likewise.
    pub v: &'a [f32],
    /// Spacings in pixels, negative where depth pixels are stretched; not computed where the canvas does not ask for them.
    pub s: &'a [f32],
    /// The first of the rows that are drawn on.
    pub top: f32,
}

/// 2^23: beyond it, numbers in single precision are whole, and their lowest bits count them.
const WHOLE: f32 = 8_388_608.0;

/// Returns the largest whole number that is not above a value of 0 to 2^22. Unlike a cast, this becomes vectors.
#[inline(always)]
fn floor_of_positive(value: f32) -> f32 {
    let nearest = (value + WHOLE) - WHOLE;
    nearest - if nearest > value { 1.0 } else { 0.0 }
}

/// Returns a whole number of 0 to 2^22 as an index; any number for other values.
#[inline(always)]
fn index_of(whole: f32) -> u32 {
    (whole + WHOLE).to_bits().wrapping_sub(WHOLE.to_bits())
}

/// Rows of a picture that depth pixels are drawn on, one after the other.
pub trait Canvas: Send {
    /// Whether it needs [`Dot::q`], [`Dot::s`], [`Dot::surface`] and [`Dot::slope`].
    const SPACED: bool;
    /// Whether it draws stretched depth pixels as such; needs [`Self::SPACED`].
    const STRETCHED: bool = false;
    /// Whether depth pixels are left out that a nearer one of their ray covers, see [`sums::COVERS`]; needs [`Self::SPACED`].
    const COVERED: bool = false;
    /// Whether it needs [`Dot::origin`].
    const ORIGINS: bool = false;
    /// How far from its position a depth pixel is drawn at most, in pixels.
    const REACH: f32;
    /// Returns how far from its position a depth pixel is drawn at most, in pixels, whose spacing and root of the sum of the
    /// squares of J ([`super::stretch`]) are no larger than these; no more than [`Self::REACH`].
    #[inline]
    fn reach(_largest_spacing: f32, _largest_stretch: f32) -> f32 {
        Self::REACH
    }
    /// Prepares to draw a batch of depth pixels.
    #[inline(always)]
    fn begin(&mut self, _batch: &BatchPositions) {}
    /// Draws all depth pixels of the batch, which have these colours, from the first to the last or back, if it can do that
    /// faster than one by one. Returns whether it did.
    #[inline(always)]
    fn draw_whole(&mut self, _colours: &[[u8; 4]], _forwards: bool) -> bool {
        false
    }
    /// Draws a depth pixel. Its position may be anywhere, and is no number where it is not to be seen.
    fn draw(&mut self, dot: &Dot);
}
