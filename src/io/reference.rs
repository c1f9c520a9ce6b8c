//! Reduces a photo to the size of the picture that is compared with it.

use image::imageops::{FilterType, resize};
use image::{ImageBuffer, Luma, Rgb};

use quadratura_base::raster::in_8_bits;
use quadratura_base::scene::{PhotoPixels, Samples};

/// A photo at the size of a picture: the expected result, 8 bits, gamma-encoded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reference {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// RGB, `width * height * 3` samples, rows from the top.
    pub rgb: Vec<u8>,
    /// For each pixel, whether all photo pixels that contribute to it are valid.
    pub valid: Vec<bool>,
}

/// The value of a valid pixel in the mask: half the range, so that overshoot is visible, too.
const VALID: u16 = 1 << 15;

/// Resamples `photo` to `width` x `height` pixels with a Lanczos filter of three lobes, widened when
/// reducing, on the gamma-encoded samples. A photo of that size is returned bit for bit.
pub fn reference(photo: &PhotoPixels, width: u32, height: u32) -> Reference {
    let rgb = match &photo.samples {
        Samples::U8(samples) => resized::<u8>(photo, samples, width, height),
        Samples::U16(samples) => {
            resized::<u16>(photo, samples, width, height).into_iter().map(in_8_bits).collect()
        }
    };
    Reference { width, height, rgb, valid: valid(photo, width, height) }
}

fn resized<T>(photo: &PhotoPixels, samples: &[T], width: u32, height: u32) -> Vec<T>
where
    T: image::Primitive + Send + Sync + 'static,
    Rgb<T>: image::Pixel<Subpixel = T> + 'static,
{
    let rgb = samples.chunks_exact(photo.channels).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    if (photo.width, photo.height) == (width, height) {
        return rgb;
    }
    let picture: ImageBuffer<Rgb<T>, Vec<T>> =
        ImageBuffer::from_raw(photo.width, photo.height, rgb).expect("three samples a pixel were taken");
    resize(&picture, width, height, FilterType::Lanczos3).into_raw()
}

fn valid(photo: &PhotoPixels, width: u32, height: u32) -> Vec<bool> {
    if !photo.has_alpha() {
        return vec![true; width as usize * height as usize];
    }
    let mask = ImageBuffer::from_fn(photo.width, photo.height, |x, y| {
        Luma([if photo.is_valid(x, y) { VALID } else { 0 }])
    });
    let small = resize(&mask, width, height, FilterType::Lanczos3).into_raw();
    // One invalid pixel changes the sum by its weight; less than a thousandth is not visible in 8 bits.
    small.into_iter().map(|v| v.abs_diff(VALID) <= VALID / 1000).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn photo(width: u32, height: u32, channels: usize, sample: impl Fn(u32, u32) -> u8) -> PhotoPixels {
        let mut samples = Vec::new();
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            samples.extend([sample(x, y); 3]);
            // The left column is not valid.
            samples.extend((channels == 4).then_some(if x == 0 { 0 } else { 255 }));
        }
        PhotoPixels { width, height, channels, samples: Samples::U8(samples), icc: None }
    }

    #[test]
    fn at_its_own_size_it_is_the_photo() {
        let photo = photo(5, 4, 3, |x, y| (x * 10 + y) as u8);
        let Samples::U8(samples) = &photo.samples else { unreachable!() };
        let reference = reference(&photo, 5, 4);
        assert_eq!(&reference.rgb, samples);
        assert!(reference.valid.iter().all(|valid| *valid));
    }

    #[test]
    fn at_half_the_size_each_pixel_is_around_the_middle_of_four() {
        // A ramp of slope 4: between pixel 2i and 2i + 1 it is 8 i + 2.
        let photo = photo(40, 8, 3, |x, _| (x * 4) as u8);
        let half = reference(&photo, 20, 4);
        for x in 3..17 {
            let found = half.rgb[3 * (20 + x)];
            assert!(found.abs_diff((8 * x + 2) as u8) <= 1, "{x}: {found}");
        }
    }

    #[test]
    fn a_pixel_with_an_invalid_contribution_is_not_valid() {
        let half = reference(&photo(40, 8, 4, |_, _| 9), 20, 4);
        let row = &half.valid[20..40];
        assert!(!row[0] && !row[1] && row[3..].iter().all(|valid| *valid), "{row:?}");
        let own = reference(&photo(40, 8, 4, |_, _| 9), 40, 8);
        assert_eq!(own.valid[..3], [false, true, true]);
    }

    #[test]
    fn sixteen_bits_become_the_nearest_of_eight() {
        let samples = Samples::U16(vec![0, 128, 129, 65535, 65407, 65406]);
        let photo = PhotoPixels { width: 2, height: 1, channels: 3, samples, icc: None };
        assert_eq!(reference(&photo, 2, 1).rgb, [0, 0, 1, 255, 255, 254]);
    }
}
