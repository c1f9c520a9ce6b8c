//! Depth pixels drawn as single pixels: the fastest splat, which leaves cracks where a surface is magnified.

use super::{BatchPositions, Canvas, Dot, floor_of_positive, index_of};
use crate::transfer::Positions;

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
    // Iterators are calls in the profile `quick`, which does not optimise across all functions.
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    fn find(&mut self, batch: &BatchPositions) {
        let Self { size, of_batch } = self;
        let (size, outside) = (*size, (size[0] * size[1]) as u32);
        let count = batch.u.len();
        let (us, vs, of_batch) = (batch.u, &batch.v[..count], &mut of_batch[..count]);
        for i in 0..count {
            let (u, v) = (us[i], vs[i] - batch.top);
            let within = (u >= 0.0) & (u < size[0]) & (v >= 0.0) & (v < size[1]);
            // A band has far fewer than 2^23 pixels, so the index is exact.
            let pixel = index_of(floor_of_positive(v) * size[0] + floor_of_positive(u));
            of_batch[i] = if within { pixel } else { outside };
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
pub struct PixelCanvas<'a> {
    targets: Targets,
    /// sRGB and opacity, not premultiplied, row by row.
    colours: &'a mut [[u8; 4]],
}

impl<'a> PixelCanvas<'a> {
    /// Makes a band of the pixels of a picture that it draws on.
    pub fn new(width: u32, colours: &'a mut [[u8; 4]]) -> Self {
        let height = colours.len() as u32 / width;
        Self { targets: Targets::new(width, height), colours }
    }
}

/// The least number that the bytes of an opaque colour make, the first one the lowest.
const OPAQUE: u32 = 0xff00_0000;

#[allow(clippy::needless_range_loop)]
impl Canvas for PixelCanvas<'_> {
    const SPACED: bool = false;
    const REACH: f32 = 0.0;

    #[inline(always)]
    fn begin(&mut self, batch: &BatchPositions) {
        self.targets.find(batch);
    }

    /// What is opaque is written without a look at what is there, or at its own opacity.
    #[inline(always)]
    fn draw_whole(&mut self, colours: &[[u8; 4]], forwards: bool) -> bool {
        let (targets, count) = (&self.targets.of_batch[..colours.len()], colours.len());
        let pixels = &mut *self.colours;
        let mut all = u32::MAX;
        for i in 0..count {
            all &= u32::from_le_bytes(colours[i]);
        }
        if all < OPAQUE {
            return false;
        }
        for i in 0..count {
            let i = if forwards { i } else { count - 1 - i };
            if let Some(pixel) = pixels.get_mut(targets[i] as usize) {
                *pixel = colours[i];
            }
        }
        true
    }

    #[inline(always)]
    fn draw(&mut self, dot: &Dot) {
        let Some(pixel) = self.colours.get_mut(self.targets.of(dot)) else { return };
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
    fn begin(&mut self, batch: &BatchPositions) {
        self.targets.find(batch);
    }

    #[inline(always)]
    fn draw(&mut self, dot: &Dot) {
        if dot.colour[3] >= 128 {
            self.indices[self.targets.of(dot)] = dot.index as u32 + 1;
        }
    }
}
