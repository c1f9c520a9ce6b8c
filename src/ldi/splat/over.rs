//! The published splats: masks of 1, 3 x 3 and 5 x 5 pixels in quarters, composited over what is there by shifts of stored
//! values (the paper, section 4). When which mask is meant, the paper does not say; here by the table of [`mask`].

use super::{Canvas, Dot};

/// The quarters of the masks, by their distance from the centre: rows of the right lower part.
const MASKS: [&[&[u8]]; 3] = [&[&[4]], &[&[4, 2], &[2, 1]], &[&[4, 4, 2], &[4, 2, 2], &[2, 2, 1]]];

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

/// A band with premultiplied colours.
#[derive(Debug)]
pub struct OverCanvas {
    width: i32,
    height: i32,
    /// sRGB, premultiplied, and opacity: four bytes in four lanes of 16 bits ([`lanes`]).
    pixels: Vec<u64>,
    /// The number of depth pixels that were too near.
    pub too_near: u64,
}

impl OverCanvas {
    /// Makes an empty band.
    pub fn new(width: u32, height: u32) -> Self {
        let pixels = vec![0; width as usize * height as usize];
        Self { width: width as i32, height: height as i32, pixels, too_near: 0 }
    }

    /// Returns the colours divided by their opacity.
    pub fn colours(&self) -> impl Iterator<Item = [u8; 4]> + '_ {
        self.pixels.iter().map(|&pixel| {
            let [r, g, b, a] = bytes(pixel);
            let part = |value: u8| match a {
                0 => 0,
                a => ((u32::from(value) * 255 + u32::from(a) / 2) / u32::from(a)).min(255) as u8,
            };
            [part(r), part(g), part(b), a]
        })
    }
}

impl Canvas for OverCanvas {
    const SPACED: bool = true;
    const REACH: f32 = 3.0;

    #[inline(always)]
    fn draw(&mut self, dot: &Dot) {
        let (u, v) = (dot.u + Self::REACH, dot.v + Self::REACH);
        // Positions that are no numbers fail both comparisons.
        let within = u >= 0.0 && u < self.width as f32 + 2.0 * Self::REACH;
        if !(within && v >= 0.0 && v < self.height as f32 + 2.0 * Self::REACH) {
            return;
        }
        let half = mask(dot.s);
        self.too_near += u64::from(dot.s > TOO_NEAR);
        let (x, y) = (u as i32 - Self::REACH as i32, v as i32 - Self::REACH as i32);
        let side = half as i32;
        let columns = (x - side).max(0)..(x + side + 1).min(self.width);
        let [r, g, b, a] = dot.colour;
        let colour = lanes([r, g, b, u8::MAX]);
        for j in (y - side).max(0)..(y + side + 1).min(self.height) {
            let quarters = MASKS[half][j.abs_diff(y) as usize];
            let start = (j * self.width) as usize;
            let row = &mut self.pixels[start..start + self.width as usize];
            for i in columns.clone() {
                let pixel = &mut row[i as usize];
                let quarters = quarters[i.abs_diff(x) as usize];
                *pixel = match a {
                    u8::MAX => blended(*pixel, colour, quarters),
                    a => blended_softly(*pixel, colour, quarters, a),
                };
            }
        }
    }
}

/// One in each of four lanes of 16 bits.
const ONES: u64 = 0x0001_0001_0001_0001;

/// Returns four bytes in four lanes of 16 bits.
#[inline(always)]
fn lanes([r, g, b, a]: [u8; 4]) -> u64 {
    u64::from(r) | u64::from(g) << 16 | u64::from(b) << 32 | u64::from(a) << 48
}

/// Returns the bytes of four lanes.
#[inline(always)]
fn bytes(lanes: u64) -> [u8; 4] {
    [lanes as u8, (lanes >> 16) as u8, (lanes >> 32) as u8, (lanes >> 48) as u8]
}

/// Composites a colour over a premultiplied one with a weight of `quarters` / 4, by shifts: half of the step rounds, where a
/// plain shift darkens. `c + ((v - c + half) >> n)` is `((2^n - 1) c + v + half) >> n`, and no lane overflows.
#[inline(always)]
fn blended(below: u64, colour: u64, quarters: u8) -> u64 {
    match quarters {
        4 => colour,
        2 => ((below + colour + ONES) >> 1) & (255 * ONES),
        _ => ((3 * below + colour + 2 * ONES) >> 2) & (255 * ONES),
    }
}

/// The same for a colour of opacity `a`.
fn blended_softly(below: u64, colour: u64, quarters: u8, a: u8) -> u64 {
    let weight = i32::from(quarters) * i32::from(a);
    let (below, colour) = (bytes(below), bytes(colour));
    lanes(std::array::from_fn(|i| {
        let change = (i32::from(colour[i]) - i32::from(below[i])) * weight;
        (i32::from(below[i]) + (change + 510).div_euclid(1020)) as u8
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_are_blended_as_bytes_are() {
        let colours = [[0, 255, 100, 255], [255, 0, 7, 255], [1, 2, 253, 255]];
        for (below, colour) in colours.into_iter().flat_map(|below| colours.map(|colour| (below, colour))) {
            for (quarters, shift, half) in [(4, 0, 0), (2, 1, 1), (1, 2, 2)] {
                let expected: [u8; 4] = std::array::from_fn(|i| {
                    let change = i16::from(colour[i]) - i16::from(below[i]) + half;
                    (i16::from(below[i]) + (change >> shift)) as u8
                });
                assert_eq!(bytes(blended(lanes(below), lanes(colour), quarters)), expected);
                assert_eq!(blended_softly(lanes(below), lanes(colour), quarters, 255), lanes(expected));
            }
        }
    }
}
