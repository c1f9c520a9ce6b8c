//! Thumbnails of photos for lists.

use std::path::Path;

use quadratura_base::error::Result;
use quadratura_base::raster::in_8_bits;
use quadratura_base::scene::{Photo, PhotoPixels};
use quadratura_import::photo::{picture_size, read_photo};
use quadratura_io::thumbnails::{ThumbnailStamp, Thumbnails};
use quadratura_view::Picture;

/// The number of pixels sampled along each side of the area of a thumbnail's pixel; more make no visible difference
/// at this size.
const SAMPLES: u32 = 4;

/// Makes a picture of `photo` whose longer side has at most `longest` pixels, in sRGB as the photo has it,
/// transparent where the photo is invalid.
///
/// # Errors
/// Returns the errors of [`read_photo`].
pub fn thumbnail(photo: &Photo, longest: u32) -> Result<Picture> {
    let pixels = read_photo(&photo.file, photo.camera.width, photo.camera.height)?;
    Ok(reduced(&pixels, longest))
}

/// Makes the same picture, or reads it from the project's cache while the photo's file is unchanged.
///
/// # Errors
/// Returns the errors of [`thumbnail`]. A picture that cannot be cached is made again the next time.
pub fn cached_thumbnail(project: &Path, photo: &Photo, longest: u32) -> Result<Picture> {
    let (kept, stamp) = (Thumbnails::new(project), ThumbnailStamp::from_photo(&photo.file, longest)?);
    if let Some(picture) = kept.kept(&photo.name, &stamp) {
        return Ok(picture);
    }
    let picture = thumbnail(photo, longest)?;
    let _ = kept.keep(&photo.name, &stamp, &picture);
    Ok(picture)
}

/// Makes a picture of any image file, with at most `longest` pixels on its longer side.
///
/// # Errors
/// Returns [`quadratura_base::Error::Input`] and [`quadratura_base::Error::Io`] when the file cannot be read.
pub fn picture_of_file(file: &Path, longest: u32) -> Result<Picture> {
    let [width, height] = picture_size(file)?;
    Ok(reduced(&read_photo(file, width, height)?, longest))
}

/// Downsamples an image so that its longer side has at most `longest` pixels.
pub(super) fn reduced(pixels: &PhotoPixels, longest: u32) -> Picture {
    let scale = (f64::from(longest) / f64::from(pixels.width.max(pixels.height))).min(1.0);
    let side = |px: u32| ((f64::from(px) * scale).round() as u32).max(1);
    let (width, height) = (side(pixels.width), side(pixels.height));
    let mut rgba = Vec::with_capacity(4 * width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            rgba.extend(mean(pixels, [x, y], [width, height]));
        }
    }
    Picture { width, height, rgba }
}

/// Returns the mean of the pixels below pixel `at` of a picture of `size`; invalid ones have no weight. The ratio is
/// any number, so this is no `raster::halving`.
fn mean(pixels: &PhotoPixels, at: [u32; 2], size: [u32; 2]) -> [u8; 4] {
    let sample = |axis: usize, full: u32, i: u32| {
        let position =
            (f64::from(at[axis]) + (f64::from(i) + 0.5) / f64::from(SAMPLES)) / f64::from(size[axis]);
        ((position * f64::from(full)) as u32).min(full - 1)
    };
    let (mut sum, mut alpha) = ([0u64; 3], 0u64);
    for j in 0..SAMPLES {
        for i in 0..SAMPLES {
            let pixel = pixels.rgba16(sample(0, pixels.width, i), sample(1, pixels.height, j));
            let weight = u64::from(pixel[3]);
            sum.iter_mut().zip(pixel).for_each(|(sum, channel)| *sum += u64::from(channel) * weight);
            alpha += weight;
        }
    }
    let eight = |mean: u64| in_8_bits(mean as u16);
    let [r, g, b] = sum.map(|sum| eight(sum.checked_div(alpha).unwrap_or(0)));
    [r, g, b, eight(alpha / u64::from(SAMPLES * SAMPLES))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::Samples;

    #[test]
    fn a_small_picture_keeps_proportion_mean_and_invalid_area() {
        // The left half is black, the right half white; the lower half is invalid.
        let (width, height) = (64u32, 32u32);
        let pixel = |x: u32, y: u32| {
            let value = if x < width / 2 { 0 } else { 255 };
            [value, value, value, if y < height / 2 { 255 } else { 0 }]
        };
        let rgba = (0..height).flat_map(|y| (0..width).flat_map(move |x| pixel(x, y))).collect();
        let pixels = photo(width, height, rgba);
        let small = reduced(&pixels, 8);
        assert_eq!((small.width, small.height), (8, 4));
        assert_eq!(small.rgba[..4], [0, 0, 0, 255]);
        assert_eq!(small.rgba[4 * 7..][..4], [255, 255, 255, 255]);
        assert_eq!(small.rgba[4 * 31 + 3], 0);
        assert_eq!(reduced(&pixels, 1000).width, 64, "never larger than the photo");
    }

    fn photo(width: u32, height: u32, rgba: Vec<u8>) -> PhotoPixels {
        PhotoPixels { width, height, channels: 4, samples: Samples::U8(rgba), icc: None }
    }
}
