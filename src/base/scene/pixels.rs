//! The pixels of a photo, as stored in its file.

use std::borrow::Cow;

use crate::geometry::{PixelRect, Spans};
use crate::raster::sample::with_alpha;

/// Samples in row order, top to bottom, with interleaved channels, in the full range of their type.
#[derive(Debug, Clone, PartialEq)]
pub enum Samples {
    /// Samples of 8 bits per channel.
    U8(Vec<u8>),
    /// Samples of 16 bits per channel.
    U16(Vec<u16>),
}

impl Samples {
    /// Returns the number of samples.
    pub fn len(&self) -> usize {
        match self {
            Self::U8(samples) => samples.len(),
            Self::U16(samples) => samples.len(),
        }
    }

    /// Returns the bits of a sample: 8 or 16.
    pub fn bits(&self) -> u8 {
        match self {
            Self::U8(_) => 8,
            Self::U16(_) => 16,
        }
    }

    /// Returns the samples as PNG stores them: of 16 bits the higher byte first.
    pub fn big_endian(&self) -> Cow<'_, [u8]> {
        match self {
            Self::U8(samples) => Cow::Borrowed(samples),
            Self::U16(samples) => samples.iter().flat_map(|sample| sample.to_be_bytes()).collect(),
        }
    }

    /// Returns true when there are no samples.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The pixels of a photo: RGB or RGBA in the photo's own colour space, never converted. Alpha is not premultiplied;
/// a pixel is valid where it is full.
#[derive(Debug, Clone, PartialEq)]
pub struct PhotoPixels {
    /// The width in pixels.
    pub width: u32,
    /// The height in pixels.
    pub height: u32,
    /// The number of channels: 3 (RGB) or 4 (RGBA).
    pub channels: usize,
    /// The samples, `height * width * channels` of them.
    pub samples: Samples,
    /// The ICC profile of the colours; none means sRGB.
    pub icc: Option<Vec<u8>>,
}

impl PhotoPixels {
    /// Returns the bits per sample: 8 or 16.
    pub fn bits(&self) -> u8 {
        self.samples.bits()
    }

    /// Returns true when there is alpha, so that some pixels may be invalid.
    pub fn has_alpha(&self) -> bool {
        self.channels == 4
    }

    /// Returns the rectangle of the whole photo.
    pub fn rect(&self) -> PixelRect {
        PixelRect::of_size(self.width, self.height)
    }

    /// Returns the index of the pixel in column `x` and row `y`, in row order.
    pub fn index(&self, x: u32, y: u32) -> usize {
        debug_assert!(x < self.width && y < self.height);
        y as usize * self.width as usize + x as usize
    }

    /// Returns true when the photo is valid at this pixel.
    pub fn is_valid(&self, x: u32, y: u32) -> bool {
        let alpha = self.index(x, y) * self.channels + 3;
        match &self.samples {
            _ if !self.has_alpha() => true,
            Samples::U8(samples) => samples[alpha] == u8::MAX,
            Samples::U16(samples) => samples[alpha] == u16::MAX,
        }
    }

    /// Returns the same pixels, with those in `masked` marked invalid; their colours stay.
    pub fn without(self, masked: &Spans) -> Self {
        if masked.is_empty() {
            return self;
        }
        let samples = match self.samples {
            samples if self.channels == 4 => samples,
            Samples::U8(samples) => Samples::U8(with_alpha(&samples)),
            Samples::U16(samples) => Samples::U16(with_alpha(&samples)),
        };
        let mut pixels = Self { samples, channels: 4, ..self };
        let (width, height) = (pixels.width as i32, pixels.height as i32);
        for (y, run) in masked.iter().filter(|(y, _)| (0..height).contains(y)) {
            for x in run.start.clamp(0, width)..run.end.clamp(0, width) {
                let alpha = pixels.index(x as u32, y as u32) * 4 + 3;
                match &mut pixels.samples {
                    Samples::U8(samples) => samples[alpha] = 0,
                    Samples::U16(samples) => samples[alpha] = 0,
                }
            }
        }
        pixels
    }

    /// Returns R, G, B, A in 16 bits; 8-bit samples are scaled to the full range, missing alpha is full.
    pub fn rgba16(&self, x: u32, y: u32) -> [u16; 4] {
        let at = self.index(x, y) * self.channels;
        let mut pixel = [u16::MAX; 4];
        for (channel, value) in pixel[..self.channels].iter_mut().enumerate() {
            *value = match &self.samples {
                Samples::U8(samples) => u16::from(samples[at + channel]) * 257,
                Samples::U16(samples) => samples[at + channel],
            };
        }
        pixel
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_masked_is_not_valid_and_all_else_stays_as_it_was() {
        let masked = Spans::from_rows(-1..2, |_, out| out.push(1..9));
        for samples in [Samples::U8(vec![7; 18]), Samples::U16(vec![7; 18])] {
            let whole = PhotoPixels { width: 3, height: 2, channels: 3, samples, icc: None };
            let part = whole.clone().without(&masked);
            for (x, y) in [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)] {
                assert_eq!(part.is_valid(x, y), x == 0);
                assert_eq!(part.rgba16(x, y)[..3], whole.rgba16(x, y)[..3]);
            }
            assert_eq!(whole.clone().without(&Spans::default()), whole);
        }
    }

    #[test]
    fn a_pixel_is_valid_where_its_alpha_is_full() {
        let samples = Samples::U8(vec![1, 2, 3, 255, 4, 5, 6, 254]);
        let pixels = PhotoPixels { width: 2, height: 1, channels: 4, samples, icc: None };
        assert!(pixels.is_valid(0, 0) && !pixels.is_valid(1, 0));
        assert_eq!(pixels.rgba16(1, 0), [4 * 257, 5 * 257, 6 * 257, 254 * 257]);
    }

    #[test]
    fn a_photo_without_alpha_is_valid_everywhere() {
        let samples = Samples::U16(vec![7, 8, 9]);
        let pixels = PhotoPixels { width: 1, height: 1, channels: 3, samples, icc: None };
        assert!(pixels.is_valid(0, 0));
        assert_eq!(pixels.rgba16(0, 0), [7, 8, 9, 65535]);
    }
}
