//! Rotates a photo by its EXIF orientation.

use image::metadata::Orientation;

use quadratura_base::scene::Samples;

/// Returns whether the orientation exchanges width and height.
pub(super) fn swaps_sides(orientation: Orientation) -> bool {
    use Orientation::{Rotate90, Rotate90FlipH, Rotate270, Rotate270FlipH};
    matches!(orientation, Rotate90 | Rotate270 | Rotate90FlipH | Rotate270FlipH)
}

/// Rotates the samples of a `width` x `height` photo by an orientation that exchanges width and height; all
/// others leave it as stored.
pub(super) fn turned(
    samples: Samples,
    width: u32,
    height: u32,
    channels: usize,
    orientation: Orientation,
) -> Samples {
    if !swaps_sides(orientation) {
        return samples;
    }
    let size = (width as usize, height as usize);
    match samples {
        Samples::U8(samples) => Samples::U8(turn(&samples, size, channels, orientation)),
        Samples::U16(samples) => Samples::U16(turn(&samples, size, channels, orientation)),
    }
}

fn turn<T: Copy>(
    samples: &[T],
    (width, height): (usize, usize),
    channels: usize,
    orientation: Orientation,
) -> Vec<T> {
    let mut turned = Vec::with_capacity(samples.len());
    for row in 0..width {
        for column in 0..height {
            let (x, y) = match orientation {
                Orientation::Rotate90 => (row, height - 1 - column),
                Orientation::Rotate270 => (width - 1 - row, column),
                Orientation::Rotate270FlipH => (width - 1 - row, height - 1 - column),
                _ => (row, column),
            };
            let at = (y * width + x) * channels;
            turned.extend_from_slice(&samples[at..at + channels]);
        }
    }
    turned
}

#[cfg(test)]
mod tests {
    use image::{DynamicImage, RgbImage};

    use super::*;

    #[test]
    fn every_orientation_turns_as_the_image_crate_does() {
        let image = RgbImage::from_fn(5, 3, |x, y| image::Rgb([x as u8, y as u8, 7]));
        for tag in 1..=8 {
            let orientation = Orientation::from_exif(tag).unwrap();
            let mut expected = DynamicImage::from(image.clone());
            expected.apply_orientation(orientation);
            if swaps_sides(orientation) {
                let samples = Samples::U8(image.as_raw().clone());
                let Samples::U8(turned) = turned(samples, 5, 3, 3, orientation) else { panic!() };
                assert_eq!((expected.width(), expected.as_bytes()), (3, turned.as_slice()), "{tag}");
            } else {
                assert_eq!(expected.width(), 5, "{tag}");
            }
        }
    }
}
