//! How like two pictures of a plant are: structure, coverage and light.

use serde::Serialize;

use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::light::{linear_of_srgb, srgb_from_linear};
use quadratura_view::Picture;
use quadratura_view::metrics::{ImagePair, structural_similarity};

/// A picture of a plant beside the truth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PictureSimilarity {
    /// Structural similarity over a plain sky, in gamma, over the windows that the plant's rectangle holds.
    pub ssim: f64,
    /// The covered area, over that of the truth.
    pub coverage: f64,
    /// The mean light of what is covered, over that of the truth.
    pub light: f64,
    /// Covered pixels of the truth.
    pub covered_px: f64,
    /// Rows from the first to the last covered pixel of the truth.
    pub height_px: u32,
}

/// What both pictures are laid over, in sRGB: pictures of plants are empty beside them.
const SKY: [f64; 3] = [0.58, 0.70, 0.86];

/// Windows of structural similarity have seven pixels a side: three more on each side of the plant see its outline from both sides.
const AROUND: i32 = 3;

/// Compares a picture with the truth, of the same size. `None` where the truth shows nothing.
pub fn similarity(truth: &Picture, picture: &Picture) -> Option<PictureSimilarity> {
    let rect = covered_rect(truth)?;
    let (wanted, found) = (Sums::of(truth), Sums::of(picture));
    let whole = PixelRect::of_size(truth.width, truth.height);
    let counted: Vec<bool> = whole
        .pixels()
        .map(|(x, y)| {
            let inside = |at: i32, low: i32, high: i32| at >= low - AROUND && at < high + AROUND;
            inside(x, rect.x, rect.right()) && inside(y, rect.y, rect.bottom())
        })
        .collect();
    let (of_truth, of_picture) = (over_sky(truth), over_sky(picture));
    let pair =
        ImagePair { width: truth.width, height: truth.height, truth: &of_truth, predicted: &of_picture };
    Some(PictureSimilarity {
        ssim: structural_similarity(&pair, &counted)?,
        coverage: found.covered / wanted.covered,
        light: (found.light / found.covered.max(f64::MIN_POSITIVE)) / (wanted.light / wanted.covered),
        covered_px: wanted.covered,
        height_px: rect.h,
    })
}

/// Returns the rectangle of all pixels that are covered.
fn covered_rect(picture: &Picture) -> Option<PixelRect> {
    let whole = PixelRect::of_size(picture.width, picture.height);
    let covered = whole.pixels().zip(picture.pixels()).filter(|(_, pixel)| pixel[3] > 0).map(|(at, _)| at);
    let bounds = covered.fold(None, |bounds: Option<[i32; 4]>, (x, y)| {
        let [x0, y0, x1, y1] = bounds.unwrap_or([x, y, x, y]);
        Some([x0.min(x), y0.min(y), x1.max(x), y1.max(y)])
    });
    bounds.map(|[x0, y0, x1, y1]| PixelRect::from_edges(x0, y0, x1 + 1, y1 + 1))
}

/// Sums over a picture.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    /// Covered pixels.
    covered: f64,
    /// Their light: the mean of R, G and B, linear.
    light: f64,
}

impl Sums {
    fn of(picture: &Picture) -> Self {
        let mut sums = Self::default();
        for [r, g, b, alpha] in picture.pixels() {
            let alpha = f64::from(*alpha) / 255.0;
            let light: f64 = [r, g, b].map(|byte| linear_of_srgb(f64::from(*byte) / 255.0)).iter().sum();
            sums.covered += alpha;
            sums.light += alpha * light / 3.0;
        }
        sums
    }
}

/// Lays a picture over the sky, in linear light; returns R, G, B.
pub(super) fn over_sky(picture: &Picture) -> Vec<u8> {
    let over = |pixel: &[u8; 4]| {
        let alpha = f64::from(pixel[3]) / 255.0;
        std::array::from_fn::<u8, 3, _>(|channel| {
            let front = linear_of_srgb(f64::from(pixel[channel]) / 255.0);
            let light = alpha * front + (1.0 - alpha) * linear_of_srgb(SKY[channel]);
            (255.0 * srgb_from_linear(light)).round() as u8
        })
    };
    picture.pixels().iter().flat_map(over).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(pixel: impl Fn(u32, u32) -> [u8; 4]) -> Picture {
        let rgba = (0..400).flat_map(|at| pixel(at % 20, at / 20)).collect();
        Picture { width: 20, height: 20, rgba }
    }

    fn square(side: u32, byte: u8) -> Picture {
        let inside = |at: u32| (5..5 + side).contains(&at);
        picture(|x, y| if inside(x) && inside(y) { [byte, byte, byte, 255] } else { [0; 4] })
    }

    #[test]
    fn a_picture_is_like_itself_and_nothing_is_like_an_empty_one() {
        let truth = square(8, 100);
        let same = similarity(&truth, &truth).unwrap();
        assert_eq!((same.coverage, same.light, same.height_px), (1.0, 1.0, 8));
        assert!((same.ssim - 1.0).abs() < 1e-12);
        assert_eq!(similarity(&picture(|_, _| [0; 4]), &truth), None);
    }

    #[test]
    fn coverage_and_light_are_ratios_to_the_truth() {
        let truth = square(8, 100);
        let larger = similarity(&truth, &square(10, 100)).unwrap();
        assert!((larger.coverage - 100.0 / 64.0).abs() < 1e-12 && (larger.light - 1.0).abs() < 1e-12);
        let brighter = similarity(&truth, &square(8, 140)).unwrap();
        let ratio = linear_of_srgb(140.0 / 255.0) / linear_of_srgb(100.0 / 255.0);
        assert!((brighter.light - ratio).abs() < 1e-12 && brighter.coverage == 1.0);
        assert!(larger.ssim < 0.99 && brighter.ssim < 0.999);
    }
}
