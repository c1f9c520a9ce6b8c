//! Reports when image editors save files in a folder.
//!
//! Editors save in three ways: over the file, into a temporary file that is renamed, or by moving the old
//! file away first. An event therefore only says *when* to look; the state of the folder says what has
//! changed.

use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use notify_debouncer_full::notify::{RecommendedWatcher, RecursiveMode};
use notify_debouncer_full::{Debouncer, RecommendedCache, new_debouncer};

use quadratura_base::error::{Error, Result};

/// Events within this time of each other count as one: a save causes several in a row, and the waiting
/// program looks again anyway.
const TOGETHER: Duration = Duration::from_millis(20);

/// A watched folder.
pub struct FolderWatch {
    events: Receiver<()>,
    _debouncer: Debouncer<RecommendedWatcher, RecommendedCache>,
}

impl FolderWatch {
    /// Starts watching a folder and its sub-folders.
    ///
    /// # Errors
    /// [`Error::Request`] when the system does not support watching there.
    pub fn new(folder: &Path) -> Result<Self> {
        let refused = |error: notify_debouncer_full::notify::Error| {
            Error::Request(format!("{}: this folder cannot be watched: {error}", folder.display()))
        };
        let (send, events) = channel();
        let mut debouncer = new_debouncer(TOGETHER, None, move |_| {
            // Sending fails only while the watch is being dropped.
            let _ = send.send(());
        })
        .map_err(refused)?;
        debouncer.watch(folder, RecursiveMode::Recursive).map_err(refused)?;
        Ok(Self { events, _debouncer: debouncer })
    }

    /// Waits until something happens in the folder, at most for the given time.
    pub fn wait(&self, at_most: Duration) {
        match self.events.recv_timeout(at_most) {
            Ok(()) => while self.events.try_recv().is_ok() {},
            // No more events will come; the caller still looks again from time to time.
            Err(RecvTimeoutError::Disconnected) => std::thread::sleep(at_most),
            Err(RecvTimeoutError::Timeout) => (),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::documents::documents;

    #[test]
    fn a_save_is_told_and_changes_the_stamp() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.psd");
        fs::write(&file, "one").unwrap();
        let watch = FolderWatch::new(folder.path()).unwrap();
        let before = documents(folder.path()).unwrap();
        fs::write(folder.path().join("tmp"), "three").unwrap();
        fs::rename(folder.path().join("tmp"), &file).unwrap();
        watch.wait(Duration::from_secs(20));
        assert_ne!(documents(folder.path()).unwrap()[&file], before[&file]);
    }
}
