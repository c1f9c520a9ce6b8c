//! How far a job is: one bar that only grows, whatever stages the job consists of.

use std::time::{Duration, Instant};

use super::running::JobKind;
use crate::task::in_words;

/// The share of a stage that has to be done before the time left is estimated.
const ESTIMATED_FROM: f32 = 0.1;
/// An estimate after a moment would only flicker.
const SHORTEST: Duration = Duration::from_secs(1);
/// A job that still runs is not done.
const MOST: f32 = 0.99;

/// Returns the stages of a job in their order, with the shares of the time that they usually take. Other stages do not move
/// the bar: they are parts of these, or short. Where there are none, the first stage that is reported is the job's.
fn plan(kind: JobKind) -> &'static [(&'static str, f32)] {
    match kind {
        JobKind::Open => &[
            ("read cameras", 0.05),
            ("read poses", 0.05),
            ("read points", 0.2),
            ("read the model", 0.2),
            ("triangulate the faces", 0.1),
            ("find photos", 0.2),
            ("check stacks", 0.2),
        ],
        JobKind::Preview => &[
            ("shared points", 0.1),
            ("relief", 0.3),
            ("compare photos", 0.2),
            ("compare surroundings", 0.1),
            ("load layers", 0.3),
        ],
        JobKind::Build => &[
            ("build layers", 0.7),
            ("shared points", 0.05),
            ("relief", 0.15),
            ("compare photos", 0.05),
            ("compare surroundings", 0.05),
        ],
        JobKind::Fill => {
            &[("shared points", 0.05), ("relief", 0.15), ("compare photos", 0.05), ("fill", 0.75)]
        }
        JobKind::Update => &[("build layers", 0.5), ("relief", 0.1), ("fill", 0.4)],
        _ => &[],
    }
}

/// The progress of a job.
#[derive(Debug, Clone, Default)]
pub struct Progress {
    /// The only stage that counts, where the job has no plan.
    only: Option<&'static str>,
    /// The share that is done, 0 to 1; `None` before the first stage.
    share: Option<f32>,
    /// How much of the stage is done, in words.
    words: String,
    /// The stage that moved the bar last, when it began to, and where the bar was then.
    moved_by: Option<(&'static str, Instant, f32)>,
    /// The share of that stage that is done.
    of_stage: f32,
}

impl Progress {
    /// Records that `done` of `total` units of a stage are finished.
    pub fn step(&mut self, kind: JobKind, stage: &'static str, done: u64, total: u64) {
        if total == 0 {
            return;
        }
        let of_stage = (done as f32 / total as f32).min(1.0);
        let plan = plan(kind);
        let (before, weight) = match plan.iter().position(|(planned, _)| *planned == stage) {
            Some(at) => (plan[..at].iter().map(|(_, weight)| weight).sum(), plan[at].1),
            None if plan.is_empty() && *self.only.get_or_insert(stage) == stage => (0.0, 1.0),
            None => return,
        };
        let now = before + weight * of_stage;
        let was = self.share.unwrap_or_default();
        // A stage that begins again, or that runs beside a later one, has to catch up first.
        if now < was {
            return;
        }
        if self.moved_by.is_none_or(|(last, ..)| last != stage) {
            self.moved_by = Some((stage, Instant::now(), now));
        }
        (self.share, self.of_stage) = (Some(now.min(MOST).max(was)), of_stage);
        self.words = in_words(stage, done, total);
    }

    /// Returns the share that is done, 0 to 1; `None` before it is known. It never decreases.
    pub fn share(&self) -> Option<f32> {
        self.share
    }

    /// Says how much of the present stage is done: `3 of 9 photos`; empty before it is known.
    pub fn in_words(&self) -> &str {
        &self.words
    }

    /// Estimates the time left by the pace of the present stage; `None` before a tenth of it is done.
    pub fn left(&self) -> Option<Duration> {
        let (_, since, from) = self.moved_by?;
        let (spent, share) = (since.elapsed(), self.share?);
        let moved = share - from;
        let is_known = self.of_stage >= ESTIMATED_FROM && moved > 0.0 && spent > SHORTEST;
        is_known.then(|| spent.mul_f32((1.0 - share) / moved))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::synthetic::Rng;

    #[test]
    fn the_bar_of_a_job_only_grows_however_its_stages_run() {
        let stages = ["build layers", "shared points", "relief", "load layers", "fill", "check stacks"];
        for seed in 0..200 {
            let mut rng = Rng::new(seed);
            let kinds = [JobKind::Build, JobKind::Update, JobKind::Fill, JobKind::Open, JobKind::Render];
            let kind = kinds[rng.whole(0, 4) as usize];
            let (mut progress, mut before) = (Progress::default(), 0.0);
            for _ in 0..100 {
                let total = u64::from(rng.whole(1, 1000));
                let done = u64::from(rng.whole(0, total as u32));
                progress.step(kind, stages[rng.whole(0, 5) as usize], done, total);
                let share = progress.share().unwrap_or_default();
                assert!((before..1.0).contains(&share), "seed {seed}: {before} to {share}");
                before = share;
            }
        }
    }

    #[test]
    fn the_words_are_of_the_stage_that_moves_the_bar_and_not_of_its_parts() {
        let mut progress = Progress::default();
        progress.step(JobKind::Update, "fill", 3, 9);
        progress.step(JobKind::Update, "load layers", 47_217, 749_070);
        assert_eq!(progress.in_words(), "3 of 9 photos");
        let mut other = Progress::default();
        other.step(JobKind::Check, "check views", 1, 2);
        other.step(JobKind::Check, "relief", 99, 100);
        assert_eq!((other.share(), other.in_words()), (Some(0.5), "1 of 2 photos"));
        assert_eq!(other.left(), None, "after a moment nobody knows");
    }

    #[test]
    fn the_shares_of_each_plan_are_a_whole() {
        for kind in [JobKind::Open, JobKind::Preview, JobKind::Build, JobKind::Fill, JobKind::Update] {
            let sum: f32 = plan(kind).iter().map(|(_, weight)| weight).sum();
            assert!((sum - 1.0).abs() < 1e-6, "{kind:?}: {sum}");
        }
    }
}
