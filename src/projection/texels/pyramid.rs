//! The pyramid of a layer texture, its texels at every level of detail, from which tiles are cut. Colour is extended
//! past outlines so that filtering never fetches empty texels (push-pull in the spirit of Gortler et al.
//! 1996, as far as a filter reaches), and each texel has a confidence.

use glam::Vec4;

use super::confidence::ConfidenceRamp;
use super::halving::{Light, Rows};
use super::tiles::{GUTTER, TextureShape};
use crate::LayerTexturePixels;
use crate::sources::{BLEED, COVERED, FILLED};
use quadratura_base::geometry::{PixelRect, Spans};
use quadratura_view::srgb::Srgb;

/// Options of a pyramid.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PyramidOptions {
    /// The fall-off of confidence near borders.
    pub ramp: ConfidenceRamp,
}

/// The levels of detail of a layer texture.
#[derive(Debug, Clone)]
pub struct Pyramid {
    /// The size of the layer texture.
    pub shape: TextureShape,
    /// The levels, from the layer texture itself to one texel.
    pub levels: Vec<Level>,
    /// The number of texels that faces cover, with or without content.
    pub covered: u64,
}

/// One level of detail.
#[derive(Debug, Clone)]
pub struct Level {
    /// The texels with content.
    pub content: Spans,
    /// The part of the level that is stored, relative to the layer texture's corner; it may reach outside the layer
    /// texture by the gutter.
    pub rect: PixelRect,
    /// sRGB and confidence, 8 bits, rows from the top. Outside the content, texels up to two texels away have
    /// colours extended from it and confidence 0, and all others are black. Where the photo's own colour is
    /// known one texel outside, it is used with the least confidence: this serves the photo's own camera, and
    /// has hardly any effect elsewhere. Of a layer texture with a matte, colours are multiplied by the matte in linear light;
    /// of a matte ([`matte_pyramid`]), the last byte is the matte, and the others are 0.
    pub rgba: Vec<u8>,
}

impl Level {
    /// Returns the index of a texel's first byte; `x` and `y` in texels from the layer texture's corner.
    pub fn index(&self, x: i32, y: i32) -> usize {
        4 * self.rect.offset(x, y)
    }

    /// Allocates a level for this content and the colours extended past it.
    fn new(content: Spans) -> Self {
        let bounds = content.bounds();
        let rect = if bounds.is_empty() { bounds } else { bounds.grown(GUTTER) };
        // Zeroed memory costs nothing where it is never touched, and layer textures are mostly empty.
        Self { content, rect, rgba: vec![0; 4 * rect.area() as usize] }
    }

    /// Extends colour `GUTTER` texels past the content. Each ring of texels gets the mean of its neighbours
    /// in the previous ring, in linear light. Where the photo's own colour in the first ring is known
    /// (`shown`), that colour is used instead, with the least confidence.
    fn carry(&mut self, srgb: Srgb, bleed_colour: impl Fn(i32, i32) -> Option<[u8; 3]>) {
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
            if let Some([r, g, b]) = bleed_colour(x, y) {
                let at = self.index(x, y);
                self.rgba[at..at + 4].copy_from_slice(&[r, g, b, 1]);
            }
        }
    }

    /// Sets the colours of a ring, and as its confidence the least one, which marks the ring as known for the
    /// next ring.
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

/// Builds the pyramid of a layer texture whose rectangle is `rect` (in photo pixels).
///
/// Level 0 has the layer texture's pixels, bit for bit where they have content, times the matte if there is one.
/// Confidence is the pixel's alpha times the ramp, and at least 1/255 where there is content.
pub fn pyramid(rect: PixelRect, pixels: &LayerTexturePixels, options: &PyramidOptions) -> Pyramid {
    let srgb = Srgb::tables();
    let Some(matte) = &pixels.matte else {
        return of_values(rect, pixels, options, srgb);
    };
    let shares = Srgb::proportional();
    let texel = |([r, g, b, confidence], matte): ([u8; 4], u8)| {
        let share = shares.linear(matte);
        let [r, g, b] = [r, g, b].map(|value| srgb.encoded(share * srgb.linear(value)));
        [r, g, b, confidence]
    };
    of_values(rect, &with_values(pixels, matte, texel), options, srgb)
}

/// Builds the pyramid of a layer texture's matte, which covers the same texels at each level as the pyramid of its colours
/// and is extended past outlines in the same way; 1 throughout where the pixels have no matte.
pub fn matte_pyramid(rect: PixelRect, pixels: &LayerTexturePixels, options: &PyramidOptions) -> Pyramid {
    let solid;
    let matte = match &pixels.matte {
        Some(matte) => matte,
        None => {
            solid = vec![u8::MAX; pixels.needed.len()];
            &solid
        }
    };
    let values = with_values(pixels, matte, |([.., confidence], matte)| [matte, matte, matte, confidence]);
    let mut pyramid = of_values(rect, &values, options, Srgb::proportional());
    for texel in pyramid.levels.iter_mut().flat_map(|level| level.rgba.as_chunks_mut::<4>().0) {
        // Devices decode the first three bytes from sRGB, and leave the last one as it is.
        *texel = [0, 0, 0, texel[0]];
    }
    pyramid
}

/// Returns pixels with other values, made of their colours and mattes. The photo's own colours outside the content are left
/// out, because their mattes are not known.
fn with_values(
    pixels: &LayerTexturePixels,
    matte: &[u8],
    texel: impl Fn(([u8; 4], u8)) -> [u8; 4],
) -> LayerTexturePixels {
    let texels = pixels.rgba.as_chunks::<4>().0.iter().copied().zip(matte.iter().copied());
    LayerTexturePixels {
        rect: pixels.rect,
        rgba: texels.flat_map(texel).collect(),
        needed: pixels.needed.iter().map(|needed| needed & !BLEED).collect(),
        matte: None,
    }
}

/// Builds the pyramid of pixels as they are.
fn of_values(rect: PixelRect, pixels: &LayerTexturePixels, options: &PyramidOptions, srgb: Srgb) -> Pyramid {
    let shape = TextureShape::from_rect(rect);
    let from_corner = PixelRect { x: pixels.rect.x - rect.x, y: pixels.rect.y - rect.y, ..pixels.rect };
    let needed = runs_where(from_corner, &pixels.needed, |needed| needed & COVERED != 0);
    let mut first = photo_level(from_corner, pixels);
    let filled = runs_where(from_corner, &pixels.needed, |needed| needed & FILLED != 0);
    trust(&mut first, &filled, options.ramp);
    let mut levels = Vec::with_capacity(shape.levels() as usize);
    let mut light =
        (shape.levels() > 1).then(|| Light::half_of(&LinearLevel { level: &first, srgb }, shape.halves(0)));
    first.carry(srgb, |x, y| bleed(from_corner, pixels, x, y));
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
    /// Returns the memory that the pyramid uses, in bytes.
    pub fn bytes(&self) -> u64 {
        self.levels.iter().map(|level| level.rgba.len() as u64).sum()
    }
}

/// Returns the texels of a rectangle whose value satisfies `holds`; `values` are in row order. Values change
/// seldom along a row, so blocks are tested as a whole first.
pub fn runs_where<T>(rect: PixelRect, values: &[T], holds: impl Fn(&T) -> bool) -> Spans {
    Spans::from_rows(rect.y..rect.bottom(), |y, out| {
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

/// Builds level 0 from the pixels, with their alpha unchanged.
fn photo_level(rect: PixelRect, pixels: &LayerTexturePixels) -> Level {
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

/// Returns the photo's own colour at a texel outside the content, if the layer texture's pixels include it.
fn bleed(rect: PixelRect, pixels: &LayerTexturePixels, x: i32, y: i32) -> Option<[u8; 3]> {
    let index = rect.index(x, y)?;
    let [r, g, b, _] = pixels.rgba.as_chunks::<4>().0[index];
    (pixels.needed[index] & BLEED != 0).then_some([r, g, b])
}

/// Multiplies alpha with the ramp of confidence. Filled texels keep theirs, because they are not read from
/// the photo and cannot show the neighbouring surface by mistake.
fn trust(level: &mut Level, filled: &Spans, ramp: ConfidenceRamp) {
    let content = std::mem::take(&mut level.content);
    ramp.each(&content.minus(filled), |x, y, trust| {
        let at = level.index(x, y) + 3;
        level.rgba[at] = byte(f32::from(level.rgba[at]) / 255.0 * trust);
    });
    level.content = content;
}

/// Converts the confidence of a texel with content to 255ths; it is never 0.
fn byte(confidence: f32) -> u8 {
    ((confidence * 255.0 + 0.5) as u8).max(1)
}

/// Level 0, decoded to linear light while it is halved.
struct LinearLevel<'a> {
    level: &'a Level,
    srgb: Srgb,
}

impl Rows for LinearLevel<'_> {
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

/// Encodes a level in 8 bits.
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
