//! Pixels of a layer in memory.

use super::depth::Depth;
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::over::on_opaque;
use quadratura_base::raster::sample::with_alpha;
use quadratura_base::raster::{Sample, in_8_bits};
use quadratura_base::scene::light::{bytes_of_light_times, linear_of_srgb, srgb_from_linear};
use quadratura_base::scene::{PhotoPixels, Samples};

/// Pixels as R, G, B, A with straight alpha; rows from the top, pixels from the left.
#[derive(Debug, Clone, PartialEq)]
pub struct Raster {
    width: u32,
    height: u32,
    samples: Samples,
}

/// Samples per pixel.
const RGBA: usize = 4;

impl Raster {
    /// Takes samples in the order of [`Raster`].
    ///
    /// # Panics
    /// When their number is not `4 * width * height`.
    pub fn new(width: u32, height: u32, samples: Samples) -> Self {
        let expected = RGBA * width as usize * height as usize;
        assert_eq!(samples.len(), expected, "samples of {width} x {height} pixels");
        Self { width, height, samples }
    }

    /// Creates a fully transparent raster.
    pub fn blank(width: u32, height: u32, depth: Depth) -> Self {
        let count = RGBA * width as usize * height as usize;
        let samples = match depth {
            Depth::Eight => Samples::U8(vec![0; count]),
            Depth::Sixteen => Samples::U16(vec![0; count]),
        };
        Self { width, height, samples }
    }

    /// Converts the pixels of a photo; they become opaque where the photo has no alpha.
    pub fn of_photo(photo: PhotoPixels) -> Self {
        let samples = match photo.samples {
            samples if photo.channels == RGBA => samples,
            Samples::U8(s) => Samples::U8(with_alpha(&s)),
            Samples::U16(s) => Samples::U16(with_alpha(&s)),
        };
        Self::new(photo.width, photo.height, samples)
    }

    /// Returns the width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns the bit depth.
    pub fn depth(&self) -> Depth {
        Depth::from_samples(&self.samples)
    }

    /// Returns the samples in the order of [`Raster`].
    pub fn samples(&self) -> &Samples {
        &self.samples
    }

    /// Returns the samples for modification.
    pub fn samples_mut(&mut self) -> &mut Samples {
        &mut self.samples
    }

    /// Returns R, G, B, A of the pixel in column `x`, row `y` in 16 bits; 8 bits are scaled to the full
    /// range.
    pub fn rgba16(&self, x: u32, y: u32) -> [u16; RGBA] {
        let at = RGBA * (y as usize * self.width as usize + x as usize);
        match &self.samples {
            Samples::U8(s) => std::array::from_fn(|i| s[at + i].in_16_bits()),
            Samples::U16(s) => std::array::from_fn(|i| s[at + i]),
        }
    }

    /// Sets the pixel in column `x`, row `y`; 16 bits are rounded if the raster has 8.
    pub fn set_rgba16(&mut self, x: u32, y: u32, colour: [u16; RGBA]) {
        let at = RGBA * (y as usize * self.width as usize + x as usize);
        match &mut self.samples {
            Samples::U8(s) => (0..RGBA).for_each(|i| s[at + i] = in_8_bits(colour[i])),
            Samples::U16(s) => s[at..at + RGBA].copy_from_slice(&colour),
        }
    }

    /// Converts to another bit depth. From 16 bits to 8 samples are rounded to the nearest; from 8 to 16 and
    /// back they are unchanged.
    pub fn in_depth(self, depth: Depth) -> Self {
        let samples = match (self.samples, depth) {
            (Samples::U8(s), Depth::Sixteen) => Samples::U16(s.iter().map(|s| s.in_16_bits()).collect()),
            (Samples::U16(s), Depth::Eight) => Samples::U8(s.iter().map(|s| in_8_bits(*s)).collect()),
            (samples, _) => samples,
        };
        Self { samples, ..self }
    }

    /// Multiplies R, G, B in linear light and clips at white. Samples are interpreted as sRGB, as everywhere.
    /// A factor of 1 changes nothing.
    pub fn multiply_light(&mut self, factors: [f64; 3]) {
        for (channel, factor) in factors.into_iter().enumerate().filter(|(_, factor)| *factor != 1.0) {
            let brought = |value: f64| srgb_from_linear((linear_of_srgb(value) * factor).min(1.0));
            match &mut self.samples {
                Samples::U8(samples) => {
                    let of = bytes_of_light_times(factor);
                    samples[channel..].iter_mut().step_by(RGBA).for_each(|s| *s = of[usize::from(*s)]);
                }
                Samples::U16(samples) => {
                    let of: Vec<u16> = (0..=u16::MAX)
                        .map(|v| (brought(f64::from(v) / 65535.0) * 65535.0).round() as u16)
                        .collect();
                    samples[channel..].iter_mut().step_by(RGBA).for_each(|s| *s = of[usize::from(*s)]);
                }
            }
        }
    }

    /// Returns whether the pixel in column `x`, row `y` is not fully transparent.
    pub fn has_colour(&self, x: u32, y: u32) -> bool {
        let alpha = RGBA * (y as usize * self.width as usize + x as usize) + 3;
        match &self.samples {
            Samples::U8(s) => s[alpha] != 0,
            Samples::U16(s) => s[alpha] != 0,
        }
    }

    /// Fills the fully transparent pixels with those of `below`, which has the same size and depth.
    ///
    /// # Panics
    /// When they differ in size or depth.
    pub fn lay_over(&mut self, below: &Self) {
        assert_eq!((self.width, self.height), (below.width, below.height), "two rasters of one size");
        match (&mut self.samples, &below.samples) {
            (Samples::U8(own), Samples::U8(below)) => lay_over(own, below),
            (Samples::U16(own), Samples::U16(below)) => lay_over(own, below),
            _ => assert_eq!(self.depth(), below.depth(), "two rasters of one depth"),
        }
    }

    /// Returns the part in `rect`, which is relative to the raster's top-left corner.
    ///
    /// # Panics
    /// When `rect` is not within the raster.
    pub fn cropped(self, rect: PixelRect) -> Self {
        if (rect.x, rect.y, rect.w, rect.h) == (0, 0, self.width, self.height) {
            return self;
        }
        let samples = match &self.samples {
            Samples::U8(s) => Samples::U8(cropped(s, self.width, rect)),
            Samples::U16(s) => Samples::U16(cropped(s, self.width, rect)),
        };
        Self::new(rect.w, rect.h, samples)
    }

    /// Returns the picture over white, opaque, as a viewer without layers shows it.
    pub(crate) fn on_white(&self) -> Self {
        let samples = match &self.samples {
            Samples::U8(s) => Samples::U8(on_white(s)),
            Samples::U16(s) => Samples::U16(on_white(s)),
        };
        Self::new(self.width, self.height, samples)
    }

    /// Returns a reduced 8-bit copy of an opaque picture with no side longer than `longest` pixels: the mean
    /// of each block of pixels. Blocks have any size, so this is no `raster::halving`.
    pub fn thumbnail(&self, longest: u32) -> Self {
        let scale = self.width.max(self.height).div_ceil(longest).max(1);
        let (width, height) = (self.width.div_ceil(scale), self.height.div_ceil(scale));
        let mut samples = Vec::with_capacity(RGBA * width as usize * height as usize);
        for y in 0..height {
            for x in 0..width {
                let cell = PixelRect::from_edges(
                    (x * scale) as i32,
                    (y * scale) as i32,
                    ((x + 1) * scale).min(self.width) as i32,
                    ((y + 1) * scale).min(self.height) as i32,
                );
                samples.extend(match &self.samples {
                    Samples::U8(s) => mean(s, self.width, cell).map(|value| value as u8),
                    Samples::U16(s) => mean(s, self.width, cell).map(|value| (value / 257) as u8),
                });
            }
        }
        Self::new(width, height, Samples::U8(samples))
    }

    /// Returns the bounding box of all pixels that are not fully transparent, relative to the raster's
    /// top-left corner; empty where there are none.
    pub fn coloured_rect(&self) -> PixelRect {
        match &self.samples {
            Samples::U8(s) => coloured_rect(s, self.width),
            Samples::U16(s) => coloured_rect(s, self.width),
        }
    }

    /// Returns a hash of the visible content when the raster's top-left corner is at `(x, y)`: position,
    /// depth and colours of all pixels that are not fully transparent. It does not change when an editor
    /// crops or enlarges the layer, or drops the colour of transparent pixels.
    pub fn hash_at(&self, x: i32, y: i32) -> String {
        let seen = self.coloured_rect();
        let mut hasher = blake3::Hasher::new();
        hasher.update(&[self.depth().bits()]);
        // Editors put a layer without content anywhere.
        let (left, top) = if seen.is_empty() { (0, 0) } else { (seen.x + x, seen.y + y) };
        for number in [left, top, seen.w as i32, seen.h as i32] {
            hasher.update(&number.to_le_bytes());
        }
        match &self.samples {
            Samples::U8(s) => hash_rows(s, self.width, seen, &mut hasher, |v, out| out.push(v)),
            Samples::U16(s) => {
                hash_rows(s, self.width, seen, &mut hasher, |v, out| out.extend_from_slice(&v.to_le_bytes()));
            }
        }
        hasher.finalize().to_hex().to_string()
    }
}

/// Returns the samples of row `y` of `rect` in an image `width` pixels wide.
fn row_of<T>(samples: &[T], width: u32, rect: PixelRect, y: u32) -> &[T] {
    let start = (rect.y as usize + y as usize) * width as usize + rect.x as usize;
    &samples[RGBA * start..RGBA * (start + rect.w as usize)]
}

fn lay_over<T: Copy + PartialEq + Default>(own: &mut [T], below: &[T]) {
    let clear = T::default();
    for (own, below) in own.as_chunks_mut::<RGBA>().0.iter_mut().zip(below.as_chunks::<RGBA>().0) {
        if own[3] == clear {
            *own = *below;
        }
    }
}

fn cropped<T: Copy>(samples: &[T], width: u32, rect: PixelRect) -> Vec<T> {
    assert!(rect.x >= 0 && rect.right() <= width as i32, "the crop lies within the raster");
    let mut out = Vec::with_capacity(RGBA * rect.area() as usize);
    for y in 0..rect.h {
        out.extend_from_slice(row_of(samples, width, rect, y));
    }
    out
}

fn mean<T: Copy + Into<u64>>(samples: &[T], width: u32, cell: PixelRect) -> [u64; RGBA] {
    let mut sum = [0; RGBA];
    for y in 0..cell.h {
        let (pixels, _) = row_of(samples, width, cell, y).as_chunks::<RGBA>();
        pixels.iter().for_each(|pixel| (0..RGBA).for_each(|i| sum[i] += pixel[i].into()));
    }
    sum.map(|sum| (sum + cell.area() / 2) / cell.area())
}

fn on_white<T: Sample>(samples: &[T]) -> Vec<T> {
    let mut out = samples.to_vec();
    for pixel in out.as_chunks_mut::<RGBA>().0.iter_mut().filter(|pixel| pixel[3] != T::FULL) {
        let [r, g, b] = [0, 1, 2].map(|c| on_opaque(pixel[c], pixel[3], T::FULL));
        *pixel = [r, g, b, T::FULL];
    }
    out
}

fn coloured_rect<T: Copy + PartialEq + Default>(samples: &[T], width: u32) -> PixelRect {
    let clear = T::default();
    let mut found: Option<PixelRect> = None;
    for (y, row) in samples.chunks_exact(RGBA * width.max(1) as usize).enumerate() {
        let coloured = |pixel: &[T]| pixel[3] != clear;
        let Some(first) = row.chunks_exact(RGBA).position(coloured) else { continue };
        let last = row.chunks_exact(RGBA).rposition(coloured).expect("there is a first one");
        let here = PixelRect::from_edges(first as i32, y as i32, last as i32 + 1, y as i32 + 1);
        found = Some(found.map_or(here, |so_far| so_far.union(&here)));
    }
    found.unwrap_or(PixelRect::EMPTY)
}

fn hash_rows<T: Copy + PartialEq + Default>(
    samples: &[T],
    width: u32,
    rect: PixelRect,
    hasher: &mut blake3::Hasher,
    put: impl Fn(T, &mut Vec<u8>),
) {
    let clear = T::default();
    let mut bytes = Vec::new();
    for y in 0..rect.h {
        bytes.clear();
        for pixel in row_of(samples, width, rect, y).chunks_exact(RGBA) {
            let seen = pixel[3] != clear;
            pixel.iter().for_each(|sample| put(if seen { *sample } else { clear }, &mut bytes));
        }
        hasher.update(&bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raster(width: u32, height: u32, set: &[(u32, u32, [u8; 4])]) -> Raster {
        let mut samples = vec![0; RGBA * (width * height) as usize];
        for (x, y, colour) in set {
            let at = RGBA * (y * width + x) as usize;
            samples[at..at + 4].copy_from_slice(colour);
        }
        Raster::new(width, height, Samples::U8(samples))
    }

    #[test]
    fn twice_the_light_is_another_value_and_once_the_light_is_the_same() {
        let mut raster = Raster::new(1, 1, Samples::U8(vec![100, 100, 200, 50]));
        raster.multiply_light([2.0, 1.0, 9.0]);
        assert_eq!(*raster.samples(), Samples::U8(vec![138, 100, 255, 50]));
        let mut raster = Raster::new(1, 1, Samples::U16(vec![25_700, 25_700, 1, 2]));
        raster.multiply_light([2.0, 1.0, 1.0]);
        let Samples::U16(samples) = raster.samples() else { unreachable!() };
        assert!(samples[0].abs_diff(138 * 257) < 257 && samples[1..] == [25_700, 1, 2], "{samples:?}");
    }

    #[test]
    fn a_crop_holds_the_pixels_of_its_place() {
        let whole = raster(5, 4, &[(2, 1, [1, 2, 3, 4]), (3, 2, [5, 6, 7, 8])]);
        let part = whole.cropped(PixelRect { x: 2, y: 1, w: 2, h: 2 });
        assert_eq!(part, raster(2, 2, &[(0, 0, [1, 2, 3, 4]), (1, 1, [5, 6, 7, 8])]));
    }

    #[test]
    fn the_hash_ignores_how_much_emptiness_surrounds_the_layer() {
        let wide = raster(6, 5, &[(2, 1, [9, 8, 7, 255]), (4, 3, [1, 1, 1, 3]), (0, 0, [50, 60, 70, 0])]);
        let tight = raster(3, 3, &[(0, 0, [9, 8, 7, 255]), (2, 2, [1, 1, 1, 3])]);
        assert_eq!(wide.hash_at(-2, 10), tight.hash_at(0, 11));
        assert_ne!(wide.hash_at(-2, 10), tight.hash_at(0, 10), "moved");
    }

    #[test]
    fn an_empty_raster_has_one_hash_at_every_position() {
        assert_eq!(raster(6, 5, &[]).hash_at(40, -3), raster(1, 1, &[(0, 0, [9, 9, 9, 0])]).hash_at(0, 0));
    }

    #[test]
    fn the_hash_sees_one_changed_sample_and_one_changed_alpha() {
        let plain = raster(2, 1, &[(0, 0, [9, 8, 7, 255])]);
        assert_ne!(plain.hash_at(0, 0), raster(2, 1, &[(0, 0, [9, 9, 7, 255])]).hash_at(0, 0));
        assert_ne!(plain.hash_at(0, 0), raster(2, 1, &[(0, 0, [9, 8, 7, 254])]).hash_at(0, 0));
    }

    #[test]
    fn on_white_leaves_opaque_pixels_and_fills_the_clear_ones() {
        let white = raster(3, 1, &[(0, 0, [10, 20, 30, 255]), (1, 0, [0, 0, 0, 128])]).on_white();
        let expected = [(0, 0, [10, 20, 30, 255]), (1, 0, [127, 127, 127, 255]), (2, 0, [255; 4])];
        assert_eq!(white, raster(3, 1, &expected));
    }

    #[test]
    fn a_photo_without_alpha_is_opaque() {
        let samples = Samples::U16(vec![1, 2, 3, 4, 5, 6]);
        let photo = PhotoPixels { width: 1, height: 2, channels: 3, samples, icc: None };
        let expected = Samples::U16(vec![1, 2, 3, 65535, 4, 5, 6, 65535]);
        assert_eq!(Raster::of_photo(photo).samples(), &expected);
    }

    #[test]
    fn a_thumbnail_is_made_of_means_and_keeps_the_proportions() {
        let pixels = [(0, 0, [0, 0, 0, 255]), (1, 0, [100, 50, 3, 255]), (2, 0, [7, 8, 9, 255])];
        let expected = [(0, 0, [50, 25, 2, 255]), (1, 0, [7, 8, 9, 255])];
        assert_eq!(raster(3, 1, &pixels).thumbnail(2), raster(2, 1, &expected));
    }

    #[test]
    fn every_sample_of_8_bits_survives_16_bits_and_16_bits_are_rounded() {
        let all = Raster::new(64, 1, Samples::U8((0..=255).collect()));
        assert_eq!(all.clone().in_depth(Depth::Sixteen).in_depth(Depth::Eight), all);
        assert_eq!([0, 128, 129, 257 + 128, 65535].map(in_8_bits), [0, 0, 1, 1, 255]);
        let mut one = Raster::blank(1, 1, Depth::Eight);
        one.set_rgba16(0, 0, [257, 129, 65535, 600]);
        assert_eq!(one.rgba16(0, 0), [257, 257, 65535, 514]);
    }

    #[test]
    fn an_empty_raster_has_no_coloured_rectangle() {
        assert!(Raster::blank(4, 4, Depth::Sixteen).coloured_rect().is_empty());
        assert!(Raster::blank(0, 0, Depth::Eight).coloured_rect().is_empty());
    }
}
