//! Metrics of the similarity of two images: PSNR, PSNR after a colour fit, and SSIM, over counted pixels
//! only.

mod colour_fit;
mod structure;
mod tally;

use serde::Serialize;

pub use structure::structural_similarity;
pub use tally::ErrorSum;

use colour_fit::PairSums;

/// The PSNR of identical images in dB, and the maximum reported: 8 bits cannot distinguish better ones.
pub const HIGHEST_DB: f64 = 100.0;

/// A predicted image and its ground truth. Both have `width * height * 3` bytes, rows from the top, RGB of 8
/// bits in gamma (sRGB).
#[derive(Debug, Clone, Copy)]
pub struct ImagePair<'a> {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The ground truth: a photo.
    pub truth: &'a [u8],
    /// The image to judge.
    pub predicted: &'a [u8],
}

/// The metrics of an image against its ground truth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ImageMetrics {
    /// The number of pixels that were counted.
    pub pixels: u64,
    /// Peak signal-to-noise ratio in dB: `10 log10(255^2 / mean squared error)` over all channels.
    pub psnr: f64,
    /// The PSNR in dB after the best gain and offset per channel.
    pub psnr_fitted: f64,
    /// Structural similarity, usually in 0..1 ([`structural_similarity`]); `None` where no window of 7 x 7
    /// pixels is completely counted.
    pub ssim: Option<f64>,
}

impl ImageMetrics {
    /// Computes the metrics over the pixels that are `counted`. The gain and offset of the fitted PSNR are
    /// estimated on those counted pixels that are `fitted`, and applied to these alone, so that black that
    /// stands for a hole remains black. Both lists have `width * height` items. Returns `None` where no pixel
    /// is counted.
    pub fn new(compared: &ImagePair, counted: &[bool], fitted: &[bool]) -> Option<Self> {
        let (mut sums, mut rest) = ([PairSums::default(); 3], [PairSums::default(); 3]);
        for (i, _) in counted.iter().enumerate().filter(|(_, counted)| **counted) {
            let into = if fitted[i] { &mut sums } else { &mut rest };
            for (channel, sum) in into.iter_mut().enumerate() {
                sum.add(compared.predicted[3 * i + channel], compared.truth[3 * i + channel]);
            }
        }
        let samples: u64 = sums.iter().chain(&rest).map(PairSums::count).sum();
        let left: f64 = rest.iter().map(PairSums::squared_error).sum();
        let before: f64 = sums.iter().map(PairSums::squared_error).sum();
        let after: f64 = sums.iter().map(PairSums::fitted_squared_error).sum();
        (samples > 0).then(|| Self {
            pixels: samples / 3,
            psnr: psnr(before + left, samples),
            psnr_fitted: psnr(after + left, samples),
            ssim: structural_similarity(compared, counted),
        })
    }
}

/// Computes the PSNR in dB of 8-bit samples whose squared differences add up to `squared_error`; at most
/// [`HIGHEST_DB`].
pub fn psnr(squared_error: f64, samples: u64) -> f64 {
    let mean = squared_error / samples as f64;
    (10.0 * (255.0 * 255.0 / mean).log10()).min(HIGHEST_DB)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn compared<'a>(truth: &'a [u8], predicted: &'a [u8]) -> ImagePair<'a> {
        ImagePair { width: (truth.len() / 3) as u32, height: 1, truth, predicted }
    }

    #[test]
    fn an_error_of_one_shade_everywhere_is_48_db_and_none_is_the_highest() {
        let (truth, predicted) = ([10u8; 12], [11u8; 12]);
        let all = [true; 4];
        let one = ImageMetrics::new(&compared(&truth, &predicted), &all, &all).unwrap();
        assert!((one.psnr - 20.0 * 255f64.log10()).abs() < 1e-12);
        let none = ImageMetrics::new(&compared(&truth, &truth), &all, &all).unwrap();
        assert_eq!((none.psnr, none.pixels, none.ssim), (HIGHEST_DB, 4, None));
    }

    #[test]
    fn only_counted_pixels_count() {
        let truth = [0, 0, 0, 200, 200, 200];
        let predicted = [0, 0, 0, 0, 0, 0];
        let first = [true, false];
        let metrics = ImageMetrics::new(&compared(&truth, &predicted), &first, &first).unwrap();
        assert_eq!((metrics.psnr, metrics.pixels), (HIGHEST_DB, 1));
        assert_eq!(ImageMetrics::new(&compared(&truth, &predicted), &[false; 2], &first), None);
    }

    #[test]
    fn a_gain_and_an_offset_per_channel_are_fitted_and_holes_stay_black() {
        // Truth = 2 p + 3 in red, p / 2 in green, 9 in blue; the last pixel is a hole.
        let predicted = [10, 40, 7, 20, 80, 8, 30, 20, 7, 0, 0, 0];
        let truth = [23, 20, 9, 43, 40, 9, 63, 10, 9, 6, 6, 6];
        let covered = [true, true, true, false];
        let covered_only = ImageMetrics::new(&compared(&truth, &predicted), &covered, &covered).unwrap();
        assert_eq!(covered_only.psnr_fitted, HIGHEST_DB);
        let with_hole = ImageMetrics::new(&compared(&truth, &predicted), &[true; 4], &covered).unwrap();
        assert!((with_hole.psnr_fitted - psnr(3.0 * 36.0, 12)).abs() < 1e-9, "{with_hole:?}");
    }
}
