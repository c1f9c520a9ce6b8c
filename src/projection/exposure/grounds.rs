//! The support of the photos' gains: how much each photo has in common with others, and how well the
//! comparisons agree.

use serde::{Deserialize, Serialize};

use super::{PatchColour, Ratio, SharedPoint};

/// The support of one photo's gain.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Grounds {
    /// The number of surface points that this and another photo show, both with usable colours.
    pub points: u32,
    /// Median, over the photo's comparisons and R, G and B, of the absolute log ratio that remains after the
    /// gains are removed; 0 without comparisons.
    pub residual: f64,
}

/// Computes the support of each photo's gain. `gains` are those estimated from `ratios`.
pub fn grounds(
    photos: usize,
    points: &[SharedPoint],
    colours: &[Vec<PatchColour>],
    ratios: &[Ratio],
    gains: &[[f64; 3]],
) -> Vec<Grounds> {
    let mut shared = vec![0; photos];
    for (point, colours) in points.iter().zip(colours) {
        let usable = || point.patches.iter().zip(colours).filter(|(_, c)| c.is_some_and(|c| c.usable));
        if usable().count() >= 2 {
            usable().for_each(|(patch, _)| shared[patch.photo.0 as usize] += 1);
        }
    }
    let mut left: Vec<Vec<f64>> = vec![Vec::new(); photos];
    for ratio in ratios {
        let [a, b] = [ratio.a, ratio.b].map(|photo| photo.0 as usize);
        let of_channel = |c: usize| (f64::from(ratio.log[c]) - (gains[a][c] - gains[b][c])).abs();
        let residuals = [0, 1, 2].map(of_channel);
        left[a].extend(residuals);
        left[b].extend(residuals);
    }
    let of_photo = |(points, left)| Grounds { points, residual: median(left) };
    shared.into_iter().zip(left).map(of_photo).collect()
}

/// Returns the median; 0 for no values.
fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
