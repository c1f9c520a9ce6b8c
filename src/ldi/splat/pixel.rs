//! Depth pixels drawn as single pixels: the fastest splat, which leaves cracks where a surface is magnified.

use super::{Canvas, Dot, Placed, floor_of_positive, index_of};
use crate::ldi::transfer::Positions;

/// The size of a band, and the pixels of a batch of depth pixels in it.
#[derive(Debug)]
struct Targets {
    size: [f32; 2],
    /// Indices of pixels; one past the last pixel for depth pixels that are not in the band.
    of_batch: [u32; Positions::MOST],
}

impl Targets {
    fn new(width: u32, height: u32) -> Self {
        Self { size: [width as f32, height as f32], of_batch: [0; Positions::MOST] }
    }

    /// Finds the pixels of a batch. Positions that are no numbers are outside.
    #[inline(always)]
    fn find(&mut self, batch: &Placed) {
        let Self { size, of_batch } = self;
        let outside = (size[0] * size[1]) as u32;
        for ((u, v), target) in batch.u.iter().zip(batch.v).zip(of_batch) {
            let (u, v) = (*u, v - batch.top);
            let within = (u >= 0.0) & (u < size[0]) & (v >= 0.0) & (v < size[1]);
            // A band has far fewer than 2^23 pixels, so the index is exact.
            let pixel = index_of(floor_of_positive(v) * size[0] + floor_of_positive(u));
            *target = if within { pixel } else { outside };
        }
    }

    /// Returns the index of the pixel of a depth pixel.
    #[inline(always)]
    fn of(&self, dot: &Dot) -> usize {
        self.of_batch[dot.at] as usize
    }
}

/// A band with one colour a pixel.
#[derive(Debug)]
pub struct PixelCanvas {
    targets: Targets,
    /// sRGB and opacity, not premultiplied; after the last pixel there is one for what is outside.
    colours: Vec<[u8; 4]>,
}

impl PixelCanvas {
    /// Makes an empty band.
    pub fn new(width: u32, height: u32) -> Self {
        let colours = vec![[0; 4]; width as usize * height as usize + 1];
        Self { targets: Targets::new(width, height), colours }
    }

    /// Returns the colours, sRGB and opacity, not premultiplied, row by row.
    pub fn colours(&self) -> &[[u8; 4]] {
        &self.colours[..self.colours.len() - 1]
    }
}

impl Canvas for PixelCanvas {
    const SPACED: bool = false;
    const REACH: f32 = 0.0;

    #[inline(always)]
    fn begin(&mut self, batch: &Placed) {
        self.targets.find(batch);
    }

    #[inline(always)]
    fn draw(&mut self, dot: &Dot) {
        let pixel = &mut self.colours[self.targets.of(dot)];
        *pixel = if dot.colour[3] == u8::MAX { dot.colour } else { over(dot.colour, *pixel) };
    }
}

/// Composites a colour over another in stored values, neither premultiplied.
#[inline(never)]
fn over(colour: [u8; 4], below: [u8; 4]) -> [u8; 4] {
    let (a, b) = (u32::from(colour[3]), u32::from(below[3]));
    // In units of 1 / 255^2.
    let (top, under) = (255 * a, b * (255 - a));
    let opacity = (top + under).max(1);
    let mix =
        |c: usize| ((u32::from(colour[c]) * top + u32::from(below[c]) * under + opacity / 2) / opacity) as u8;
    [mix(0), mix(1), mix(2), ((top + under + 127) / 255) as u8]
}

/// A band with the index of the last depth pixel drawn at each pixel, of those that are mostly opaque.
#[derive(Debug)]
pub struct IndexCanvas {
    targets: Targets,
    /// 1 + the index of the depth pixel, 0 where there is none; after the last pixel there is one for what is outside.
    indices: Vec<u32>,
}

impl IndexCanvas {
    /// Makes an empty band.
    pub fn new(width: u32, height: u32) -> Self {
        let indices = vec![0; width as usize * height as usize + 1];
        Self { targets: Targets::new(width, height), indices }
    }

    /// Returns 1 + the index of the depth pixel of each pixel, 0 where there is none, row by row.
    pub fn indices(&self) -> &[u32] {
        &self.indices[..self.indices.len() - 1]
    }
}

impl Canvas for IndexCanvas {
    const SPACED: bool = false;
    const REACH: f32 = 0.0;

    #[inline(always)]
    fn begin(&mut self, batch: &Placed) {
        self.targets.find(batch);
    }

    #[inline(always)]
    fn draw(&mut self, dot: &Dot) {
        if dot.colour[3] >= 128 {
            self.indices[self.targets.of(dot)] = dot.index as u32 + 1;
        }
    }
}
