//! A memory budget that is shared by photos processed at the same time.

use std::sync::{Condvar, Mutex};

use sysinfo::System;

/// The memory that is assumed where the system does not report it, in bytes.
const UNKNOWN_MACHINE: u64 = 8 << 30;

/// Returns a quarter of the memory that is available to this process, in bytes.
pub fn default_memory() -> u64 {
    let Ok(mut system) = System::new() else { return UNKNOWN_MACHINE / 4 };
    system.refresh_memory();
    // A container may be given less memory than the machine has.
    let limit = system.cgroup_limits().map_or(u64::MAX, |limits| limits.total_memory);
    system.total_memory().min(limit) / 4
}

/// A budget of bytes that may be in use at the same time. A job that needs more than all of it runs alone.
pub struct Budget {
    total: u64,
    free: Mutex<u64>,
    changed: Condvar,
}

impl Budget {
    /// Makes a budget of `total` bytes.
    pub fn new(total: u64) -> Self {
        Self { total, free: Mutex::new(total), changed: Condvar::new() }
    }

    /// Waits until `bytes` are free and reserves them while `work` runs.
    pub fn with<T>(&self, bytes: u64, work: impl FnOnce() -> T) -> T {
        let bytes = bytes.min(self.total);
        let free = self.free.lock().expect("no holder of this lock panics");
        let mut free =
            self.changed.wait_while(free, |free| *free < bytes).expect("no holder of this lock panics");
        *free -= bytes;
        drop(free);
        let result = work();
        *self.free.lock().expect("no holder of this lock panics") += bytes;
        self.changed.notify_all();
        result
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::*;

    #[test]
    fn the_machine_has_memory() {
        assert!(default_memory() > 1 << 20);
    }

    #[test]
    fn no_more_is_taken_at_once_than_there_is_and_what_is_too_large_works_alone() {
        let (budget, taken) = (Budget::new(10), AtomicU64::new(0));
        std::thread::scope(|scope| {
            for bytes in [4, 6, 3, 99, 10, 1, 7] {
                let (budget, taken) = (&budget, &taken);
                scope.spawn(move || {
                    budget.with(bytes, || {
                        let share = bytes.min(10);
                        assert!(taken.fetch_add(share, Ordering::SeqCst) + share <= 10);
                        std::thread::yield_now();
                        taken.fetch_sub(share, Ordering::SeqCst);
                    });
                });
            }
        });
        assert_eq!(*budget.free.lock().unwrap(), 10);
    }
}
