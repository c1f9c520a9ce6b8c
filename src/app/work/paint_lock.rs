//! The lock by which imports run one after the other.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A lock for writing the project's paint: one writer at a time.
#[derive(Debug, Clone, Default)]
pub struct PaintLock(Arc<Mutex<()>>);

impl PaintLock {
    /// Waits for the lock.
    pub fn take(&self) -> MutexGuard<'_, ()> {
        // A panic leaves the project's paint complete: it changes by one rename.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
