//! Whether photos agree about what is at a depth: zero-mean normalised cross-correlation of small windows, warped by the
//! depth of each pixel (Collins, *A Space-Sweep Approach to True Multi-Image Matching*, 1996).

use super::support::middle;
use super::view::{Greys, PlaneDepth, Warp, WorkingPhoto};

/// Columns and rows on each side of a pixel's window of 7 x 7.
const WINDOW: usize = 3;

/// Photos with which one is compared.
pub const NEIGHBOURS: usize = 4;

/// The variance, in squared greys, at which a window tells half of what a textured one does.
const PLAIN: f32 = 12.0;

/// The cost of a pixel where photos say nothing.
pub const NEUTRAL: f32 = 0.4;

/// Greys are compared as multiples of this about the middle one, so that sums keep their digits.
const SCALE: f32 = 64.0;

/// The variance of noise, in squared multiples of [`SCALE`].
const NOISE: f32 = 1.0 / (SCALE * SCALE);

/// A photo with others that are warped to it.
pub struct Comparer<'a> {
    size: [usize; 2],
    own: Vec<f32>,
    mean: Vec<f32>,
    deviation: Vec<f32>,
    /// How much a window tells, 0 for a plain one to 1.
    pub texture: Vec<f32>,
    others: Vec<(&'a Greys, Warp)>,
}

/// A rectangle of pixels: the first column and row, and those after the last.
#[derive(Debug, Clone, Copy)]
pub struct PixelBounds {
    /// First column and row.
    pub low: [usize; 2],
    /// The column and row after the last.
    pub high: [usize; 2],
}

impl<'a> Comparer<'a> {
    /// Prepares a photo for comparison with its neighbours, of which the first are used, at the working size.
    pub fn new(views: &'a [WorkingPhoto], of: usize, neighbours: &[u32], count: usize) -> Self {
        let view = &views[of];
        let others = neighbours.iter().take(count).map(|i| &views[*i as usize]);
        let warp = |other: &'a WorkingPhoto| {
            let warp = Warp::new((view.camera(), &view.pose), (other.camera(), &other.pose));
            (&other.greys, warp)
        };
        let size = view.size();
        let own: Vec<f32> = view.greys.values.iter().map(|grey| (grey - 128.0) / SCALE).collect();
        let squares: Vec<f32> = own.iter().map(|value| value * value).collect();
        let count = box_sums(&vec![1.0; own.len()], size);
        let mean: Vec<f32> = box_sums(&own, size).iter().zip(&count).map(|(sum, n)| sum / n).collect();
        let variance = box_sums(&squares, size).into_iter().zip(&count).zip(&mean);
        let variance: Vec<f32> = variance.map(|((sum, n), mean)| (sum / n - mean * mean).max(0.0)).collect();
        let texture = variance.iter().map(|v| v / (v + PLAIN * NOISE)).collect();
        let deviation = variance.iter().map(|v| (v + NOISE).sqrt()).collect();
        Self { size, own, mean, deviation, texture, others: others.map(warp).collect() }
    }

    /// Returns how much the photos disagree about inverse depths, 0 to 1, within bounds, row by row of these; NaN where no
    /// other photo shows the place. Pixels with an inverse depth below 0 are not there.
    pub fn disagreement(&self, depth: impl Fn(usize, usize) -> f64, bounds: PixelBounds) -> Vec<f32> {
        let wide = PixelBounds {
            low: bounds.low.map(|low| low.saturating_sub(WINDOW)),
            high: [0, 1].map(|i| (bounds.high[i] + WINDOW).min(self.size[i])),
        };
        let [w, h] = [0, 1].map(|i| wide.high[i] - wide.low[i]);
        let mut each: Vec<Vec<f32>> = Vec::with_capacity(self.others.len());
        let mut samples = vec![0.0; w * h];
        let mut is_seen = vec![false; w * h];
        for (greys, warp) in &self.others {
            let mut any = false;
            for y in 0..h {
                for x in 0..w {
                    let (px, py) = (x + wide.low[0], y + wide.low[1]);
                    let inverse = depth(px, py);
                    let at = if inverse < 0.0 { None } else { warp.at(middle(px, py), inverse) };
                    let grey = at.and_then(|at| greys.at(at));
                    any |= grey.is_some();
                    is_seen[y * w + x] = grey.is_some();
                    // What is not seen continues what is beside it; its own pixel is not judged.
                    let beside = if x > 0 { samples[y * w + x - 1] } else { 0.0 };
                    samples[y * w + x] = grey.map_or(beside, |grey| (grey - 128.0) / SCALE);
                }
            }
            if any {
                each.push(self.correlated(&samples, &is_seen, wide, bounds));
            }
        }
        mean_of_better_half(&each, (bounds.high[0] - bounds.low[0]) * (bounds.high[1] - bounds.low[1]))
    }

    /// Compares the windows of warped samples with the photo's own.
    fn correlated(
        &self,
        samples: &[f32],
        is_seen: &[bool],
        wide: PixelBounds,
        bounds: PixelBounds,
    ) -> Vec<f32> {
        let [w, h] = [0, 1].map(|i| wide.high[i] - wide.low[i]);
        let own = |x: usize, y: usize| (y + wide.low[1]) * self.size[0] + x + wide.low[0];
        let squares: Vec<f32> = samples.iter().map(|value| value * value).collect();
        let products: Vec<f32> = (0..w * h).map(|at| samples[at] * self.own[own(at % w, at / w)]).collect();
        let count = box_sums(&vec![1.0; w * h], [w, h]);
        let [sums, squares, products] = [samples, &squares, &products].map(|of| box_sums(of, [w, h]));
        let mut result = Vec::with_capacity(w * h);
        for y in bounds.low[1] - wide.low[1]..bounds.high[1] - wide.low[1] {
            for x in bounds.low[0] - wide.low[0]..bounds.high[0] - wide.low[0] {
                let (at, own) = (y * w + x, own(x, y));
                let n = count[at];
                let mean = sums[at] / n;
                let deviation = (squares[at] / n - mean * mean).max(0.0) + NOISE;
                let common = products[at] / n - mean * self.mean[own];
                let correlation = common / (deviation.sqrt() * self.deviation[own]);
                result.push(if is_seen[at] { (1.0 - correlation).clamp(0.0, 1.0) } else { f32::NAN });
            }
        }
        result
    }

    /// Returns the bounds of the whole photo.
    pub fn whole(&self) -> PixelBounds {
        PixelBounds { low: [0, 0], high: self.size }
    }

    /// Returns the cost of a disagreement at a pixel: that of plain windows is neutral.
    #[inline]
    pub fn cost(&self, pixel: usize, disagreement: f32) -> f32 {
        if disagreement.is_nan() {
            return NEUTRAL + 0.1;
        }
        NEUTRAL + self.texture[pixel] * (disagreement - NEUTRAL)
    }

    /// Returns the cost of each pixel of the whole photo for what is infinitely far away.
    pub fn cost_far(&self) -> Vec<f32> {
        let far = self.disagreement(|x, y| PlaneDepth::FAR.at(x, y), self.whole());
        far.iter().enumerate().map(|(pixel, c)| self.cost(pixel, *c)).collect()
    }
}

/// Returns for each pixel the mean of the better half of what is known.
fn mean_of_better_half(each: &[Vec<f32>], count: usize) -> Vec<f32> {
    let mean = |at: usize| {
        let mut known = [f32::NAN; 16];
        let mut n = 0;
        for values in each.iter().take(16).filter(|values| !values[at].is_nan()) {
            known[n] = values[at];
            n += 1;
        }
        let known = &mut known[..n];
        known.sort_unstable_by(f32::total_cmp);
        let better = &known[..n.div_ceil(2)];
        if better.is_empty() { f32::NAN } else { better.iter().sum::<f32>() / better.len() as f32 }
    };
    (0..count).map(mean).collect()
}

/// Sums over windows, which end at the border.
fn box_sums(values: &[f32], [w, h]: [usize; 2]) -> Vec<f32> {
    let mut across = vec![0.0; values.len()];
    for (from, to) in values.chunks_exact(w).zip(across.chunks_exact_mut(w)) {
        for (x, to) in to.iter_mut().enumerate() {
            *to = from[x.saturating_sub(WINDOW)..(x + WINDOW + 1).min(w)].iter().sum();
        }
    }
    let mut sums = vec![0.0; values.len()];
    for y in 0..h {
        let row = &mut sums[y * w..(y + 1) * w];
        for other in y.saturating_sub(WINDOW)..(y + WINDOW + 1).min(h) {
            row.iter_mut().zip(&across[other * w..]).for_each(|(sum, value)| *sum += value);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_over_windows_end_at_the_border() {
        let sums = box_sums(&[1.0; 90], [9, 10]);
        assert_eq!((sums[0], sums[4], sums[4 * 9 + 4], sums[89]), (16.0, 28.0, 49.0, 16.0));
    }

    #[test]
    fn the_better_half_of_what_is_known_counts() {
        let each = [vec![0.1, f32::NAN], vec![0.9, f32::NAN], vec![0.3, 0.5], vec![f32::NAN, f32::NAN]];
        assert_eq!(mean_of_better_half(&each, 2), [0.2, 0.5]);
        assert!(mean_of_better_half(&each[3..], 2)[0].is_nan());
    }
}
