//! Something that a panel shows and that a job has to look up first.

use std::sync::Arc;

use crate::app::state::running::JobId;
use crate::app::state::running::Running;

/// What was looked up, and by whom.
pub struct Lookup<T> {
    found: Option<T>,
    job: Option<JobId>,
    ticket: Ticket,
}

/// Says which lookup somebody looks for: one that was given up since takes no answer any more.
#[derive(Clone, Default)]
pub struct Ticket(Arc<()>);

impl<T> Default for Lookup<T> {
    fn default() -> Self {
        Self { found: None, job: None, ticket: Ticket::default() }
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
    pub fn is_sought(&self, running: &Running) -> bool {
        self.found.is_none() && self.job.is_some_and(|job| running.is_running(job))
    }

    /// For whoever is going to look for it.
    pub fn ticket(&self) -> Ticket {
        self.ticket.clone()
    }

    /// A job looks for it.
    pub fn is_sought_by(&mut self, job: JobId) {
        self.job = Some(job);
    }

    /// It was found; what comes of another lookup, which this one took the place of, is of no use.
    pub fn find(&mut self, ticket: &Ticket, found: T) {
        if Arc::ptr_eq(&self.ticket.0, &ticket.0) {
            self.found = Some(found);
        }
    }

    /// The job has ended without finding it; why is in the notes.
    pub fn failed(&self, running: &Running) -> bool {
        self.found.is_none() && self.job.is_some_and(|job| !running.is_running(job))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_that_comes_after_the_question_was_given_up_is_dropped() {
        let mut lookup = Lookup::default();
        let late = lookup.ticket();
        lookup = Lookup::default();
        lookup.find(&late, 1);
        assert!(lookup.found().is_none());
        lookup.find(&lookup.ticket(), 2);
        assert_eq!(lookup.found(), Some(&2));
    }
}
