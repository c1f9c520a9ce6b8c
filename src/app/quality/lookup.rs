//! Something that a panel shows and that a job has to look up first.

use crate::app::jobs::{JobId, Jobs};

/// What was looked up, and by whom.
pub struct Lookup<T> {
    found: Option<T>,
    job: Option<JobId>,
}

impl<T> Default for Lookup<T> {
    fn default() -> Self {
        Self { found: None, job: None }
    }
}

impl<T> Lookup<T> {
    /// It, once it is found.
    pub fn found(&self) -> Option<&T> {
        self.found.as_ref()
    }

    /// Nobody has looked for it yet.
    pub fn is_due(&self) -> bool {
        self.found.is_none() && self.job.is_none()
    }

    /// A job is looking for it.
    pub fn is_sought(&self, jobs: &Jobs) -> bool {
        self.found.is_none() && self.job.is_some_and(|job| jobs.is_running(job))
    }

    /// A job looks for it.
    pub fn is_sought_by(&mut self, job: JobId) {
        self.job = Some(job);
    }

    /// It was found.
    pub fn find(&mut self, found: T) {
        self.found = Some(found);
    }

    /// The job has ended without finding it; why is in the notes.
    pub fn failed(&self, jobs: &Jobs) -> bool {
        self.found.is_none() && self.job.is_some_and(|job| !jobs.is_running(job))
    }
}
