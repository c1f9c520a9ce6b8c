//! How fine the images of trees are drawn in pictures that follow each other, so that each takes about a given time.

use super::walk::WalkOptions;

/// How the drawing of trees keeps up with a moving view. Between two pictures the threshold changes by 2 % at most, and images
/// dissolve into each other as it does, so that no part of a tree changes at once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TreePace {
    threshold: f64,
    /// Seconds a unit of cost; `None` before the first picture.
    per_cost_s: Option<f64>,
}

/// What the parts of trees in a picture cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TreeCost {
    /// Samples of images.
    pub samples: u64,
    /// Triangles.
    pub triangles: u64,
}

/// The largest factor by which the threshold changes from one picture to the next: a dissolve takes eight pictures.
const STEP: f64 = 1.02;

/// Samples of this many pixels' sides are the largest: a sample is drawn in at most 3 x 3 pixels.
const COARSEST: f64 = 2.0;

/// What a triangle costs, in samples: in six previews of 200 trees the software device found 34 million samples a second, and drew 5 to
/// 8 million triangles, depending on whether the rest of the time is taken to grow with the samples or to be the same in all.
const TRIANGLE: f64 = 5.0;

impl TreeCost {
    /// Returns the cost in samples.
    fn in_samples(self) -> f64 {
        self.samples as f64 + TRIANGLE * self.triangles as f64
    }
}

impl Default for TreePace {
    fn default() -> Self {
        Self { threshold: WalkOptions::PREVIEW.threshold, per_cost_s: None }
    }
}

impl TreePace {
    /// Returns the threshold for the next picture.
    pub fn threshold(&self) -> f64 {
        self.threshold
    }

    /// Learns how fast the device draws: it took these seconds for samples of images alone.
    pub fn learn(&mut self, samples: u64, seconds: f64) {
        if samples == 0 {
            return;
        }
        let now = seconds / samples as f64;
        // The average is smoothed, because single pictures are slow for other reasons.
        self.per_cost_s = Some(self.per_cost_s.map_or(now, |before| 0.7 * before + 0.3 * now));
    }

    /// Chooses the next threshold, after a picture of this cost whose trees may take `allowed_s` seconds.
    pub fn follow(&mut self, cost: TreeCost, allowed_s: f64) {
        let Some(per_cost_s) = self.per_cost_s else { return };
        // The samples of an image go with the inverse square of their size.
        let wanted = (per_cost_s * cost.in_samples() / allowed_s.max(f64::MIN_POSITIVE)).sqrt();
        let finest = Self::default().threshold;
        self.threshold = (self.threshold * wanted.clamp(STEP.recip(), STEP)).clamp(finest, COARSEST);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wood whose samples go with the inverse square of the threshold.
    fn cost(threshold: f64, samples: f64) -> TreeCost {
        TreeCost { samples: (samples / (threshold * threshold)) as u64, triangles: 0 }
    }

    /// The thresholds of a hundred pictures, of a device that draws a million samples in `per_million_s`.
    fn followed(samples: f64, per_million_s: f64) -> Vec<f64> {
        let mut pace = TreePace::default();
        let next = |_| {
            let of = cost(pace.threshold(), samples);
            pace.learn(of.samples, 1e-6 * per_million_s * of.samples as f64);
            pace.follow(of, 0.03);
            pace.threshold()
        };
        (0..100).map(next).collect()
    }

    #[test]
    fn slow_trees_become_coarser_by_small_steps_until_they_keep_up_and_no_further() {
        // 60 ms at a threshold of 1.
        let thresholds = followed(1.2e6, 0.05);
        let steps = thresholds.windows(2).map(|pair| pair[1] / pair[0]);
        assert!(
            steps.clone().all(|step| step <= STEP * (1.0 + 1e-12) && step >= STEP.recip() * (1.0 - 1e-12))
        );
        assert!((thresholds[99] - 2f64.sqrt()).abs() < 1e-3, "{}", thresholds[99]);
        // They stay there.
        assert!((thresholds[50] - thresholds[99]).abs() < 1e-3);
    }

    #[test]
    fn quick_trees_are_as_fine_as_previews_and_very_slow_ones_no_coarser_than_a_sample_is_drawn() {
        assert!(followed(1e5, 0.05).iter().all(|threshold| *threshold == WalkOptions::PREVIEW.threshold));
        assert_eq!(followed(1e9, 0.05)[99], COARSEST);
    }

    #[test]
    fn triangles_count_and_nothing_is_known_before_the_first_picture_with_images() {
        let mut pace = TreePace::default();
        let cost = TreeCost { samples: 0, triangles: 1_000_000 };
        pace.learn(0, 1.0);
        pace.follow(cost, 0.03);
        assert_eq!(pace.threshold(), WalkOptions::PREVIEW.threshold);
        pace.learn(1_000_000, 0.04);
        pace.follow(cost, 0.03);
        assert!((pace.threshold() - WalkOptions::PREVIEW.threshold * STEP).abs() < 1e-12);
    }
}
