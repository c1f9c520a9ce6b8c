//! Images halved repeatedly, for display at small sizes.

use quadratura_base::raster::halving::{OddSide, halved};
use quadratura_view::Picture;
use quadratura_view::srgb::Srgb;

/// Halves an image repeatedly, the first half first, down to the first that fits into a square of `least_px`.
/// A pixel is the mean, in linear light and weighted by alpha, of the (at most) four that it stands for; odd
/// sides round up.
pub fn halves(picture: &Picture, least_px: u32) -> Vec<Picture> {
    let mut halves: Vec<Picture> = Vec::new();
    loop {
        let last = halves.last().unwrap_or(picture);
        if last.width.max(last.height) <= least_px.max(1) {
            return halves;
        }
        halves.push(half(last));
    }
}

fn half(picture: &Picture) -> Picture {
    let (pixels, light) = (picture.pixels(), Srgb::tables());
    let mean = |four: &[usize]| {
        let (mut sum, mut opacity) = ([0.0f32; 3], 0.0f32);
        for &at in four {
            let [r, g, b, alpha] = pixels[at];
            let alpha = f32::from(alpha);
            sum.iter_mut().zip([r, g, b]).for_each(|(sum, value)| *sum += light.linear(value) * alpha);
            opacity += alpha;
        }
        let [r, g, b] = sum.map(|sum| light.encoded(if opacity > 0.0 { sum / opacity } else { 0.0 }));
        [r, g, b, (opacity / four.len() as f32).round() as u8]
    };
    let [width, height] = [picture.width, picture.height].map(|side| side.div_ceil(2));
    let size = [picture.width as usize, picture.height as usize];
    let rgba = halved(size, OddSide::Alone, mean).into_flattened();
    Picture { width, height, rgba }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_end_at_the_least_size_and_keep_light_and_opacity() {
        // The columns are black, white, black, white, and one of alpha 0.
        let column =
            |x: usize| [[0, 0, 0, 255], [255, 255, 255, 255], [9, 9, 9, 0]][if x == 4 { 2 } else { x % 2 }];
        let rgba = (0..3).flat_map(|_| (0..5).flat_map(column)).collect();
        let halves = halves(&Picture { width: 5, height: 3, rgba }, 1);
        let sizes: Vec<_> = halves.iter().map(|half| (half.width, half.height)).collect();
        assert_eq!(sizes, [(3, 2), (2, 1), (1, 1)]);
        // Half the light is 188, not 128.
        assert_eq!(halves[0].rgba[..4], [188, 188, 188, 255]);
        assert_eq!(halves[0].rgba[8..12], [0, 0, 0, 0]);
        assert_eq!(halves[1].rgba[..4], [188, 188, 188, 255]);
        assert!(super::halves(&halves[2], 1).is_empty());
    }
}
