//! What the window's frames take of the processor.

use std::sync::{Arc, Mutex, PoisonError};

use serde::Serialize;

/// Times are counted in classes of a tenth of a millisecond, up to so many; what is longer counts as the last.
const CLASSES: usize = 20_000;
const CLASSES_PER_S: f32 = 10_000.0;

/// The frames of a run, shared with whoever asks when the window is closed.
#[derive(Debug, Clone, Default)]
pub struct FrameTimes(Arc<Mutex<Vec<u32>>>);

/// What frames took, in milliseconds of the window's thread, without waiting for the screen.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct FrameReport {
    /// How many there were.
    pub frames: u32,
    /// Half of them took no longer.
    pub median_ms: f32,
    /// 95 of 100 took no longer.
    pub most_ms: f32,
    /// The longest one.
    pub longest_ms: f32,
}

impl FrameTimes {
    /// A frame took so many seconds.
    pub fn add(&self, seconds: f32) {
        let class = ((seconds * CLASSES_PER_S) as usize).min(CLASSES - 1);
        let mut counts = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if counts.is_empty() {
            counts.resize(CLASSES, 0);
        }
        counts[class] += 1;
    }

    /// All of them until now.
    pub fn report(&self) -> FrameReport {
        let counts = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let frames: u32 = counts.iter().sum();
        // The upper end of the class in which so many of 100 frames have passed.
        let within = |percent: u64| {
            let wanted = (u64::from(frames) * percent).div_ceil(100);
            let mut passed = 0;
            let class = counts.iter().position(|count| {
                passed += u64::from(*count);
                passed >= wanted && wanted > 0
            });
            class.map_or(0.0, |class| (class + 1) as f32 * 1000.0 / CLASSES_PER_S)
        };
        FrameReport { frames, median_ms: within(50), most_ms: within(95), longest_ms: within(100) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_and_most_and_all_of_the_frames_are_told() {
        let times = FrameTimes::default();
        assert_eq!(times.report(), FrameReport::default());
        (0..90).for_each(|_| times.add(0.001));
        (0..9).for_each(|_| times.add(0.006));
        times.add(3600.0);
        let report = times.report();
        assert_eq!(report.frames, 100);
        let near = |ms: f32, expected: f32| (ms - expected).abs() < 0.11;
        assert!(near(report.median_ms, 1.1) && near(report.most_ms, 6.1), "{report:?}");
        assert!(near(report.longest_ms, 2000.0), "what is longer than all classes counts as the last");
    }
}
