//! Programs that read the stacks of a project: while one does, versions of stacks that are no longer current are kept.
//!
//! Readers hold the file `cache/readers.lock` locked for sharing; the system unlocks it however they end. A writer that
//! cannot lock it alone leaves the former versions to the next one. A reader that begins later reads the `stack.json` of
//! the new version, because that was renamed before the writer looked. All readers in one program share its lock, so
//! that it can tell whether another program reads.

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::in_use::one_name;

/// The file that readers lock, below the project's folder.
const FILE: &str = "cache/readers.lock";

/// The readers of this program, by the project's folder.
static OURS: Mutex<BTreeMap<PathBuf, Readers>> = Mutex::new(BTreeMap::new());

struct Readers {
    count: usize,
    /// The locked file; none where the project's folder cannot be written to, and where nothing can be removed either.
    locked: Option<File>,
}

/// A hold on the stacks of a project, until it is dropped.
#[derive(Debug)]
pub struct StackReader {
    folder: PathBuf,
}

impl StackReader {
    /// Begins reading the stacks of the project in `folder`.
    pub fn begin(folder: &Path) -> Self {
        let folder = one_name(folder);
        let mut ours = ours();
        match ours.get_mut(&folder) {
            Some(readers) => readers.count += 1,
            None => {
                let locked = opened(&folder).filter(|file| file.lock_shared().is_ok());
                ours.insert(folder.clone(), Readers { count: 1, locked });
            }
        }
        Self { folder }
    }
}

impl Drop for StackReader {
    fn drop(&mut self) {
        let mut ours = ours();
        let Some(readers) = ours.get_mut(&self.folder) else { return };
        readers.count -= 1;
        if readers.count == 0 {
            ours.remove(&self.folder);
        }
    }
}

/// Returns whether a program reads the stacks of the project in `folder`, this one or another.
pub fn are_read(folder: &Path) -> bool {
    let folder = one_name(folder);
    ours().contains_key(&folder) || is_locked(&folder)
}

/// Returns whether another program reads the stacks of the project in `folder`. The caller holds the project's lock, so
/// that no other program deletes anything while this one lets go of its own lock for a moment.
pub(super) fn are_read_by_others(folder: &Path) -> bool {
    let folder = one_name(folder);
    let ours = ours();
    let Some(file) = ours.get(&folder).and_then(|readers| readers.locked.as_ref()) else {
        return is_locked(&folder);
    };
    let is_free = file.unlock().is_ok() && file.try_lock().is_ok();
    // A lock that cannot be taken again is missed by other programs alone, and they hold the project's lock to write.
    let _ = file.unlock().and_then(|()| file.lock_shared());
    !is_free
}

fn is_locked(folder: &Path) -> bool {
    let Ok(file) = OpenOptions::new().read(true).write(true).open(path(folder)) else { return false };
    file.try_lock().is_err()
}

fn ours() -> MutexGuard<'static, BTreeMap<PathBuf, Readers>> {
    // The counts are valid after a panic elsewhere.
    OURS.lock().unwrap_or_else(PoisonError::into_inner)
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

    #[test]
    fn a_reader_of_this_program_is_none_of_another() {
        let folder = tempfile::tempdir().unwrap();
        let _ours = StackReader::begin(folder.path());
        assert!(!are_read_by_others(folder.path()));
        // A lock of another handle is as one of another program.
        let theirs = opened(&one_name(folder.path())).unwrap();
        theirs.lock_shared().unwrap();
        assert!(are_read_by_others(folder.path()));
        drop(theirs);
        assert!(!are_read_by_others(folder.path()) && are_read(folder.path()));
    }
}
