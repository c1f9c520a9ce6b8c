//! Locks by which jobs that write the same files run one after the other.

use std::sync::{Arc, Condvar, Mutex, PoisonError};

/// A lock for writing the project's paint, or its stacks: one writer at a time.
#[derive(Debug, Clone, Default)]
pub struct WriteLock(Arc<(Mutex<bool>, Condvar)>);

/// A lock that is held until this is dropped, on any thread.
#[derive(Debug)]
pub struct WriteGuard(WriteLock);

impl WriteLock {
    /// Waits for the lock.
    pub fn take(&self) -> WriteGuard {
        let (is_taken, released) = &*self.0;
        // The flag is valid after a panic elsewhere: the files change by renames.
        let mut is_taken = is_taken.lock().unwrap_or_else(PoisonError::into_inner);
        while *is_taken {
            is_taken = released.wait(is_taken).unwrap_or_else(PoisonError::into_inner);
        }
        *is_taken = true;
        drop(is_taken);
        WriteGuard(self.clone())
    }

    /// Takes the lock if it is free.
    pub fn try_take(&self) -> Option<WriteGuard> {
        let mut is_taken = self.0.0.lock().unwrap_or_else(PoisonError::into_inner);
        let was_taken = std::mem::replace(&mut *is_taken, true);
        (!was_taken).then(|| WriteGuard(self.clone()))
    }
}

impl Drop for WriteGuard {
    fn drop(&mut self) {
        let (is_taken, released) = &*self.0.0;
        *is_taken.lock().unwrap_or_else(PoisonError::into_inner) = false;
        released.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_at_a_time_has_the_lock_and_the_next_one_gets_it() {
        let lock = WriteLock::default();
        let held = lock.take();
        assert!(lock.try_take().is_none());
        let waits = std::thread::spawn({
            let lock = lock.clone();
            move || drop(lock.take())
        });
        drop(held);
        waits.join().unwrap();
        assert!(lock.try_take().is_some());
    }
}
