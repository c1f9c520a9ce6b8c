//! How far a job is: one bar that only grows, whatever stages the job consists of.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::running::JobKind;
use quadratura_base::task::{has_parts, in_words};

/// The share of a job, and of a stage, that has to be done before its pace is known.
const ESTIMATED_FROM: f32 = 0.1;
/// An estimate after a moment would only flicker.
const SHORTEST: Duration = Duration::from_secs(1);
/// How much longer than the shown time left a new estimate has to be to replace it, beyond [`SLOWER_BY`]: less is the
/// unevenness of photos, not a slower job.
const SLOWER: f32 = 1.3;
/// The least by which a new estimate is longer than the shown one that it replaces.
const SLOWER_BY: Duration = Duration::from_secs(5);
/// A job that still runs is not done.
const MOST: f32 = 0.99;

/// A stage of a job: its name, the share of the time that it usually takes, and what is said of it.
type Planned = (&'static str, f32, &'static str);

/// Returns the stages of a job in their order. Other stages do not move the bar: they are parts of these, or short. Where
/// there are none, the first stage that is reported is the job's.
fn plan(kind: JobKind) -> &'static [Planned] {
    match kind {
        JobKind::Open => &[
            ("read cameras", 0.05, "reading cameras"),
            ("read poses", 0.05, "reading cameras"),
            ("read points", 0.2, "reading sparse points"),
            ("read the model", 0.2, "reading the model"),
            ("triangulate the faces", 0.1, "reading the model"),
            ("find photos", 0.2, "finding photos"),
            ("check stacks", 0.2, "checking layers"),
        ],
        JobKind::Model => &[
            ("read photos", 0.1, "reading photos"),
            ("find planes", 0.1, "finding planes"),
            ("label photos", 0.3, "comparing photos"),
            ("sweep walls", 0.2, "finding walls"),
            ("outline faces", 0.1, "outlining faces"),
            ("predict photos", 0.2, "predicting photos"),
        ],
        JobKind::Preview => &[
            ("shared points", 0.1, "matching exposures"),
            ("relief", 0.3, "estimating depth detail"),
            ("compare photos", 0.2, "comparing photos"),
            ("compare surroundings", 0.1, "comparing surroundings"),
            ("load layers", 0.3, "loading layers"),
        ],
        JobKind::Build => &[
            ("build layers", 0.7, "built"),
            ("shared points", 0.05, "matching exposures"),
            ("relief", 0.15, "estimating depth detail"),
            ("compare photos", 0.05, "comparing photos"),
            ("compare surroundings", 0.05, "comparing surroundings"),
        ],
        JobKind::Fill => &[
            ("shared points", 0.03, "matching exposures"),
            ("relief", 0.1, "estimating depth detail"),
            ("compare photos", 0.04, "comparing photos"),
            ("compare surroundings", 0.03, "comparing surroundings"),
            ("compare see-through surfaces", 0.1, "comparing see-through surfaces"),
            ("mattes", 0.1, "finding mattes"),
            ("fill", 0.6, "filled"),
        ],
        JobKind::Update => &[
            ("check stacks", 0.02, "checking layers"),
            ("build layers", 0.4, "built"),
            ("shared points", 0.02, "matching exposures"),
            ("relief", 0.06, "estimating depth detail"),
            ("compare photos", 0.02, "comparing photos"),
            ("compare surroundings", 0.02, "comparing surroundings"),
            ("compare see-through surfaces", 0.06, "comparing see-through surfaces"),
            ("mattes", 0.06, "finding mattes"),
            ("fill", 0.34, "filled"),
        ],
        _ => &[],
    }
}

/// The progress of a job.
#[derive(Debug, Clone, Default)]
pub struct Progress {
    /// The only stage that counts, where the job has no plan.
    only: Option<&'static str>,
    /// The share of the bar that an earlier job had filled.
    begun_at: f32,
    /// The share that is done, 0 to 1; `None` before the first stage.
    share: Option<f32>,
    /// How much of the stage is done, in words.
    words: String,
    /// The number of units of the stage that are done.
    done: u64,
    /// When the first stage began.
    since: Option<Instant>,
    /// The stage that moves the bar.
    moving: Option<MovingStage>,
    /// The share of each earlier stage that is done.
    reached: BTreeMap<&'static str, f32>,
    /// When the time left was estimated, and what it was then.
    estimate: Option<(Instant, Duration)>,
}

/// A stage that moves the bar. Whichever stages were skipped before it, its part of the bar begins where the bar is.
#[derive(Debug, Clone)]
struct MovingStage {
    name: &'static str,
    since: Instant,
    /// The share of the stage that was done when it began to move the bar.
    begun_at: f32,
    /// The share of the stage that is done.
    done: f32,
    /// Its part of the bar.
    bar: [f32; 2],
}

impl Progress {
    /// Makes the progress of a job that continues what an earlier one has begun: its bar goes on where that one's was.
    pub fn continuing(share: f32) -> Self {
        Self { begun_at: share, share: (share > 0.0).then_some(share), ..Self::default() }
    }

    /// Records that `done` of `total` units of a stage are finished.
    pub fn step(&mut self, kind: JobKind, stage: &'static str, done: u64, total: u64) {
        if total == 0 {
            return;
        }
        let of_stage = (done as f32 / total as f32).min(1.0);
        let plan = plan(kind);
        let planned = plan.iter().position(|(name, ..)| *name == stage);
        // The stage's part of what is left of the bar.
        let part = match planned {
            Some(at) => plan[at].1 / plan[at..].iter().map(|(_, weight, _)| weight).sum::<f32>(),
            None if plan.is_empty() && *self.only.get_or_insert(stage) == stage => 1.0,
            None => return,
        };
        let share = self.share.unwrap_or_default();
        let begins_again = |moving: &MovingStage| done == 0 && moving.done > 0.0;
        match &mut self.moving {
            Some(moving) if moving.name == stage && !begins_again(moving) => {
                // Threads that count together report in any order.
                if of_stage < moving.done {
                    return;
                }
                moving.done = of_stage;
            }
            before => {
                let former = before.take();
                self.reached.extend(former.map(|former| (former.name, former.done)));
                let reached = self.reached.get(stage).copied().filter(|reached| *reached <= of_stage);
                let bar = [share, share + (1.0 - share) * part];
                let begun_at = reached.unwrap_or_default();
                *before =
                    Some(MovingStage { name: stage, since: Instant::now(), begun_at, done: of_stage, bar });
            }
        }
        let Some(moving) = &self.moving else { return };
        let [from, to] = moving.bar;
        let of_rest = (of_stage - moving.begun_at) / (1.0 - moving.begun_at).max(f32::EPSILON);
        self.share = Some((from + (to - from) * of_rest).min(MOST).max(share));
        self.words = match planned {
            None => in_words(stage, done, total),
            Some(at) if has_parts(stage) => format!("{} {}", in_words(stage, done, total), plan[at].2),
            // What comes next may take a while before it reports anything.
            Some(at) => {
                let next = plan.get(at + 1).filter(|(next, ..)| done >= total && !has_parts(next));
                next.unwrap_or(&plan[at]).2.to_owned()
            }
        };
        self.done = done;
        self.since.get_or_insert_with(Instant::now);
        self.estimate();
    }

    /// Returns the share that is done, 0 to 1; `None` before it is known. It never decreases.
    pub fn share(&self) -> Option<f32> {
        self.share
    }

    /// Returns the number of units of the present stage that are done.
    pub fn done(&self) -> u64 {
        self.done
    }

    /// Says what is done, with the number of photos, files or pictures: `3 of 9 photos built`; empty before it is known.
    pub fn in_words(&self) -> &str {
        &self.words
    }

    /// Returns the estimated time left; `None` before a tenth of the job is done, and once the estimate has run out.
    pub fn left(&self) -> Option<Duration> {
        self.estimate.and_then(|(at, left)| left.checked_sub(at.elapsed()))
    }

    /// Estimates the time left: that of the present stage by its own pace, once that is known, and all else by the pace of
    /// the job so far. The estimate that is shown grows only where the job has clearly become slower.
    fn estimate(&mut self) {
        let (Some(share), Some(since), Some(moving)) = (self.share, self.since, &self.moving) else { return };
        let (spent, moved) = (since.elapsed(), share - self.begun_at);
        if spent < SHORTEST || moved < ESTIMATED_FROM * (1.0 - self.begun_at) {
            return;
        }
        let at_pace = |left: f32, spent: Duration, moved: f32| spent.mul_f32((left / moved).max(0.0));
        let (of_stage, beyond) = (moving.bar[1] - share, 1.0 - moving.bar[1]);
        let (in_stage, by_stage) = (moving.since.elapsed(), share - moving.bar[0]);
        let knows_pace = moving.done - moving.begun_at >= ESTIMATED_FROM && by_stage > 0.0;
        let stage_left = match knows_pace {
            true => at_pace(of_stage, in_stage, by_stage),
            false => at_pace(of_stage, spent, moved),
        };
        let fresh = stage_left + at_pace(beyond, spent, moved);
        if self.left().is_none_or(|shown| fresh < shown || fresh > shown.mul_f32(SLOWER) + SLOWER_BY) {
            self.estimate = Some((Instant::now(), fresh));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    #[test]
    fn the_bar_of_a_job_only_grows_however_its_stages_run() {
        let stages = ["build layers", "shared points", "relief", "load layers", "fill", "check stacks"];
        for seed in 0..200 {
            let mut rng = Rng::new(seed);
            let kinds = [JobKind::Build, JobKind::Update, JobKind::Fill, JobKind::Open, JobKind::Render];
            let kind = kinds[rng.whole(0, 4) as usize];
            let mut before = rng.between(0.0, 0.9) as f32;
            let mut progress = Progress::continuing(before);
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
    fn the_words_say_what_is_counted_and_only_photos_are() {
        let mut progress = Progress::default();
        let mut words = Vec::new();
        for (stage, done, total) in [
            ("check stacks", 3, 9),
            ("build layers", 9, 9),
            ("compare photos", 8, 9),
            ("compare photos", 9, 9),
            ("fill", 1, 9),
            ("load layers", 47_217, 749_070),
        ] {
            progress.step(JobKind::Update, stage, done, total);
            words.push(progress.in_words().to_owned());
        }
        assert_eq!(words[..2], ["checking layers", "9 of 9 photos built"]);
        assert_eq!(words[2..4], ["comparing photos", "comparing surroundings"], "what comes next");
        assert_eq!(words[4..], ["1 of 9 photos filled", "1 of 9 photos filled"]);
        let mut other = Progress::default();
        other.step(JobKind::Check, "check views", 1, 2);
        other.step(JobKind::Check, "relief", 99, 100);
        assert_eq!((other.share(), other.in_words()), (Some(0.5), "1 of 2 photos"));
        assert_eq!(other.left(), None, "after a moment nobody knows");
    }

    #[test]
    fn the_bar_begins_at_its_beginning_where_the_first_stages_have_nothing_to_do() {
        let mut progress = Progress::default();
        progress.step(JobKind::Update, "build layers", 0, 0);
        assert_eq!(progress.share(), None);
        progress.step(JobKind::Update, "fill", 0, 9);
        assert_eq!(progress.share(), Some(0.0));
        progress.step(JobKind::Update, "fill", 3, 9);
        assert!((progress.share().unwrap() - 1.0 / 3.0).abs() < 1e-6);
    }

    #[test]
    fn a_stage_that_is_run_again_fills_a_part_of_what_is_left() {
        let mut progress = Progress::default();
        for _ in 0..3 {
            let before = progress.share().unwrap_or_default();
            for done in 0..=4 {
                progress.step(JobKind::Update, "build layers", done, 4);
            }
            assert!(progress.share().unwrap() > before + 0.05);
            assert_eq!(progress.in_words(), "4 of 4 photos built");
            progress.step(JobKind::Update, "fill", 0, 4);
            assert_eq!(progress.in_words(), "0 of 4 photos filled");
        }
    }

    #[test]
    fn the_time_left_is_known_after_a_tenth_and_grows_only_where_the_job_is_slower() {
        /// Makes a job whose stages began so many seconds ago.
        fn ago(progress: &mut Progress, seconds: u64) {
            let then = Instant::now().checked_sub(Duration::from_secs(seconds)).unwrap();
            progress.since = Some(then);
            progress.moving.as_mut().unwrap().since = then;
        }
        let mut progress = Progress::default();
        progress.step(JobKind::Render, "render", 0, 100);
        ago(&mut progress, 100);
        progress.step(JobKind::Render, "render", 5, 100);
        assert_eq!(progress.left(), None);
        progress.step(JobKind::Render, "render", 50, 100);
        let left = |progress: &Progress| progress.left().unwrap().as_secs_f32();
        assert!((98.0..=100.0).contains(&left(&progress)));
        ago(&mut progress, 110);
        progress.step(JobKind::Render, "render", 51, 100);
        assert!((98.0..=100.0).contains(&left(&progress)), "a picture that took longer is no reason");
        ago(&mut progress, 220);
        progress.step(JobKind::Render, "render", 52, 100);
        assert!(left(&progress) > 190.0, "now it is half as fast");
    }

    #[test]
    fn the_shares_of_each_plan_are_a_whole() {
        for kind in [JobKind::Open, JobKind::Preview, JobKind::Build, JobKind::Fill, JobKind::Update] {
            let sum: f32 = plan(kind).iter().map(|(_, weight, _)| weight).sum();
            assert!((sum - 1.0).abs() < 1e-6, "{kind:?}: {sum}");
        }
    }
}
