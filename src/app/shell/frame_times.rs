//! The processor time of the window's frames, separately while idle and while jobs run.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde::Serialize;

/// The number of classes of a tenth of a millisecond; longer times count as the last.
const CLASSES: usize = 20_000;
const CLASSES_PER_S: f64 = 10_000.0;

/// The frame times of a run, shared so that they can be read after the window is closed.
#[derive(Debug, Clone, Default)]
pub struct FrameTimes(Arc<Mutex<FrameTally>>);

/// The frames of a run as they are counted.
#[derive(Debug, Default)]
struct FrameTally {
    /// The processor time of the window's thread when the last frame began, in seconds.
    used_s: Option<f64>,
    idle: Counted,
    while_jobs_ran: Counted,
}

#[derive(Debug, Default)]
struct Counted {
    own: FrameCounts,
    whole: FrameCounts,
}

/// The number of frames in each class.
#[derive(Debug, Default)]
struct FrameCounts(Vec<u32>);

/// The frame times of a run.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct FrameTimesReport {
    /// Frames while no job ran.
    pub idle: FrameRecorder,
    /// Frames while at least one job ran.
    pub while_jobs_ran: FrameRecorder,
}

/// The processor time of frames on the window's thread, without waiting for the screen and without other threads.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct FrameRecorder {
    /// The number of frames.
    pub frames: u32,
    /// The time of this program: applying results and requests, and laying out panels and views.
    pub own: Spent,
    /// The time of the whole frame: also tessellation, uploads, and the driver's work to present the frame. A software
    /// driver copies all pixels through the window system.
    pub whole: Spent,
}

/// Statistics of frame times in milliseconds, to a tenth.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Spent {
    /// The median.
    pub median_ms: f64,
    /// The 95th percentile.
    pub most_ms: f64,
    /// The maximum.
    pub longest_ms: f64,
}

impl FrameTimes {
    /// Starts a frame, and counts the processor time since the start of the previous one. Where the system does not
    /// report it, `drawn_s` is the time of drawing by the clock.
    pub fn begin(&self, drawn_s: Option<f32>, jobs_run: bool) {
        let used_s = used_by_thread();
        let mut tally = self.tally();
        let before = std::mem::replace(&mut tally.used_s, used_s);
        let spent_s = match (before, used_s) {
            (Some(before), Some(now)) => Some(now - before),
            _ => drawn_s.map(f64::from),
        };
        spent_s.into_iter().for_each(|spent_s| tally.counted(jobs_run).whole.add(spent_s));
    }

    /// Marks the end of this program's part of the frame.
    pub fn end(&self, jobs_run: bool) {
        let mut tally = self.tally();
        if let (Some(began), Some(now)) = (tally.used_s, used_by_thread()) {
            tally.counted(jobs_run).own.add(now - began);
        }
    }

    /// Returns the statistics of all frames so far.
    pub fn report(&self) -> FrameTimesReport {
        let tally = self.tally();
        FrameTimesReport { idle: tally.idle.frames(), while_jobs_ran: tally.while_jobs_ran.frames() }
    }

    fn tally(&self) -> MutexGuard<'_, FrameTally> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl FrameTally {
    fn counted(&mut self, jobs_run: bool) -> &mut Counted {
        if jobs_run { &mut self.while_jobs_ran } else { &mut self.idle }
    }
}

impl Counted {
    fn frames(&self) -> FrameRecorder {
        FrameRecorder { frames: self.whole.count(), own: self.own.spent(), whole: self.whole.spent() }
    }
}

/// Returns the processor time of this thread in seconds; none where the system does not report it.
#[cfg(target_os = "linux")]
fn used_by_thread() -> Option<f64> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Some(time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9)
}

#[cfg(not(target_os = "linux"))]
fn used_by_thread() -> Option<f64> {
    None
}

impl FrameCounts {
    fn add(&mut self, spent_s: f64) {
        let class = ((spent_s * CLASSES_PER_S) as usize).min(CLASSES - 1);
        if self.0.is_empty() {
            self.0.resize(CLASSES, 0);
        }
        self.0[class] += 1;
    }

    fn count(&self) -> u32 {
        self.0.iter().sum()
    }

    fn spent(&self) -> Spent {
        let frames = self.count();
        // The value is the upper end of the class that contains the percentile.
        let within = |percent: u64| {
            let wanted = (u64::from(frames) * percent).div_ceil(100);
            let mut passed = 0;
            let class = self.0.iter().position(|count| {
                passed += u64::from(*count);
                passed >= wanted && wanted > 0
            });
            class.map_or(0.0, |class| (class + 1) as f64 / (CLASSES_PER_S / 1000.0))
        };
        Spent { median_ms: within(50), most_ms: within(95), longest_ms: within(100) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_and_most_and_all_of_the_frames_are_told() {
        let mut counts = FrameCounts::default();
        assert_eq!((counts.count(), counts.spent()), (0, Spent::default()));
        (0..90).for_each(|_| counts.add(0.001));
        (0..9).for_each(|_| counts.add(0.006));
        counts.add(3600.0);
        assert_eq!(counts.count(), 100);
        let message = counts.spent();
        let near = |ms: f64, expected: f64| (ms - expected).abs() < 0.11;
        assert!(near(message.median_ms, 1.1) && near(message.most_ms, 6.1), "{message:?}");
        assert!(near(message.longest_ms, 2000.0), "what is longer than all classes counts as the last");
    }

    #[test]
    fn frames_beside_jobs_are_counted_by_themselves() {
        let times = FrameTimes::default();
        for jobs_run in [false, true, true] {
            times.begin(Some(0.001), jobs_run);
            times.end(jobs_run);
        }
        let report = times.report();
        if used_by_thread().is_some() {
            // The first frame is complete when the second one begins.
            assert_eq!((report.idle.frames, report.while_jobs_ran.frames), (1, 2));
            assert!(report.while_jobs_ran.own.longest_ms > 0.0);
        }
    }
}
