//! How fine the images of trees are drawn in pictures that follow each other, so that each takes about a given time.

use super::walk::WalkOptions;

/// How the drawing of trees keeps up with a moving view. Between two pictures the threshold changes by 2 % at most, and images
/// dissolve into each other as it does, so that no part of a tree changes at once. Where trees take so long that pictures are no motion
/// any more, it becomes as coarse as it should be at once; and where samples are so large that they look like squares, it becomes finer
/// at once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TreePace {
    threshold: f64,
    /// Seconds a unit of cost; `None` before the first picture.
    per_cost_s: Option<f64>,
    /// The largest factor by which the threshold changes from one picture to the next.
    step: f64,
}

/// What the parts of trees in a picture cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TreeCost {
    /// Samples of images.
    pub samples: u64,
    /// Triangles.
    pub triangles: u64,
}

/// The step of pictures that are seen: a dissolve takes eight of them.
const STEP: f64 = 1.02;

/// Samples that are larger than this are seen as squares, so that small steps would hide no change.
const SMOOTH: f64 = 2.0;

/// Where trees take this many times as long as they may, pictures follow each other so slowly that small steps would take minutes.
const FAR_TOO_SLOW: f64 = 4.0;

/// What costs more, in samples, is drawn coarsely while nothing is known about the device: software Vulkan takes half a second for it.
const UNTRIED: f64 = 2e7;

/// The largest threshold.
const COARSEST: f64 = WalkOptions::COARSEST.threshold;

/// What a triangle costs, in samples: in six previews of 200 trees the software device found 34 million samples a second, and drew 5 to
/// 8 million triangles, depending on whether the rest of the time is taken to grow with the samples or to be the same in all.
const TRIANGLE: f64 = 5.0;

/// What is handed to the device at once takes about this time, in seconds, so that a picture can be given up soon.
const AT_ONCE_S: f64 = 0.1;

/// What is handed over at once, in samples, to a device of which nothing is known: software Vulkan takes about as long for it.
const UNTRIED_AT_ONCE: f64 = 4e6;

/// No more is handed over at once, as a cost in samples; the samples of a picture are numbered, and are fewer.
const MOST_AT_ONCE: f64 = u32::MAX as f64;

impl TreeCost {
    /// Returns the cost in samples.
    pub fn in_samples(self) -> f64 {
        self.samples as f64 + TRIANGLE * self.triangles as f64
    }
}

impl Default for TreePace {
    fn default() -> Self {
        Self { threshold: WalkOptions::PREVIEW.threshold, per_cost_s: None, step: STEP }
    }
}

impl TreePace {
    /// Returns the pace of maps that serve for several pictures: each is as fine as it may be.
    pub fn of_maps() -> Self {
        Self { step: f64::INFINITY, ..Self::default() }
    }

    /// Returns the threshold for the next picture.
    pub fn threshold(&self) -> f64 {
        self.threshold
    }

    /// Becomes as coarse as it may be where nothing is known about the device yet and a picture of this cost would take a slow one long.
    /// Returns whether it did.
    pub fn begin(&mut self, cost: TreeCost) -> bool {
        let begins = self.per_cost_s.is_none() && cost.in_samples() > UNTRIED && self.threshold < COARSEST;
        if begins {
            self.threshold = COARSEST;
        }
        begins
    }

    /// Returns what is handed to the device at once, as a cost in samples.
    pub fn most_at_once(&self) -> f64 {
        let samples = |per_cost_s: f64| (AT_ONCE_S / per_cost_s).clamp(1.0, MOST_AT_ONCE);
        self.per_cost_s.map_or(UNTRIED_AT_ONCE, samples)
    }

    /// Learns how fast trees are drawn: this cost, in samples, took these seconds.
    pub fn learn(&mut self, samples: f64, seconds: f64) {
        if samples <= 0.0 {
            return;
        }
        let now = seconds / samples;
        // The average is smoothed, because single pictures are slow for other reasons.
        self.per_cost_s = Some(self.per_cost_s.map_or(now, |before| 0.7 * before + 0.3 * now));
    }

    /// Chooses the next threshold, after a picture of this cost whose trees may take `allowed_s` seconds.
    pub fn follow(&mut self, cost: TreeCost, allowed_s: f64) {
        let Some(per_cost_s) = self.per_cost_s else { return };
        let times = per_cost_s * cost.in_samples() / allowed_s.max(f64::MIN_POSITIVE);
        let most = if times > FAR_TOO_SLOW { f64::INFINITY } else { self.step };
        let least = self.step.recip().min(SMOOTH / self.threshold);
        // The samples of an image go with the inverse square of their size.
        let factor = times.sqrt().clamp(least, most);
        self.threshold = (self.threshold * factor).clamp(Self::default().threshold, COARSEST);
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
            pace.learn(of.in_samples(), 1e-6 * per_million_s * of.in_samples());
            pace.follow(of, 0.03);
            pace.threshold()
        };
        (0..100).map(next).collect()
    }

    #[test]
    fn slow_trees_become_coarser_by_small_steps_until_they_keep_up_and_no_further() {
        // 60 ms at a threshold of 1, and three times as long as allowed at the first.
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
    fn trees_that_are_far_too_slow_are_coarse_in_the_next_picture() {
        // 3.2 s at a threshold of 1, and 5 s at the first.
        let thresholds = followed(6.4e7, 0.05);
        assert_eq!(thresholds[0], COARSEST);
        // 50 ms then, which is as coarse as it goes.
        assert_eq!(thresholds[99], COARSEST);
        // 90 ms at a threshold of 1: the first picture takes 4.7 times as long as allowed, the second as long as allowed.
        let thresholds = followed(1.8e6, 0.05);
        assert!((thresholds[0] - 3f64.sqrt()).abs() < 1e-3, "{}", thresholds[0]);
    }

    #[test]
    fn what_could_take_long_begins_coarse_and_becomes_finer_on_a_quick_device() {
        let mut pace = TreePace::default();
        assert!(!pace.begin(TreeCost { samples: 10_000_000, triangles: 1_000_000 }));
        assert_eq!(pace, TreePace::default());
        let many = TreeCost { samples: 10_000_000, triangles: 3_000_000 };
        assert!(pace.begin(many) && !pace.begin(many), "once");
        assert_eq!(pace.threshold(), COARSEST);
        // A millisecond.
        pace.learn(1e6, 0.001);
        pace.follow(TreeCost { samples: 1_000_000, triangles: 0 }, 0.03);
        assert!((pace.threshold() - SMOOTH).abs() < 1e-12, "squares are gone at once");
        for _ in 0..100 {
            assert!(!pace.begin(many));
            pace.follow(TreeCost { samples: 1_000_000, triangles: 0 }, 0.03);
        }
        assert_eq!(pace.threshold(), WalkOptions::PREVIEW.threshold);
    }

    #[test]
    fn what_is_handed_over_at_once_takes_a_tenth_of_a_second() {
        let mut pace = TreePace::default();
        assert_eq!(pace.most_at_once(), UNTRIED_AT_ONCE);
        pace.learn(1e6, 0.04);
        // But for rounding.
        assert!((pace.most_at_once() - 2.5e6).abs() < 1e-6);
        // A clock that did not move, and a very slow device.
        let learned = |samples, seconds| {
            let mut pace = TreePace::default();
            pace.learn(samples, seconds);
            pace.most_at_once()
        };
        assert_eq!((learned(1.0, 0.0), learned(1.0, 60.0)), (MOST_AT_ONCE, 1.0));
    }

    #[test]
    fn triangles_count_and_nothing_is_known_before_the_first_picture_of_trees() {
        let mut pace = TreePace::default();
        let cost = TreeCost { samples: 0, triangles: 1_000_000 };
        pace.learn(0.0, 1.0);
        pace.follow(cost, 0.06);
        assert_eq!(pace.threshold(), WalkOptions::PREVIEW.threshold);
        pace.learn(1e6, 0.04);
        pace.follow(cost, 0.06);
        assert!((pace.threshold() - WalkOptions::PREVIEW.threshold * STEP).abs() < 1e-12);
    }
}
