//! The detail of photos that can be compared between photos: luminance without its local mean and contrast,
//! at several scales.

use rayon::prelude::*;

use quadratura_base::raster::halving::OddSide;
use quadratura_base::raster::{Image, Sample};
use quadratura_base::scene::{PhotoPixels, Samples};

/// An image of luminance relative to its surroundings: `(I - mean) / (deviation + noise)` over a square. This removes
/// exposure, vignetting and haze, which change slowly over a photo, and differences of contrast between
/// photos.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Detail {
    /// In units of 1/40; [`NOTHING`] where the photo is not valid.
    values: Image<i8>,
}

/// The largest number of texels of the finest level of a photo, so that hundreds of photos fit into memory.
pub(super) const MOST_TEXELS: usize = 2 << 20;

/// Half the side of the square of surroundings, in texels, without the centre.
pub(super) const AROUND: usize = 3;

/// The deviation, relative to full range, that is attributed to noise; contrast below it is not amplified.
pub(super) const NOISE: f32 = 0.04;

/// Steps of a stored value per unit; values beyond 3.2 deviations are clipped.
pub(super) const STEPS: f32 = 40.0;

const NOTHING: i8 = i8::MIN;

impl Detail {
    /// Interpolates the value at a position in texels, the first one's centre being at (0.5, 0.5): bilinear;
    /// `None` outside of the image and next to invalid pixels. This is not `raster::bilinear`: it is the innermost loop
    /// of the sweep, has single precision, and no value at the border.
    #[inline]
    pub fn at(&self, x: f32, y: f32) -> Option<f32> {
        let ([width, height], values) = (self.values.size(), self.values.pixels());
        let (x, y) = (x - 0.5, y - 0.5);
        if !(x >= 0.0 && y >= 0.0 && x < (width - 1) as f32 && y < (height - 1) as f32) {
            return None;
        }
        let (column, row) = (x as usize, y as usize);
        let (sx, sy) = (x - column as f32, y - row as f32);
        let first = row * width + column;
        let [a, b] = [values[first], values[first + 1]];
        let [c, d] = [values[first + width], values[first + width + 1]];
        if a.min(b).min(c.min(d)) == NOTHING {
            return None;
        }
        let [a, b, c, d] = [a, b, c, d].map(f32::from);
        let (upper, lower) = (a + (b - a) * sx, c + (d - c) * sx);
        Some((upper + (lower - upper) * sy) / STEPS)
    }

    /// Returns the memory that it takes, in bytes.
    pub(super) fn bytes(&self) -> u64 {
        self.values.pixels().len() as u64
    }

    fn from_luminance(image: &Luminance) -> Self {
        let squares = image.map(|value| value * value);
        let valid = image.map(|_| 1.0);
        let [sum, squares, count] = [image, &squares, &valid].map(Luminance::box_sums);
        let texel = |i: usize| {
            let value = image.values.pixels()[i];
            if value.is_nan() {
                return NOTHING;
            }
            let mean = sum[i] / count[i];
            let deviation = (squares[i] / count[i] - mean * mean).max(0.0).sqrt();
            // The cast saturates at the upper end of the range; the lowest value is reserved for `NOTHING`.
            ((value - mean) / (deviation + NOISE) * STEPS).round().max(-127.0) as i8
        };
        let values = (0..image.values.pixels().len()).into_par_iter().map(texel).collect();
        Self { values: Image::new(image.values.rect(), values) }
    }
}

/// Computes the details of a photo: level `l` has `2^l` of its pixels per texel. Levels that are too large to
/// keep are `None`. The last level is at least [`AROUND`] texels wide.
pub fn levels(pixels: &PhotoPixels) -> Vec<Option<Detail>> {
    let mut image = Luminance::from_pixels(pixels);
    let mut levels = Vec::new();
    loop {
        let kept = image.values.pixels().len() <= MOST_TEXELS;
        levels.push(kept.then(|| Detail::from_luminance(&image)));
        if image.values.size().iter().any(|side| *side < 8 * AROUND) {
            return levels;
        }
        image = image.halved();
    }
}

/// An image of luma in the photo's own encoding, 0 to 1; NaN where the photo is not valid.
struct Luminance {
    values: Image<f32>,
}

impl Luminance {
    fn from_pixels(pixels: &PhotoPixels) -> Self {
        let [width, height] = [pixels.width as usize, pixels.height as usize];
        let mut values = vec![0.0; width * height];
        values.par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
            let from = y * width * pixels.channels;
            let range = from..from + width * pixels.channels;
            match (&pixels.samples, pixels.has_alpha()) {
                (Samples::U8(samples), false) => fill::<_, 3>(row, &samples[range]),
                (Samples::U8(samples), true) => fill::<_, 4>(row, &samples[range]),
                (Samples::U16(samples), false) => fill::<_, 3>(row, &samples[range]),
                (Samples::U16(samples), true) => fill::<_, 4>(row, &samples[range]),
            }
        });
        Self { values: Image::new(pixels.rect(), values) }
    }

    /// Halves the image: means of 2 x 2 texels, invalid unless all four are valid. A last odd row or column
    /// is dropped, so that texel positions remain halves of pixel positions.
    fn halved(&self) -> Self {
        let values = self.values.halved(OddSide::Dropped, |four| {
            let [a, b, c, d] = std::array::from_fn(|i| self.values.pixels()[four[i]]);
            0.25 * ((a + b) + (c + d))
        });
        Self { values }
    }

    fn map(&self, change: impl Fn(f32) -> f32 + Sync) -> Self {
        let change = |&value: &f32| if value.is_nan() { f32::NAN } else { change(value) };
        let values = self.values.pixels().par_iter().map(change).collect();
        Self { values: Image::new(self.values.rect(), values) }
    }

    /// Computes the sums over the square around each texel, of valid texels within the image.
    fn box_sums(&self) -> Vec<f32> {
        let ([width, height], values) = (self.values.size(), self.values.pixels());
        let mut across = vec![0.0; values.len()];
        across.par_chunks_mut(width).zip(values.par_chunks(width)).for_each(|(sums, row)| {
            let mut padded = vec![0.0; width + 2 * AROUND];
            for (to, value) in padded[AROUND..].iter_mut().zip(row) {
                *to = if value.is_nan() { 0.0 } else { *value };
            }
            // The sums grow from left to right, for all texels of the row at once.
            for shifted in padded.windows(width) {
                sums.iter_mut().zip(shifted).for_each(|(sum, value)| *sum += value);
            }
        });
        let mut sums = vec![0.0; values.len()];
        sums.par_chunks_mut(width).enumerate().for_each(|(y, sums)| {
            for row in y.saturating_sub(AROUND)..(y + AROUND + 1).min(height) {
                for (sum, across) in sums.iter_mut().zip(&across[row * width..]) {
                    *sum += across;
                }
            }
        });
        sums
    }
}

/// Converts a row to luminance.
fn fill<T: Sample, const CHANNELS: usize>(row: &mut [f32], samples: &[T]) {
    for (value, pixel) in row.iter_mut().zip(samples.as_chunks::<CHANNELS>().0) {
        let [r, g, b] = [pixel[0], pixel[1], pixel[2]].map(|sample| f32::from(sample.in_16_bits()));
        // Rec. 601 weights.
        let luma = (0.299 * r + 0.587 * g + 0.114 * b) / 65535.0;
        *value = if pixel.get(3).is_none_or(|alpha| *alpha == T::FULL) { luma } else { f32::NAN };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    fn noise(gain: f64, alpha: impl Fn(usize) -> u8) -> PhotoPixels {
        let mut rng = Rng::new(5);
        let samples = (0..64 * 48).flat_map(|i| {
            let value = (rng.between(40.0, 120.0) * gain) as u8;
            [value, value, value, alpha(i)]
        });
        let samples = Samples::U8(samples.collect());
        PhotoPixels { width: 64, height: 48, channels: 4, samples, icc: None }
    }

    #[test]
    fn a_brighter_photo_has_the_same_detail() {
        let [dark, bright] = [1.0, 2.0].map(|gain| levels(&noise(gain, |_| 255)));
        let (dark, bright) = (dark[0].as_ref().unwrap(), bright[0].as_ref().unwrap());
        for (x, y) in [(5.3, 7.7), (30.0, 20.5), (60.1, 40.2)] {
            let [a, b] = [dark, bright].map(|detail| detail.at(x, y).unwrap());
            // The assumed noise weighs half as much in the brighter photo: deviations of 0.09 and 0.18.
            assert!((a - b).abs() <= 0.35 * a.abs().max(0.1), "{a} {b}");
        }
    }

    #[test]
    fn what_is_not_valid_has_no_detail_and_leaves_that_of_others_alone() {
        let half = levels(&noise(1.0, |i| if i % 64 < 32 { 0 } else { 255 }));
        let half = half[0].as_ref().unwrap();
        assert_eq!(half.at(20.0, 20.0), None);
        assert_eq!(half.at(32.0, 20.0), None, "next to it");
        let whole = levels(&noise(1.0, |_| 255));
        assert_eq!(half.at(40.5, 20.5), whole[0].as_ref().unwrap().at(40.5, 20.5));
    }

    #[test]
    fn levels_halve_until_they_are_small() {
        let sizes: Vec<_> = levels(&noise(1.0, |_| 255)).iter().flatten().map(|d| d.values.size()).collect();
        assert_eq!(sizes, [[64, 48], [32, 24], [16, 12]]);
    }
}
