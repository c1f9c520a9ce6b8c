//! The mean colours of patches of photos.

use glam::DVec2;

use quadratura_base::scene::PhotoPixels;
use quadratura_base::scene::light::LINEAR_FROM_BYTE;

/// The colour of a patch; `None` where the photo does not show all of it.
pub type PatchColour = Option<MeanColour>;

/// The mean colour of a patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanColour {
    /// The mean in linear light, R, G, B, full range 1.
    pub mean: [f64; 3],
    /// True when no pixel is clipped or near black, so that ratios of the colour are ratios of exposures.
    pub usable: bool,
}

/// Stored values (of 255) that are usable. Near black and white, sensors, film curves and JPEG are not
/// linear, and ratios of values are not ratios of exposures.
const USABLE: std::ops::RangeInclusive<u8> = 9..=249;

/// Averages the pixels whose centres are within `half_px` of a point (a square), in linear light. Returns
/// `None` where the square leaves the photo or has an invalid pixel.
pub fn patch_colour(pixels: &PhotoPixels, center_px: DVec2, half_px: f64) -> PatchColour {
    let from = (center_px - half_px - 0.5).ceil().as_ivec2();
    let to = (center_px + half_px - 0.5).floor().as_ivec2();
    let (width, height) = (pixels.width as i32, pixels.height as i32);
    if from.min_element() < 0 || to.x >= width || to.y >= height || to.cmplt(from).any() {
        return None;
    }
    let (mut sum, mut usable) = ([0.0; 3], true);
    for y in from.y..=to.y {
        for x in from.x..=to.x {
            let bytes = bytes_at(pixels, x as u32, y as u32)?;
            usable &= bytes.iter().all(|byte| USABLE.contains(byte));
            (0..3).for_each(|c| sum[c] += f64::from(LINEAR_FROM_BYTE[usize::from(bytes[c])]));
        }
    }
    let count = f64::from((to.x - from.x + 1) * (to.y - from.y + 1));
    Some(MeanColour { mean: sum.map(|s| s / count), usable })
}

/// Returns the values of a pixel; `None` where the photo is not valid. 16 bits are reduced to 8, which is
/// finer than the differences between patches.
fn bytes_at(pixels: &PhotoPixels, x: u32, y: u32) -> Option<[u8; 3]> {
    let [r, g, b, _] = pixels.rgba16(x, y);
    pixels.is_valid(x, y).then(|| [r, g, b].map(|sample| (sample >> 8) as u8))
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::Samples;

    /// Builds a grey photo, with one pixel of another colour.
    fn grey(alpha: u8, odd: Option<(u32, u32, u8)>) -> PhotoPixels {
        let mut samples = [188, 188, 188, alpha].repeat(16 * 16);
        if let Some((x, y, value)) = odd {
            samples[(y as usize * 16 + x as usize) * 4] = value;
        }
        PhotoPixels { width: 16, height: 16, channels: 4, samples: Samples::U8(samples), icc: None }
    }

    #[test]
    fn the_mean_is_of_light_and_not_of_bytes() {
        let middle = DVec2::splat(8.0);
        let colour = patch_colour(&grey(255, Some((5, 8, 100))), middle, 3.0).unwrap().mean;
        let [high, low] = [188, 100].map(|byte: usize| f64::from(LINEAR_FROM_BYTE[byte]));
        assert!((colour[0] - (35.0 * high + low) / 36.0).abs() < 1e-6 && (colour[1] - high).abs() < 1e-6);
        // The pixel is not in a patch one pixel further right: 5.5 is less than 9 - 3.
        let neighbour = patch_colour(&grey(255, Some((5, 8, 100))), middle + DVec2::X, 3.0).unwrap().mean;
        assert!((neighbour[0] - high).abs() < 1e-6);
    }

    #[test]
    fn clipped_and_black_pixels_make_it_unusable_invalid_and_missing_ones_none_at_all() {
        let middle = DVec2::splat(8.0);
        for (value, usable) in [(255, false), (250, false), (249, true), (9, true), (8, false), (0, false)] {
            let colour = patch_colour(&grey(255, Some((6, 6, value))), middle, 3.0);
            assert_eq!(colour.unwrap().usable, usable, "{value}");
        }
        assert_eq!(patch_colour(&grey(254, None), middle, 3.0), None);
        assert_eq!(patch_colour(&grey(255, None), DVec2::new(2.0, 8.0), 3.0), None);
        assert!(patch_colour(&grey(255, None), DVec2::new(3.0, 13.0), 3.0).is_some());
    }
}
