//! Depth pixels drawn as single pixels: the fastest splat, which leaves cracks where a surface is magnified.

use super::{Canvas, Dot};
use crate::ldi::transfer::Positions;

/// The size of a band, and the pixels of a batch of depth pixels in it.
#[derive(Debug)]
struct Targets {
    size: [f32; 2],
    /// Indices of pixels; [`OUTSIDE`] for depth pixels that are not in the band.
    of_batch: [u32; Positions::MOST],
}

const OUTSIDE: u32 = u32::MAX;

/// 2^23: beyond it, numbers in single precision are whole, and their lowest bits count them.
const WHOLE: f32 = 8_388_608.0;

/// Returns the largest whole number that is not above a value of 0 to 2^22. Unlike a cast, this becomes vectors.
#[inline(always)]
fn floor(value: f32) -> f32 {
    let nearest = (value + WHOLE) - WHOLE;
    nearest - if nearest > value { 1.0 } else { 0.0 }
}

impl Targets {
    fn new(width: u32, height: u32) -> Self {
        Self { size: [width as f32, height as f32], of_batch: [OUTSIDE; Positions::MOST] }
    }

    /// Finds the pixels of a batch. Positions that are no numbers are outside.
    #[inline(always)]
    fn find(&mut self, u: &[f32], v: &[f32], top: f32) {
        let Self { size, of_batch } = self;
        for ((u, v), target) in u.iter().zip(v).zip(of_batch) {
            let (u, v) = (*u, v - top);
            let within = (u >= 0.0) & (u < size[0]) & (v >= 0.0) & (v < size[1]);
            // A band has far fewer than 2^23 pixels, so the index is exact.
            let pixel = (floor(v) * size[0] + floor(u) + WHOLE).to_bits().wrapping_sub(WHOLE.to_bits());
            *target = if within { pixel } else { OUTSIDE };
        }
    }

    #[inline(always)]
    fn of(&self, dot: &Dot) -> Option<usize> {
        let target = self.of_batch[dot.at];
        (target != OUTSIDE).then_some(target as usize)
    }
}

/// A band with one colour a pixel.
#[derive(Debug)]
pub struct PixelCanvas {
    targets: Targets,
    /// sRGB and opacity, not premultiplied.
    pub colours: Vec<[u8; 4]>,
}

impl PixelCanvas {
    /// Makes an empty band.
    pub fn new(width: u32, height: u32) -> Self {
        let colours = vec![[0; 4]; width as usize * height as usize];
        Self { targets: Targets::new(width, height), colours }
    }
}

impl Canvas for PixelCanvas {
    const SPACED: bool = false;
    const REACH: f32 = 0.0;

    #[inline(always)]
    fn begin(&mut self, u: &[f32], v: &[f32], top: f32) {
        self.targets.find(u, v, top);
    }

    #[inline(always)]
    fn draw(&mut self, dot: &Dot) {
        if let Some(at) = self.targets.of(dot) {
            let pixel = &mut self.colours[at];
            *pixel = if dot.colour[3] == u8::MAX { dot.colour } else { over(dot.colour, *pixel) };
        }
    }
}

/// Composites a colour over another in stored values, neither premultiplied.
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
    /// 1 + the index of the depth pixel, 0 where there is none.
    pub indices: Vec<u32>,
}

impl IndexCanvas {
    /// Makes an empty band.
    pub fn new(width: u32, height: u32) -> Self {
        Self { targets: Targets::new(width, height), indices: vec![0; width as usize * height as usize] }
    }
}

impl Canvas for IndexCanvas {
    const SPACED: bool = false;
    const REACH: f32 = 0.0;

    #[inline(always)]
    fn begin(&mut self, u: &[f32], v: &[f32], top: f32) {
        self.targets.find(u, v, top);
    }

    #[inline(always)]
    fn draw(&mut self, dot: &Dot) {
        if dot.colour[3] >= 128
            && let Some(at) = self.targets.of(dot)
        {
            self.indices[at] = dot.index as u32 + 1;
        }
    }
}
