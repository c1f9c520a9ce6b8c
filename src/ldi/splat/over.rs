//! The published splats: masks of 1, 3 x 3 and 5 x 5 pixels in quarters, composited over what is there by shifts of stored
//! values (the paper, section 4). When which mask is meant, the paper does not say; here by the table of [`mask`].

use super::{Canvas, Dot};

/// The quarters of the mask of 3 x 3 pixels, row by row.
const SMALL: [[u8; 3]; 3] = [[1, 2, 1], [2, 4, 2], [1, 2, 1]];
/// The quarters of the mask of 5 x 5 pixels.
const LARGE: [[u8; 5]; 5] =
    [[1, 2, 2, 2, 1], [2, 2, 4, 2, 2], [2, 4, 4, 4, 2], [2, 2, 4, 2, 2], [1, 2, 2, 2, 1]];

/// The largest spacing that a mask closes; above it, a surface is too near.
pub const TOO_NEAR: f32 = 2.8;

/// Returns the mask of a spacing: its half side, 0 to 2.
#[inline]
pub fn mask(spacing: f32) -> usize {
    if spacing <= 0.75 {
        0
    } else if spacing <= 1.3 {
        1
    } else {
        2
    }
}

/// The largest half side of a mask.
const LARGEST: u32 = 2;
/// The pixels around a band on which masks may be drawn that do not reach into it, so that none needs to be clipped.
const BORDER: usize = 2 * LARGEST as usize;

/// A band with premultiplied colours, and a border.
#[derive(Debug)]
pub struct OverCanvas {
    width: u32,
    height: u32,
    /// sRGB, premultiplied, and opacity: R in the lowest byte. Row by row, with the border.
    pixels: Vec<u32>,
    /// The number of depth pixels that were too near.
    pub too_near: u64,
}

impl OverCanvas {
    /// Makes an empty band.
    pub fn new(width: u32, height: u32) -> Self {
        let pixels = vec![0; (width as usize + 2 * BORDER) * (height as usize + 2 * BORDER)];
        Self { width, height, pixels, too_near: 0 }
    }

    #[inline(always)]
    fn stride(&self) -> usize {
        self.width as usize + 2 * BORDER
    }

    /// Writes the colours divided by their opacity, row by row.
    pub fn write_colours(&self, out: &mut [[u8; 4]]) {
        let width = self.width as usize;
        for (y, row) in out.chunks_exact_mut(width).enumerate() {
            let start = (y + BORDER) * self.stride() + BORDER;
            for (colour, pixel) in row.iter_mut().zip(&self.pixels[start..start + width]) {
                *colour = divided(*pixel);
            }
        }
    }

    /// Draws a mask whose first pixel is at an index.
    #[inline(always)]
    // Iterators are calls in the profile `quick`, which does not optimise across all functions.
    #[allow(clippy::needless_range_loop)]
    fn stamp<const SIDE: usize>(&mut self, at: usize, mask: &[[u8; SIDE]; SIDE], colour: [u8; 4]) {
        let stride = self.stride();
        let [r, g, b, a] = colour;
        let opaque = u32::from_le_bytes([r, g, b, u8::MAX]);
        for j in 0..SIDE {
            let Some(row) = self.pixels[at + j * stride..].first_chunk_mut::<SIDE>() else { return };
            for i in 0..SIDE {
                row[i] = match a {
                    u8::MAX => blended(row[i], opaque, mask[j][i]),
                    a => blended_softly(row[i], opaque, mask[j][i], a),
                };
            }
        }
    }
}

impl Canvas for OverCanvas {
    const SPACED: bool = true;
    const REACH: f32 = LARGEST as f32;

    #[inline]
    fn reach(largest_spacing: f32, _largest_stretch: f32) -> f32 {
        mask(largest_spacing) as f32
    }

    #[inline(always)]
    fn draw(&mut self, dot: &Dot) {
        let (u, v) = (dot.u + Self::REACH, dot.v + Self::REACH);
        // Positions that are no numbers fail both comparisons.
        let within = u >= 0.0 && u < self.width as f32 + 2.0 * Self::REACH;
        if !(within && v >= 0.0 && v < self.height as f32 + 2.0 * Self::REACH) {
            return;
        }
        self.too_near += u64::from(dot.s > TOO_NEAR);
        // Casts drop fractions. The border is twice as wide as the reach, so no index is negative.
        let (x, y) = (u as i32 as usize, v as i32 as usize);
        let half = mask(dot.s);
        let at = (y + LARGEST as usize - half) * self.stride() + x + LARGEST as usize - half;
        match half {
            0 => self.stamp(at, &[[4]], dot.colour),
            1 => self.stamp(at, &SMALL, dot.colour),
            _ => self.stamp(at, &LARGE, dot.colour),
        }
    }
}

/// Returns a colour divided by its opacity.
#[inline(always)]
fn divided(pixel: u32) -> [u8; 4] {
    let [r, g, b, a] = pixel.to_le_bytes();
    if a == u8::MAX || a == 0 {
        return [r, g, b, a];
    }
    let opacity = u32::from(a);
    let part = |value: u8| ((u32::from(value) * 255 + opacity / 2) / opacity).min(255) as u8;
    [part(r), part(g), part(b), a]
}

/// The bits of each byte but the highest.
const LOW: u32 = 0x7f7f_7f7f;

/// Composites a colour over a premultiplied one with a weight of `quarters` / 4, by shifts: half of the step rounds, where a
/// plain shift darkens. `c + ((v - c + half) >> n)` is the mean rounded up of c and v for a half, and of c and their mean
/// rounded down for a quarter, which four bytes at a time find from their common and their different bits.
#[inline(always)]
fn blended(below: u32, colour: u32, quarters: u8) -> u32 {
    match quarters {
        4 => colour,
        2 => mean_up(below, colour),
        _ => mean_up(below, (below & colour) + (((below ^ colour) >> 1) & LOW)),
    }
}

/// Returns the mean of each byte, rounded up.
#[inline(always)]
fn mean_up(a: u32, b: u32) -> u32 {
    (a | b) - (((a ^ b) >> 1) & LOW)
}

/// The same for a colour of opacity `a`.
fn blended_softly(below: u32, colour: u32, quarters: u8, a: u8) -> u32 {
    let weight = i32::from(quarters) * i32::from(a);
    let (below, colour) = (below.to_le_bytes(), colour.to_le_bytes());
    u32::from_le_bytes(std::array::from_fn(|i| {
        let change = (i32::from(colour[i]) - i32::from(below[i])) * weight;
        (i32::from(below[i]) + (change + 510).div_euclid(1020)) as u8
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_bytes_are_blended_as_each_is() {
        for (below, colour) in (0..=255u8).flat_map(|below| (0..=255).map(move |colour| (below, colour))) {
            let [below, colour] = [[below, 255, !below, 0], [colour, below, 255, !colour]];
            for (quarters, shift, half) in [(4, 0, 0), (2, 1, 1), (1, 2, 2)] {
                let expected = u32::from_le_bytes(std::array::from_fn(|i| {
                    let change = i16::from(colour[i]) - i16::from(below[i]) + half;
                    (i16::from(below[i]) + (change >> shift)) as u8
                }));
                let [below, colour] = [below, colour].map(u32::from_le_bytes);
                assert_eq!(blended(below, colour, quarters), expected);
                assert_eq!(blended_softly(below, colour, quarters, 255), expected);
            }
        }
    }
}
