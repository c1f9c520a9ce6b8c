//! The running jobs: subject and progress of each. These are plain values; the threads belong to `work`.

use std::collections::BTreeMap;

use super::progress::Progress;

/// The identifier of a job, unique in a run of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct JobId(pub u64);

/// The kind of a job: at most one of a kind runs at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum JobKind {
    /// Reads or creates a project.
    Open,
    /// Makes the renderer of the 3D view.
    Preview,
    /// Builds stacks.
    Build,
    /// Fills occluded areas.
    Fill,
    /// Builds and fills what is out of date, in the background.
    Update,
    /// Projects new paint to other photos, for the views.
    Projection,
    /// Compares cameras, photos and model.
    Check,
    /// Writes layered files.
    Export,
    /// Reads layered files.
    Import,
    /// Makes thumbnails of the photos.
    Thumbnails,
    /// Renders pictures and videos of views.
    Render,
    /// Loads a photo that is drawn over the 3D view.
    PhotoView,
    /// Finds which stacks are up to date.
    Survey,
    /// Autosaves unsaved changes.
    Keep,
    /// Compares the photos' exposures.
    Colour,
    /// Compares and blends the photos' surroundings for the views.
    Surroundings,
    /// Looks up data that a panel shows.
    Look,
    /// Makes the pictures of the flat views.
    FlatView,
    /// Writes masks.
    Mask,
    /// Finds transient objects.
    Suggest,
    /// Finds what the model lacks, or adds it to the model.
    Model,
    /// Searches a folder for photos, cameras and a model.
    Search,
    /// Checks the paths of a dialog.
    Paths,
    /// Checks whether the lock of a project is free.
    Lock,
}

impl JobKind {
    /// Returns whether the job is not listed in the messages when it is done, because the user did not start it.
    pub fn is_quiet(self) -> bool {
        matches!(
            self,
            Self::Thumbnails
                | Self::PhotoView
                | Self::FlatView
                | Self::Survey
                | Self::Update
                | Self::Projection
                | Self::Keep
                | Self::Preview
                | Self::Surroundings
                | Self::Look
                | Self::Mask
                | Self::Search
                | Self::Paths
                | Self::Lock
        )
    }

    /// Returns whether the job writes files that the user waits for.
    pub fn writes(self) -> bool {
        matches!(self, Self::Build | Self::Fill | Self::Export | Self::Import | Self::Render)
    }
}

/// A running job.
#[derive(Debug, Clone)]
pub struct Job {
    /// The kind of the job.
    pub kind: JobKind,
    /// The name for display: `Building layers`.
    pub name: String,
    /// The current step: stage and subject, empty before the first step.
    pub stage: String,
    /// How far the job is.
    pub progress: Progress,
    is_stopping: bool,
}

impl Job {
    /// Makes a job that starts now.
    pub fn new(kind: JobKind, name: String) -> Self {
        Self { kind, name, stage: String::new(), progress: Progress::default(), is_stopping: false }
    }

    /// Says how far the job is; the step that it does, where that is not known.
    pub fn in_words(&self) -> &str {
        if self.progress.in_words().is_empty() { &self.stage } else { self.progress.in_words() }
    }

    /// Returns whether the job was asked to stop.
    pub fn is_stopping(&self) -> bool {
        self.is_stopping
    }
}

/// The running jobs, without their threads.
#[derive(Debug, Default)]
pub struct Running {
    jobs: BTreeMap<JobId, Job>,
}

impl Running {
    /// Returns all jobs, the oldest first.
    pub fn all(&self) -> impl Iterator<Item = (JobId, &Job)> {
        self.jobs.iter().map(|(id, job)| (*id, job))
    }

    /// Returns whether a job of this kind runs.
    pub fn runs(&self, kind: JobKind) -> bool {
        self.jobs.values().any(|job| job.kind == kind)
    }

    /// Returns whether a job of any of these kinds runs.
    pub fn runs_any(&self, kinds: &[JobKind]) -> bool {
        kinds.iter().any(|kind| self.runs(*kind))
    }

    /// Returns how far the job of a kind is; `None` where none runs.
    pub fn progress(&self, kind: JobKind) -> Option<&Progress> {
        self.jobs.values().find(|job| job.kind == kind).map(|job| &job.progress)
    }

    /// Returns whether this job still runs.
    pub fn is_running(&self, id: JobId) -> bool {
        self.jobs.contains_key(&id)
    }

    /// Returns the jobs that write files that the user waits for.
    pub fn writing(&self) -> impl Iterator<Item = (JobId, &Job)> {
        self.all().filter(|(_, job)| job.kind.writes())
    }

    /// Returns whether no job runs.
    pub fn is_idle(&self) -> bool {
        self.jobs.is_empty()
    }

    /// Adds a job that has started.
    pub fn begun(&mut self, id: JobId, job: Job) {
        self.jobs.insert(id, job);
    }

    /// Returns a job, to update its progress.
    pub fn get_mut(&mut self, id: JobId) -> Option<&mut Job> {
        self.jobs.get_mut(&id)
    }

    /// Removes a job that has ended.
    pub fn ended(&mut self, id: JobId) -> Option<Job> {
        self.jobs.remove(&id)
    }

    /// Marks the jobs that `are` selects as stopping; returns their identifiers.
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
    /// Records a step. Steps of a subject are those of one photo, which do not move the bar.
    pub fn step(&mut self, stage: &'static str, subject: String, done: u64, total: u64) {
        if subject.is_empty() {
            self.progress.step(self.kind, stage, done, total);
        }
        self.stage = if subject.is_empty() { stage.into() } else { format!("{stage}: {subject}") };
    }
}
