//! What several programs need of a project at the same time: estimates that all photos share, in `cache/`, are made once, and
//! layers of stacks stay while they are read.

use std::path::Path;

use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_io::photo_lock::WorkLock;
use quadratura_io::stack_readers::tell_others;
use quadratura_io::stack_store::StackStore;

/// What is known of an estimate.
pub enum Shared<T> {
    /// The cached one.
    Known(T),
    /// It has to be made, and written before the lock is dropped; none in a project that cannot be written to.
    Missing(Option<Box<WorkLock>>),
}

impl<T> Shared<T> {
    /// Reads an estimate of the project in `folder`. Where there is none, this waits for the right to make it, and for the program
    /// that is making it.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn find(folder: &Path, read: impl Fn() -> Option<T>, task: &Task) -> Result<Self> {
        if let Some(known) = read() {
            return Ok(Self::Known(known));
        }
        let lock = match WorkLock::of_site(folder, task) {
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            lock => lock.ok().map(Box::new),
        };
        Ok(read().map_or(Self::Missing(lock), Self::Known))
    }
}

/// Does work that reads layers of all photos, which other programs may be making again meanwhile. The last one to read removes
/// what is no longer current.
///
/// # Errors
/// Those of `work`; [`Error::Io`] when something cannot be removed.
pub fn while_read<T>(folder: &Path, task: &Task, work: impl FnOnce() -> Result<T>) -> Result<T> {
    let reading = tell_others(folder);
    let done = work();
    drop(reading);
    for file in StackStore::new(folder).clear_left()? {
        task.note(format!("a file that was changed by hand was moved to {}", file.display()));
    }
    done
}
