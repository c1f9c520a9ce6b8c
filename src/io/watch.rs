//! What image editors save in a folder: told at once, and taken when it is complete.
//!
//! Editors save in three ways: over the file, into a temporary file that is renamed, or by moving the old file away
//! first. So an event only says *when* to look; what is looked at is the state of the folder.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, SystemTime};

use notify_debouncer_full::notify::{RecommendedWatcher, RecursiveMode};
use notify_debouncer_full::{Debouncer, RecommendedCache, new_debouncer};

use super::layered::KEY_FILE;
use crate::error::{Error, Result};

/// Events within so long of each other are one.
const TOGETHER: Duration = Duration::from_millis(80);
/// Formats of layered files, by their extensions in lower case.
const EXTENSIONS: [&str; 4] = ["psd", "psb", "ora", "xcf"];

/// A folder that is being watched.
pub struct FolderWatch {
    events: Receiver<()>,
    _debouncer: Debouncer<RecommendedWatcher, RecommendedCache>,
}

impl FolderWatch {
    /// Watches a folder and those in it.
    ///
    /// # Errors
    /// [`Error::Request`] when the system cannot tell what happens there.
    pub fn new(folder: &Path) -> Result<Self> {
        let refused = |error: notify_debouncer_full::notify::Error| {
            Error::Request(format!("{}: this folder cannot be watched: {error}", folder.display()))
        };
        let (send, events) = channel();
        let mut debouncer = new_debouncer(TOGETHER, None, move |_| {
            // Nobody listens any more: the watch is being dropped.
            let _ = send.send(());
        })
        .map_err(refused)?;
        debouncer.watch(folder, RecursiveMode::Recursive).map_err(refused)?;
        Ok(Self { events, _debouncer: debouncer })
    }

    /// Waits until something happens, at most so long.
    pub fn wait(&self, at_most: Duration) {
        match self.events.recv_timeout(at_most) {
            Ok(()) => while self.events.try_recv().is_ok() {},
            // Nobody will tell any more: still look now and then.
            Err(RecvTimeoutError::Disconnected) => std::thread::sleep(at_most),
            Err(RecvTimeoutError::Timeout) => (),
        }
    }
}

/// Size and time of a file, or of all files of a folder: another one after every save.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stamp(Vec<(PathBuf, u64, Option<SystemTime>)>);

/// The layered documents in a folder: files by their extension, and folders that were exported, by their key file.
///
/// # Errors
/// [`Error::Io`] when the folder cannot be read. What vanishes meanwhile is left out.
pub fn documents(folder: &Path) -> Result<BTreeMap<PathBuf, Stamp>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).map_err(Error::io(folder, "read the folder"))? {
        let path = entry.map_err(Error::io(folder, "read the folder"))?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        // Temporary files of editors and of ourselves.
        if name.starts_with('.') || name.ends_with('~') {
            continue;
        }
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        if path.is_dir() {
            if path.join(KEY_FILE).is_file() {
                let stamps = files_below(&path).iter().filter_map(|file| stamp(file)).collect();
                found.insert(path, Stamp(stamps));
            }
        } else if EXTENSIONS.contains(&extension.as_str())
            && let Some(stamp) = stamp(&path)
        {
            found.insert(path, Stamp(vec![stamp]));
        }
    }
    Ok(found)
}

fn stamp(file: &Path) -> Option<(PathBuf, u64, Option<SystemTime>)> {
    let metadata = fs::metadata(file).ok()?;
    Some((file.to_owned(), metadata.len(), metadata.modified().ok()))
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut files: Vec<PathBuf> =
        entries.flat_map(|path| if path.is_dir() { files_below(&path) } else { vec![path] }).collect();
    files.sort();
    files
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layered_files_and_exported_folders_are_documents_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.psd", "B.ORA", "c.xcf", "d.png", ".hidden.psd", "e.psd~", "notes.txt"] {
            fs::write(folder.path().join(name), "x").unwrap();
        }
        for (inner, key) in [("layers", true), ("other", false)] {
            fs::create_dir(folder.path().join(inner)).unwrap();
            fs::write(folder.path().join(inner).join("a.psd"), "x").unwrap();
            if key {
                fs::write(folder.path().join(inner).join(KEY_FILE), "k").unwrap();
            }
        }
        let found = documents(folder.path()).unwrap();
        let names: Vec<_> = found.keys().map(|path| path.file_name().unwrap().to_str().unwrap()).collect();
        assert_eq!(names, ["B.ORA", "a.psd", "c.xcf", "layers"]);
    }

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
