//! Results that jobs make for a view: the key that is requested, the job that runs, and the last few results.

use crate::state::running::JobId;
use quadratura_base::error::{Error, Result};

/// The results for the last few keys, and the job that makes the next one.
pub struct ResultSlot<K, V> {
    /// The results, the one used last at the end.
    made: Vec<(K, V)>,
    most: usize,
    asked: Option<(K, JobId)>,
    /// The key whose job failed: it would only fail again.
    failed: Option<K>,
}

/// The step to take for a key that is requested.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Due {
    /// Nothing: the result exists, is being made, or failed.
    Nothing,
    /// A job is to be started, after this one is stopped.
    Job(Option<JobId>),
}

impl<K: PartialEq, V> ResultSlot<K, V> {
    /// Makes a slot that keeps at most this many results.
    pub fn new(most: usize) -> Self {
        Self { made: Vec::new(), most, asked: None, failed: None }
    }

    /// Returns the result for a key.
    pub fn get(&self, key: &K) -> Option<&V> {
        self.made.iter().find(|(other, _)| other == key).map(|(_, value)| value)
    }

    /// Returns the result for a key to be drawn, and marks it as used last.
    pub fn take_up(&mut self, key: &K) -> Option<&mut V> {
        let index = self.made.iter().position(|(other, _)| other == key)?;
        let used = self.made.remove(index);
        self.made.push(used);
        self.made.last_mut().map(|(_, value)| value)
    }

    /// Returns the result used last whose key matches.
    pub fn last(&self, wanted: impl Fn(&K) -> bool) -> Option<&V> {
        self.made.iter().rev().find(|(key, _)| wanted(key)).map(|(_, value)| value)
    }

    /// Returns whether a job is running.
    pub fn is_busy(&self) -> bool {
        self.asked.is_some()
    }

    /// Returns whether the job for this key failed; the error has been reported.
    pub fn has_failed(&self, key: &K) -> bool {
        self.failed.as_ref() == Some(key)
    }

    /// Returns the job that makes a result.
    pub fn job(&self) -> Option<JobId> {
        self.asked.as_ref().map(|(_, job)| *job)
    }

    /// Returns what is to be done for a key, and marks its result as used last. `runs`: the job still runs.
    /// `gives_up`: a running job for another key is stopped; otherwise it is finished first.
    pub fn due(&mut self, key: &K, runs: bool, gives_up: bool) -> Due {
        self.asked = self.asked.take().filter(|_| runs);
        if self.take_up(key).is_some() || self.has_failed(key) {
            return Due::Nothing;
        }
        match &self.asked {
            Some((asked, _)) if asked == key => Due::Nothing,
            Some(_) if !gives_up => Due::Nothing,
            asked => Due::Job(asked.as_ref().map(|(_, job)| *job)),
        }
    }

    /// Records the job that makes the result for a key.
    pub fn is_asked(&mut self, key: K, job: JobId) {
        self.asked = Some((key, job));
    }

    /// Takes in what a job has made; returns the error where it failed.
    pub fn arrived(&mut self, key: K, made: Result<V>) -> Option<Error> {
        if self.asked.as_ref().is_some_and(|(asked, _)| *asked == key) {
            self.asked = None;
        }
        match made {
            Ok(value) => {
                self.made.retain(|(other, _)| *other != key);
                self.made.push((key, value));
                if self.made.len() > self.most {
                    drop(self.made.remove(0));
                }
                None
            }
            Err(error) => {
                self.failed = Some(key);
                Some(error)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_few_are_kept_and_what_failed_is_not_tried_again() {
        let mut slot: ResultSlot<u32, &str> = ResultSlot::new(2);
        for (key, value) in [(1, "a"), (2, "b")] {
            assert!(slot.arrived(key, Ok(value)).is_none());
        }
        assert_eq!(slot.take_up(&1), Some(&mut "a"));
        slot.arrived(3, Ok("c"));
        assert_eq!([1, 2, 3].map(|key| slot.get(&key).is_some()), [true, false, true]);
        assert_eq!(slot.last(|key| *key < 3), Some(&"a"));
        assert!(slot.arrived(4, Err(Error::Request("no".into()))).is_some() && slot.has_failed(&4));
    }

    #[test]
    fn a_key_is_asked_for_once_and_one_that_is_wanted_more_replaces_it() {
        let mut slot: ResultSlot<u32, &str> = ResultSlot::new(2);
        assert_eq!(slot.due(&1, false, true), Due::Job(None));
        slot.is_asked(1, JobId(7));
        assert_eq!(slot.due(&1, true, true), Due::Nothing);
        assert_eq!(slot.due(&2, true, false), Due::Nothing, "the first one is finished");
        assert_eq!(slot.due(&2, true, true), Due::Job(Some(JobId(7))));
        assert_eq!(slot.due(&2, false, true), Due::Job(None), "a job that ended need not be stopped");
        assert!(!slot.is_busy());
    }

    #[test]
    fn a_result_that_is_asked_for_again_outlives_one_that_is_not() {
        let mut slot: ResultSlot<u32, &str> = ResultSlot::new(2);
        for (key, value) in [(1, "a"), (2, "b")] {
            slot.arrived(key, Ok(value));
        }
        assert_eq!(slot.due(&1, false, true), Due::Nothing);
        slot.arrived(3, Ok("c"));
        assert_eq!([1, 2, 3].map(|key| slot.get(&key).is_some()), [true, false, true]);
    }

    #[test]
    fn what_arrives_for_another_key_leaves_the_running_job_asked() {
        let mut slot: ResultSlot<u32, &str> = ResultSlot::new(2);
        slot.is_asked(2, JobId(8));
        slot.arrived(1, Ok("late"));
        assert!(slot.is_busy() && slot.get(&1).is_some());
        slot.arrived(2, Ok("b"));
        assert!(!slot.is_busy());
    }
}
