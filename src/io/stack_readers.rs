//! Programs that read the stacks of a project: while one does, versions of stacks that are no longer current are kept.
//!
//! Each reader has a lease in `cache/readers/`, which ends with it. A writer that finds one of another program leaves the former
//! versions to the next one. A reader that begins later reads the `stack.json` of the new version, because that was renamed before
//! the writer looked. All readers in one program share its lease, so that it can tell whether another program reads.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::in_use::one_name;
use quadratura_files::lease::Lease;
use quadratura_files::lock::ProjectLock;

/// The folder of the readers' leases, below the project's folder.
const FOLDER: &str = "cache/readers";

/// The readers of this program, by the project's folder.
static OURS: Mutex<BTreeMap<PathBuf, Readers>> = Mutex::new(BTreeMap::new());

struct Readers {
    count: usize,
    /// None where the project's folder cannot be written to, and where nothing can be removed either.
    _lease: Option<Lease>,
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
                let _lease = lease(&folder);
                ours.insert(folder.clone(), Readers { count: 1, _lease });
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

/// Tells other programs, until the returned value is dropped, that this one reads stacks. It may replace stacks itself meanwhile, because
/// it knows what it reads; `None` where the project's folder cannot be written to.
pub fn tell_others(folder: &Path) -> Option<Lease> {
    lease(&one_name(folder))
}

/// Returns whether a program reads the stacks of the project in `folder`, this one or another. Whoever writes what is authored
/// may read stacks, too.
pub fn are_read(folder: &Path) -> bool {
    let folder = one_name(folder);
    ours().contains_key(&folder) || are_read_by_others(&folder)
}

/// Returns whether another program reads the stacks of the project in `folder`.
pub(super) fn are_read_by_others(folder: &Path) -> bool {
    let leases = fs::read_dir(folder.join(FOLDER)).into_iter().flatten().flatten();
    // One that was left behind is as good as none; on another machine that takes a while to see.
    let holders = leases.filter_map(|entry| {
        let holder = Lease::holder(&entry.path());
        if holder.is_none() {
            let _ = fs::remove_file(entry.path());
        }
        holder
    });
    holders.chain(ProjectLock::holder_of(folder)).any(|holder| !holder.is_this_process())
}

fn ours() -> MutexGuard<'static, BTreeMap<PathBuf, Readers>> {
    // The counts are valid after a panic elsewhere.
    OURS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Takes a lease of a name that no other has.
fn lease(folder: &Path) -> Option<Lease> {
    let readers = folder.join(FOLDER);
    fs::create_dir_all(&readers).ok()?;
    let named = tempfile::Builder::new().prefix("").suffix(".lock").make_in(&readers, |file| {
        Lease::try_take(file)?.map_err(|_| std::io::ErrorKind::AlreadyExists.into())
    });
    let (lease, path) = named.ok()?.into_parts();
    // The lease removes the file itself, while it is its own.
    path.keep().ok()?;
    Some(lease)
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
        // One of another program: of a machine that nobody has heard of.
        let other = r#"{"program":"quadratura render","host":"farm-2","process":1,"machine":"m","since":0,"started":0,"nonce":"n","renewed":"0"}"#;
        let theirs = folder.path().join(FOLDER).join("theirs.lock");
        std::fs::write(&theirs, other).unwrap();
        assert!(are_read_by_others(folder.path()));
        std::fs::remove_file(theirs).unwrap();
        assert!(!are_read_by_others(folder.path()) && are_read(folder.path()));
    }
}
