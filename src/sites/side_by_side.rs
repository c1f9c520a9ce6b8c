//! Work on several photos or files: several at a time, within a memory budget, or one after the other. A fault in one
//! is reported as its own, and the others go on.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::budget::Budget;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;

/// The limits of processing in parallel, and the name of the stage.
pub struct ParallelPhotos {
    /// The largest number of items processed at the same time, at least one.
    pub threads: usize,
    /// The memory budget in bytes for all of them; an item that needs more runs alone.
    pub memory: u64,
    /// The stage that is reported for all items together.
    pub stage: &'static str,
}

impl ParallelPhotos {
    /// Runs `work` on all items and returns the results in their order; `bytes` returns the memory that an item
    /// takes.
    ///
    /// # Errors
    /// Returns [`quadratura_base::Error::Cancelled`] when the task was cancelled. Long-running `work` should check `task`,
    /// too.
    pub fn run<I: Sync, T: Send>(
        &self,
        items: &[I],
        bytes: impl Fn(&I) -> u64 + Sync,
        work: impl Fn(&I) -> T + Sync,
        task: &Task,
    ) -> Result<Vec<T>> {
        let total = items.len() as u64;
        task.step(self.stage, 0, total)?;
        let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let budget = Budget::new(self.memory);
        let results: Vec<Mutex<Option<T>>> = items.iter().map(|_| Mutex::default()).collect();
        let take = || {
            while let Some(i) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|i| *i < items.len()) {
                let result = budget.with(bytes(&items[i]), || work(&items[i]));
                *results[i].lock().expect("no holder of this lock panics") = Some(result);
                let finished = done.fetch_add(1, Ordering::Relaxed) as u64 + 1;
                if task.step(self.stage, finished, total).is_err() {
                    return;
                }
            }
        };
        // These are separate threads, not rayon's: a rayon thread that waits inside one item would start another
        // one and hold both.
        std::thread::scope(|scope| {
            (0..self.threads.clamp(1, items.len().max(1))).for_each(|_| drop(scope.spawn(take)));
        });
        task.check_cancelled()?;
        let taken =
            results.into_iter().map(|result| result.into_inner().expect("no holder of this lock panics"));
        Ok(taken
            .map(|result| result.expect("the task was not cancelled, so every item was processed"))
            .collect())
    }
}

/// The results of `work` on `items`, one after the other.
///
/// # Errors
/// [`Error::Cancelled`], also when `work` says so.
pub fn one_by_one<I, T>(
    stage: &'static str,
    items: &[I],
    mut work: impl FnMut(&I) -> Result<T>,
    task: &Task,
) -> Result<Vec<Result<T>>> {
    let total = items.len() as u64;
    let mut results = Vec::with_capacity(items.len());
    for (item, done) in items.iter().zip(0..) {
        task.step(stage, done, total)?;
        match work(item) {
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            result => results.push(result),
        }
    }
    task.step(stage, total, total)?;
    Ok(results)
}

/// The results of all items that were done, and each item that failed with its error; both in the items' order.
pub(super) type DoneAndFailed<I, T> = (Vec<T>, Vec<(I, Error)>);

/// Sorts results by whether they are some.
///
/// # Errors
/// [`Error::Cancelled`] where one of them is: then nothing of the rest is of use.
pub fn done_and_failed<I: Clone, T>(items: &[I], results: Vec<Result<T>>) -> Result<DoneAndFailed<I, T>> {
    let (mut done, mut failed) = (Vec::new(), Vec::new());
    for (item, result) in items.iter().zip(results) {
        match result {
            Ok(result) => done.push(result),
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => failed.push((item.clone(), error)),
        }
    }
    Ok((done, failed))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn four(threads: usize) -> ParallelPhotos {
        ParallelPhotos { threads, memory: 10, stage: "test" }
    }

    #[test]
    fn results_come_in_the_order_of_the_items() {
        let items: Vec<u64> = (0..50).collect();
        for threads in [0, 1, 4, 99] {
            let squares = four(threads).run(&items, |i| *i, |i| i * i, &Task::silent()).unwrap();
            assert_eq!(squares, items.iter().map(|i| i * i).collect::<Vec<_>>());
        }
        assert!(four(4).run(&[0u64; 0], |_| 0, |i| *i, &Task::silent()).unwrap().is_empty());
    }

    #[test]
    fn whoever_asks_to_stop_gets_nothing_and_no_more_is_begun() {
        let task = Task::silent();
        let begun = AtomicUsize::new(0);
        let work = |_: &u8| {
            begun.fetch_add(1, Ordering::Relaxed);
            task.stop_flag().store(true, Ordering::Relaxed);
        };
        let stopped = four(1).run(&[0u8; 9], |_| 1, work, &task);
        assert!(matches!(stopped, Err(Error::Cancelled)) && begun.load(Ordering::Relaxed) == 1);
    }

    #[test]
    fn a_fault_in_one_is_its_own_and_being_stopped_ends_all() {
        let work = |i: &u8| match i {
            2 => Err(Error::Request("two".into())),
            7 => Err(Error::Cancelled),
            i => Ok(i * 10),
        };
        let task = Task::silent();
        let (done, failed) =
            done_and_failed(&[1, 2, 3], one_by_one("test", &[1, 2, 3], work, &task).unwrap()).unwrap();
        assert_eq!((done, failed.len(), failed[0].0), (vec![10, 30], 1, 2));
        assert!(matches!(one_by_one("test", &[1, 7, 3], work, &task), Err(Error::Cancelled)));
        assert!(matches!(done_and_failed(&[7], vec![work(&7)]), Err(Error::Cancelled)));
    }
}
