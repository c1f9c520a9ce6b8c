//! The support of the photos' gains: how much each photo has in common with others, and how well the
//! comparisons agree.

use serde::{Deserialize, Serialize};

use super::patch::PatchColour;
use super::points::SharedPoint;
use super::ratios::Ratio;
use quadratura_base::raster::robust::upper_median;

/// The support of one photo's gain.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct GainSupport {
    /// The number of surface points that this and another photo show, both with usable colours.
    pub points: u32,
    /// Median, over the photo's comparisons and R, G and B, of the absolute log ratio that remains after the
    /// gains are removed; 0 without comparisons.
    pub residual: f64,
}

/// Computes the support of each photo's gain. `gains` are those estimated from `ratios`.
pub fn gain_support(
    photo_count: usize,
    points: &[SharedPoint],
    colours: &[Vec<PatchColour>],
    ratios: &[Ratio],
    gains: &[[f64; 3]],
) -> Vec<GainSupport> {
    let mut shared = vec![0; photo_count];
    for (point, colours) in points.iter().zip(colours) {
        let usable = || point.patches.iter().zip(colours).filter(|(_, c)| c.is_some_and(|c| c.usable));
        if usable().count() >= 2 {
            usable().for_each(|(patch, _)| shared[patch.photo.index()] += 1);
        }
    }
    let mut left: Vec<Vec<f64>> = vec![Vec::new(); photo_count];
    for ratio in ratios {
        let [a, b] = [ratio.a, ratio.b].map(|photo| photo.index());
        let of_channel = |c: usize| (f64::from(ratio.log[c]) - (gains[a][c] - gains[b][c])).abs();
        let residuals = [0, 1, 2].map(of_channel);
        left[a].extend(residuals);
        left[b].extend(residuals);
    }
    let residual = |left: &mut [f64]| upper_median(left).unwrap_or(0.0);
    let of_photo = |(points, mut left): (_, Vec<f64>)| GainSupport { points, residual: residual(&mut left) };
    shared.into_iter().zip(left).map(of_photo).collect()
}
