//! A value that a panel shows and that a job computes.

use std::sync::Arc;

use crate::state::running::{JobId, Running};

/// A value that was computed, or is being computed by a job.
pub struct ComputedValue<T> {
    found: Option<T>,
    job: Option<JobId>,
    ticket: Ticket,
}

/// Identifies a lookup: the results of abandoned lookups are dropped.
#[derive(Clone, Default)]
pub struct Ticket(Arc<()>);

impl<T> Default for ComputedValue<T> {
    fn default() -> Self {
        Self { found: None, job: None, ticket: Ticket::default() }
    }
}

impl<T> ComputedValue<T> {
    /// Returns the value, once it is computed.
    pub fn found(&self) -> Option<&T> {
        self.found.as_ref()
    }

    /// Returns whether no job has been started yet.
    pub fn is_due(&self) -> bool {
        self.found.is_none() && self.job.is_none()
    }

    /// Returns whether a job is computing the value.
    pub fn is_sought(&self, running: &Running) -> bool {
        self.found.is_none() && self.job.is_some_and(|job| running.is_running(job))
    }

    /// Returns the ticket for the job that will compute the value.
    pub fn ticket(&self) -> Ticket {
        self.ticket.clone()
    }

    /// Records the job that computes the value.
    pub fn is_sought_by(&mut self, job: JobId) {
        self.job = Some(job);
    }

    /// Stores the value; the result of a lookup that was replaced is dropped.
    pub fn find(&mut self, ticket: &Ticket, found: T) {
        if Arc::ptr_eq(&self.ticket.0, &ticket.0) {
            self.found = Some(found);
        }
    }

    /// Returns whether the job ended without a value; the error is in the messages.
    pub fn failed(&self, running: &Running) -> bool {
        self.found.is_none() && self.job.is_some_and(|job| !running.is_running(job))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_that_comes_after_the_question_was_given_up_is_dropped() {
        let mut lookup = ComputedValue::default();
        let late = lookup.ticket();
        lookup = ComputedValue::default();
        lookup.find(&late, 1);
        assert!(lookup.found().is_none());
        lookup.find(&lookup.ticket(), 2);
        assert_eq!(lookup.found(), Some(&2));
    }
}
