//! Programs that read the stacks of a project: while one does, versions of stacks that are no longer current are kept.
//!
//! Readers hold the file `cache/readers.lock` locked for sharing; the system unlocks it however they end. A writer that
//! cannot lock it alone leaves the former versions to the next one. A reader that begins later reads the `stack.json` of
//! the new version, because that was renamed before the writer looked.

use std::fs::{self, File, OpenOptions};
use std::path::{Path, PathBuf};

/// The file that readers lock, below the project's folder.
const FILE: &str = "cache/readers.lock";

/// A program's hold on the stacks of a project, until it is dropped.
#[derive(Debug)]
pub(crate) struct StackReader {
    /// The locked file; none where the project's folder cannot be written to, and where nothing can be removed either.
    _locked: Option<File>,
}

impl StackReader {
    /// Begins reading the stacks of the project in `folder`.
    pub(crate) fn begin(folder: &Path) -> Self {
        let file = opened(folder);
        Self { _locked: file.filter(|file| file.lock_shared().is_ok()) }
    }
}

/// Returns whether a program reads the stacks of the project in `folder`.
pub(crate) fn are_read(folder: &Path) -> bool {
    let Ok(file) = OpenOptions::new().read(true).write(true).open(path(folder)) else { return false };
    file.try_lock().is_err()
}

fn opened(folder: &Path) -> Option<File> {
    let path = path(folder);
    fs::create_dir_all(path.parent()?).ok()?;
    OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path).ok()
}

fn path(folder: &Path) -> PathBuf {
    folder.join(FILE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stacks_are_read_until_the_last_reader_ends() {
        let folder = tempfile::tempdir().unwrap();
        assert!(!are_read(folder.path()));
        let first = StackReader::begin(folder.path());
        let second = StackReader::begin(folder.path());
        assert!(are_read(folder.path()));
        drop(first);
        assert!(are_read(folder.path()));
        drop(second);
        assert!(!are_read(folder.path()));
    }

    #[test]
    fn a_folder_that_cannot_be_written_to_is_read_all_the_same() {
        let folder = tempfile::NamedTempFile::new().unwrap();
        drop(StackReader::begin(folder.path()));
        assert!(!are_read(folder.path()));
    }
}
