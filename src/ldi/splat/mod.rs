//! What depth pixels are drawn with: one pixel, the published masks ([`over`]), or sums of weights ([`sums`]).

pub mod over;
pub mod pixel;
pub mod sums;

use super::layout::DepthPixelOrigin;

/// A depth pixel at its position in a band of the picture.
#[derive(Debug, Clone, Copy)]
pub struct Dot {
    /// The column in pixels.
    pub u: f32,
    /// The row in pixels, from the top of the band.
    pub v: f32,
    /// Inverse depth in the picture's camera, in 1/world unit.
    pub q: f32,
    /// The spacing in pixels; not computed where the canvas does not ask for it.
    pub s: f32,
    /// The index of the depth pixel in its level.
    pub index: usize,
    /// Its index in the batch of depth pixels that was begun.
    pub at: usize,
    /// sRGB and opacity.
    pub colour: [u8; 4],
    /// Where the colour is from; not looked up where the canvas does not ask for it.
    pub origin: DepthPixelOrigin,
}

/// A band of a picture that depth pixels are drawn on, one after the other.
pub trait Canvas: Send {
    /// Whether it needs [`Dot::s`].
    const SPACED: bool;
    /// Whether it needs [`Dot::origin`].
    const ORIGINS: bool = false;
    /// How far from its position a depth pixel is drawn at most, in pixels.
    const REACH: f32;
    /// Prepares to draw a batch of depth pixels at these positions, of the picture; the band begins at row `top`.
    #[inline(always)]
    fn begin(&mut self, _u: &[f32], _v: &[f32], _top: f32) {}
    /// Draws a depth pixel whose position is within [`Self::REACH`] of the band.
    fn draw(&mut self, dot: &Dot);
}
