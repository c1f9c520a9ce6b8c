//! Results that jobs make for a view: the key that is requested, the job that runs, and the last few results.

use crate::app::state::State;
use crate::app::state::notes::Note;
use crate::app::state::running::{JobId, JobKind, Running};
use crate::app::work::jobs::{Jobs, arrival};
use crate::error::{Error, Result};
use crate::task::Task;

/// The results for the last few keys, and the job that makes the next one.
pub struct ResultSlot<K, V> {
    /// The results, the one used last at the end.
    made: Vec<(K, V)>,
    most: usize,
    asked: Option<(K, JobId)>,
    /// The key whose job failed: it would only fail again.
    failed: Option<K>,
}

/// A request for a result.
pub struct ResultRequest<K, V> {
    /// The key of the requested result.
    pub key: K,
    /// The name of the job.
    pub name: &'static str,
    /// Whether a running job for another key is stopped. Otherwise it is finished first, so that the view shows
    /// something while keys change quickly.
    pub gives_up: bool,
    /// Finds the slot in the state, when the job is done.
    pub slot: fn(&mut State) -> &mut ResultSlot<K, V>,
}

impl<K: Clone + PartialEq + Send + 'static, V: Send + 'static> ResultSlot<K, V> {
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
    pub fn last_mut(&mut self, wanted: impl Fn(&K) -> bool) -> Option<&mut V> {
        self.made.iter_mut().rev().find(|(key, _)| wanted(key)).map(|(_, value)| value)
    }

    /// Applies a change to all results.
    pub fn each_mut(&mut self, mut change: impl FnMut(&K, &mut V)) {
        self.made.iter_mut().for_each(|(key, value)| change(key, value));
    }

    /// Returns whether a job is running.
    pub fn is_busy(&self) -> bool {
        self.asked.is_some()
    }

    /// Returns whether the job for this key failed; the error has been reported.
    pub fn has_failed(&self, key: &K) -> bool {
        self.failed.as_ref() == Some(key)
    }

    /// Starts a job for a request, unless its result exists or is being made.
    pub fn want(
        &mut self,
        jobs: &mut Jobs,
        running: &mut Running,
        request: ResultRequest<K, V>,
        work: impl FnOnce(&Task) -> Result<V> + Send + 'static,
    ) {
        self.asked = self.asked.take().filter(|(_, job)| running.is_running(*job));
        if self.get(&request.key).is_some() || self.has_failed(&request.key) {
            return;
        }
        match &self.asked {
            Some((key, _)) if *key == request.key => return,
            Some(_) if !request.gives_up => return,
            Some((_, job)) => jobs.stop(running, *job),
            None => (),
        }
        let ResultRequest { key, name, slot, .. } = request;
        let asked = key.clone();
        let job = jobs.start(running, JobKind::FlatView, name, move |task| {
            let made = work(task);
            if matches!(made, Err(Error::Cancelled)) {
                return Err(Error::Cancelled);
            }
            Ok(arrival(move |state| {
                let message = slot(state).arrived(key, made);
                message
                    .iter()
                    .flat_map(|error| Note::of_error(name, error))
                    .for_each(|note| state.tell(note));
            }))
        });
        self.asked = Some((asked, job));
    }

    fn arrived(&mut self, key: K, made: Result<V>) -> Option<Error> {
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
        assert_eq!(slot.last_mut(|key| *key < 3), Some(&mut "a"));
        assert!(slot.arrived(4, Err(Error::Request("no".into()))).is_some() && slot.has_failed(&4));
    }
}
