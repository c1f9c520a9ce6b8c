//! A sheet's texels at every level of detail, ready to be cut into tiles: colour carried past outlines so
//! that filtering never fetches emptiness (push-pull in the spirit of Gortler et al. 1996, by as much as a
//! filter reaches), and confidence beside it.

use glam::Vec4;

use super::confidence::Ramp;
use super::halving::{Light, Rows};
use super::srgb::Srgb;
use super::tiles::{GUTTER, Shape};
use crate::geometry::{PixelRect, Spans};
use crate::projection::SheetPixels;
use crate::projection::sources::{BESIDE, COVERED, FILLED};

/// How a pyramid is made.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PyramidOptions {
    /// Confidence near borders.
    pub ramp: Ramp,
}

/// All levels of a sheet.
#[derive(Debug, Clone)]
pub struct Pyramid {
    /// Of the sheet.
    pub shape: Shape,
    /// From the sheet itself to one texel.
    pub levels: Vec<Level>,
    /// Texels that faces cover, whether there is anything or not.
    pub covered: u64,
}

/// One level.
#[derive(Debug, Clone)]
pub struct Level {
    /// Texels that hold something.
    pub content: Spans,
    /// The part of the level that is kept, relative to the sheet's corner; may reach outside of it by the
    /// gutter.
    pub rect: PixelRect,
    /// sRGB and confidence, 8 bits, rows from the top. Where there is no content colour is the
    /// neighbours', two texels far, then black, and confidence 0; or what the photo shows, one texel far,
    /// and the least confidence: a photo's own camera is served there, hardly anyone else.
    pub rgba: Vec<u8>,
}

impl Level {
    /// The byte where a texel of `rect` begins.
    pub fn index(&self, x: i32, y: i32) -> usize {
        4 * self.rect.offset(x, y)
    }

    /// Room for this content and what is carried past it.
    fn new(content: Spans) -> Self {
        let bounds = content.bounds();
        let rect = if bounds.is_empty() { bounds } else { bounds.grown(GUTTER) };
        // Zeroed memory costs nothing where it is never touched: sheets are mostly empty.
        Self { content, rect, rgba: vec![0; 4 * rect.area() as usize] }
    }

    /// Colour flows `GUTTER` texels past the content: the first ring has what the photo shows there
    /// (`shown`), where that is known, and the least confidence; else a ring is the mean of its neighbours
    /// of the ring before, in linear light.
    fn carry(&mut self, srgb: Srgb, shown: impl Fn(i32, i32) -> Option<[u8; 3]>) {
        let mut inside = self.content.clone();
        let mut rings = Vec::new();
        for _ in 0..GUTTER {
            let outside = inside.grown(1);
            let ring = outside.minus(&inside);
            self.fill_ring(&ring, srgb);
            rings.push(ring);
            inside = outside;
        }
        for (y, run) in rings.iter().flat_map(Spans::iter) {
            run.clone().for_each(|x| self.set_confidence(x, y, 0));
        }
        for (y, x) in rings[0].iter().flat_map(|(y, run)| run.clone().map(move |x| (y, x))) {
            if let Some([r, g, b]) = shown(x, y) {
                let at = self.index(x, y);
                self.rgba[at..at + 4].copy_from_slice(&[r, g, b, 1]);
            }
        }
    }

    /// Gives the texels of a ring a colour, and the least confidence as the mark that the next ring looks for.
    fn fill_ring(&mut self, ring: &Spans, srgb: Srgb) {
        let texels = ring.iter().flat_map(|(y, run)| run.clone().map(move |x| (x, y)));
        let filled: Vec<(usize, [u8; 4])> =
            texels.map(|(x, y)| (self.index(x, y), self.mean_about(x, y, srgb))).collect();
        for (at, texel) in filled {
            self.rgba[at..at + 4].copy_from_slice(&texel);
        }
    }

    fn mean_about(&self, x: i32, y: i32, srgb: Srgb) -> [u8; 4] {
        let (mut sum, mut count) = ([0.0; 3], 0.0f32);
        let columns = (x - 1).max(self.rect.x)..=(x + 1).min(self.rect.right() - 1);
        for row in (y - 1).max(self.rect.y)..=(y + 1).min(self.rect.bottom() - 1) {
            for column in columns.clone() {
                let at = self.index(column, row);
                if self.rgba[at + 3] > 0 {
                    (0..3).for_each(|c| sum[c] += srgb.linear(self.rgba[at + c]));
                    count += 1.0;
                }
            }
        }
        let [r, g, b] = sum.map(|sum| srgb.encoded(sum / count.max(1.0)));
        [r, g, b, 1]
    }

    fn set_confidence(&mut self, x: i32, y: i32, confidence: u8) {
        let at = self.index(x, y);
        self.rgba[at + 3] = confidence;
    }
}

/// The pyramid of a sheet whose rectangle is `rect` (in photo pixels).
///
/// Level 0 is the sheet's pixels, bit for bit where they hold anything. Confidence is the pixel's alpha
/// times the ramp, never less than 1/255 where there is content.
pub fn pyramid(rect: PixelRect, pixels: &SheetPixels, options: &PyramidOptions) -> Pyramid {
    let (shape, srgb) = (Shape::of(rect), Srgb::tables());
    let from_corner = PixelRect { x: pixels.rect.x - rect.x, y: pixels.rect.y - rect.y, ..pixels.rect };
    let needed = runs_where(from_corner, &pixels.needed, |needed| needed & COVERED != 0);
    let mut first = photo_level(from_corner, pixels);
    let filled = runs_where(from_corner, &pixels.needed, |needed| needed & FILLED != 0);
    trust(&mut first, &filled, options.ramp);
    let mut levels = Vec::with_capacity(shape.levels() as usize);
    let mut light =
        (shape.levels() > 1).then(|| Light::half_of(&Decoded { level: &first, srgb }, shape.halves(0)));
    first.carry(srgb, |x, y| beside(from_corner, pixels, x, y));
    levels.push(first);
    while let Some(above) = light.take() {
        let level = levels.len() as u32;
        if level + 1 < shape.levels() {
            light = Some(Light::half_of(&above, shape.halves(level)));
        }
        levels.push(encoded(above, srgb));
    }
    Pyramid { shape, levels, covered: needed.count() }
}

impl Pyramid {
    /// Bytes that it holds in memory.
    pub fn bytes(&self) -> u64 {
        self.levels.iter().map(|level| level.rgba.len() as u64).sum()
    }
}

/// The texels of a rectangle whose value `holds`, given all values in row order. Rows are long and change
/// seldom: blocks are looked at as a whole first.
pub fn runs_where<T>(rect: PixelRect, values: &[T], holds: impl Fn(&T) -> bool) -> Spans {
    Spans::of_rows(rect.y..rect.bottom(), |y, out| {
        let row = (y - rect.y) as usize * rect.w as usize;
        let mut x = rect.x;
        for block in values[row..row + rect.w as usize].chunks(32) {
            let count = block.iter().map(|value| u8::from(holds(value))).sum::<u8>();
            if usize::from(count) == block.len() {
                out.push(x..x + block.len() as i32);
            } else if count > 0 {
                let held = (x..).zip(block).filter(|(_, value)| holds(value));
                out.extend(held.map(|(x, _)| x..x + 1));
            }
            x += block.len() as i32;
        }
    })
}

/// The pixels as level 0, their alpha as it is.
fn photo_level(rect: PixelRect, pixels: &SheetPixels) -> Level {
    let mut level = Level::new(runs_where(rect, pixels.rgba.as_chunks::<4>().0, |texel| texel[3] != 0));
    let content = std::mem::take(&mut level.content);
    for (y, run) in content.iter() {
        let to = level.index(run.start, y);
        let from = 4 * rect.offset(run.start, y);
        let bytes = 4 * run.len();
        level.rgba[to..to + bytes].copy_from_slice(&pixels.rgba[from..from + bytes]);
    }
    Level { content, ..level }
}

/// What the photo shows at a texel that holds nothing, if the sheet's pixels tell.
fn beside(rect: PixelRect, pixels: &SheetPixels, x: i32, y: i32) -> Option<[u8; 3]> {
    let index = rect.index(x, y)?;
    let [r, g, b, _] = pixels.rgba.as_chunks::<4>().0[index];
    (pixels.needed[index] & BESIDE != 0).then_some([r, g, b])
}

/// Alpha becomes confidence. What was filled keeps its own: it is invented beside what the photo shows, not
/// taken for it.
fn trust(level: &mut Level, filled: &Spans, ramp: Ramp) {
    let content = std::mem::take(&mut level.content);
    ramp.each(&content.minus(filled), |x, y, trust| {
        let at = level.index(x, y) + 3;
        level.rgba[at] = byte(f32::from(level.rgba[at]) / 255.0 * trust);
    });
    level.content = content;
}

/// Of content: never 0.
fn byte(confidence: f32) -> u8 {
    ((confidence * 255.0 + 0.5) as u8).max(1)
}

/// Level 0 on its way to linear light.
struct Decoded<'a> {
    level: &'a Level,
    srgb: Srgb,
}

impl Rows for Decoded<'_> {
    fn content(&self) -> &Spans {
        &self.level.content
    }

    fn row(&self, y: i32, x: i32, count: usize, mut put: impl FnMut(usize, Vec4, f32)) {
        let at = self.level.index(x, y);
        for (i, texel) in self.level.rgba[at..at + 4 * count].as_chunks().0.iter().enumerate() {
            let [r, g, b, confidence]: [u8; 4] = *texel;
            let [r, g, b] = [r, g, b].map(|value| self.srgb.linear(value));
            put(i, Vec4::new(r, g, b, 1.0), f32::from(confidence) * (1.0 / 255.0));
        }
    }
}

/// A level of 8 bits.
fn encoded(light: Light, srgb: Srgb) -> Level {
    let mut level = Level::new(light.content.clone());
    for (y, run) in light.content.iter() {
        let (from, to) = (light.rect.offset(run.start, y), level.index(run.start, y));
        let texels = level.rgba[to..to + 4 * run.len()].as_chunks_mut().0;
        for (texel, i) in texels.iter_mut().zip(from..) {
            let colour = light.colour[i] / light.colour[i].w;
            let [r, g, b, _] = colour.to_array().map(|value| srgb.encoded(value));
            *texel = [r, g, b, byte(light.confidence[i])];
        }
    }
    level.carry(srgb, |_, _| None);
    level
}

#[cfg(test)]
pub(super) mod tests;
