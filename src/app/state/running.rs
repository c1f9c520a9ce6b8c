//! The jobs that run: what each is about and how far it is. Plain figures; the threads are `work`'s.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Tells a job from all others of this run of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct JobId(pub u64);

/// What a job is about: at most one of a kind runs at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// Reads or makes a project.
    Open,
    /// Makes the renderer of the 3D view.
    Preview,
    /// Builds stacks.
    Build,
    /// Fills hidden parts.
    Fill,
    /// Compares cameras, photos and model.
    Check,
    /// Writes layered files.
    Export,
    /// Reads layered files.
    Import,
    /// Makes small pictures of the photos.
    Thumbnails,
    /// Pictures and films of views.
    Render,
    /// Reads a photo to be laid over the 3D view.
    PhotoView,
    /// Looks which stacks are up to date.
    Survey,
    /// Keeps what is not saved.
    Keep,
    /// Compares the photos' exposures.
    Colour,
    /// Looks something up that a panel shows.
    Look,
    /// Makes what the flat views show.
    FlatView,
    /// Writes masks.
    Mask,
    /// Looks for what stands in one photo alone.
    Suggest,
    /// Looks through a folder for photos, cameras and a model.
    Search,
    /// Looks at the paths of a dialog.
    Paths,
    /// Asks whether a project is free.
    Lock,
}

impl Kind {
    /// Work that nobody asked for by name is not listed when it is done.
    pub fn is_quiet(self) -> bool {
        matches!(
            self,
            Self::Thumbnails
                | Self::PhotoView
                | Self::FlatView
                | Self::Survey
                | Self::Keep
                | Self::Preview
                | Self::Look
                | Self::Mask
                | Self::Search
                | Self::Paths
                | Self::Lock
        )
    }

    /// It writes files that somebody waits for.
    pub fn writes(self) -> bool {
        matches!(self, Self::Build | Self::Fill | Self::Export | Self::Import | Self::Render)
    }
}

/// A job that runs.
#[derive(Debug, Clone)]
pub struct Job {
    /// What it is about.
    pub kind: Kind,
    /// For people: `Building layers`.
    pub name: String,
    /// What is being done right now: stage and subject, empty before the first step.
    pub stage: String,
    /// Units done and units in all of the stage that counts; none before it is known.
    pub progress: Option<(u64, u64)>,
    /// When it began.
    pub since: Instant,
    is_stopping: bool,
    counted: BTreeMap<&'static str, (u64, u64)>,
}

impl Job {
    /// One that begins now.
    pub fn new(kind: Kind, name: String) -> Self {
        Self {
            kind,
            name,
            stage: String::new(),
            progress: None,
            since: Instant::now(),
            is_stopping: false,
            counted: BTreeMap::new(),
        }
    }

    /// Between 0 and 1; none before it is known.
    pub fn share(&self) -> Option<f32> {
        self.progress.map(|(done, total)| done as f32 / total.max(1) as f32)
    }

    /// Time left if it goes on as it did; none before anything is done.
    pub fn left(&self) -> Option<Duration> {
        let (done, total) = self.progress.filter(|(done, total)| *done > 0 && done < total)?;
        // A guess after a moment would only flicker.
        let spent = self.since.elapsed();
        (spent > Duration::from_secs(1)).then(|| spent.mul_f64((total - done) as f64 / done as f64))
    }

    /// Somebody asked it to stop.
    pub fn is_stopping(&self) -> bool {
        self.is_stopping
    }
}

/// The jobs that run, as everything above the threads knows them.
#[derive(Debug, Default)]
pub struct Running {
    jobs: BTreeMap<JobId, Job>,
}

impl Running {
    /// All of them, the oldest first.
    pub fn all(&self) -> impl Iterator<Item = (JobId, &Job)> {
        self.jobs.iter().map(|(id, job)| (*id, job))
    }

    /// Whether a job of this kind runs.
    pub fn runs(&self, kind: Kind) -> bool {
        self.jobs.values().any(|job| job.kind == kind)
    }

    /// Whether a job of any of these kinds runs.
    pub fn runs_any(&self, kinds: &[Kind]) -> bool {
        kinds.iter().any(|kind| self.runs(*kind))
    }

    /// Whether this one still runs.
    pub fn is_running(&self, id: JobId) -> bool {
        self.jobs.contains_key(&id)
    }

    /// Those that write files that somebody waits for.
    pub fn writing(&self) -> impl Iterator<Item = (JobId, &Job)> {
        self.all().filter(|(_, job)| job.kind.writes())
    }

    /// Nothing runs.
    pub fn is_idle(&self) -> bool {
        self.jobs.is_empty()
    }

    /// One has begun.
    pub fn begun(&mut self, id: JobId, job: Job) {
        self.jobs.insert(id, job);
    }

    /// One has come further.
    pub fn get_mut(&mut self, id: JobId) -> Option<&mut Job> {
        self.jobs.get_mut(&id)
    }

    /// One has ended.
    pub fn ended(&mut self, id: JobId) -> Option<Job> {
        self.jobs.remove(&id)
    }

    /// Those that `are` meant were asked to stop; their numbers.
    pub fn stopping(&mut self, are: impl Fn(JobId, &Job) -> bool) -> Vec<JobId> {
        let meant = self.jobs.iter_mut().filter(|(id, job)| are(**id, job));
        meant
            .map(|(id, job)| {
                job.is_stopping = true;
                *id
            })
            .collect()
    }
}

impl Job {
    /// Stages nest and run side by side: the one that counts is that of most units of work without a subject
    /// (all photos, not one photo's part), else the one told last.
    pub fn step(&mut self, stage: &'static str, subject: String, done: u64, total: u64) {
        self.stage = if subject.is_empty() { stage.into() } else { format!("{stage}: {subject}") };
        if subject.is_empty() {
            self.counted.insert(stage, (done, total));
            self.progress =
                self.counted.values().copied().filter(|(done, total)| done < total).max_by_key(|p| p.1);
            self.progress = self.progress.or(Some((done, total)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stage_of_most_units_counts_until_it_is_done() {
        let mut job = Job::new(Kind::Build, String::new());
        job.step("photos", String::new(), 3, 19);
        job.step("sort", "a.jpg".into(), 1, 50);
        job.step("read", String::new(), 1, 2);
        assert_eq!(job.progress, Some((3, 19)));
        job.step("photos", String::new(), 19, 19);
        assert_eq!(job.progress, Some((1, 2)));
    }
}
