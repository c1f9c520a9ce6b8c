//! One writer at a time: the lock file of a project.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read, Seek, Write};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// The name of the lock file in the project folder.
pub const LOCK_FILE: &str = "project.lock";

/// The right to write to a project, until it is dropped.
///
/// The operating system holds the lock and lets go of it when the program ends, however it ends: a
/// lock file that is left behind locks nothing. The file is never removed, because another program
/// might be waiting on the one that was removed.
#[derive(Debug)]
pub struct ProjectLock {
    _file: File,
}

impl ProjectLock {
    /// Takes the lock of the project in `folder`.
    ///
    /// # Errors
    /// [`Error::Request`] naming the holder when another program writes to the project;
    /// [`Error::Input`] when nothing may be written there; [`Error::Io`] when the lock file cannot be made.
    pub fn take(folder: &Path) -> Result<Self> {
        let path = folder.join(LOCK_FILE);
        let mut file = OpenOptions::new()
            .create(true)
            .truncate(false)
            .read(true)
            .write(true)
            .open(&path)
            .map_err(|error| refused(folder, &path, error))?;
        match file.try_lock() {
            Ok(()) => (),
            // A file system without locks, as some network drives are: go on without protection
            // rather than not at all.
            Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => (),
            Err(TryLockError::Error(error)) => return Err(Error::io(&path, "lock it")(error)),
            Err(TryLockError::WouldBlock) => return Err(held(folder, &mut file)),
        }
        sign(&mut file).map_err(Error::io(&path, "write it"))?;
        Ok(Self { _file: file })
    }
}

fn refused(folder: &Path, lock: &Path, error: std::io::Error) -> Error {
    match error.kind() {
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            let remedy =
                "give yourself the right to write in its folder, or copy the project to another place";
            Error::input(folder, "", format!("this project may not be written to ({error})"), remedy)
        }
        _ => Error::io(lock, "open the lock file")(error),
    }
}

impl ProjectLock {
    /// Who writes to the project in `folder` right now; none when nobody does, or where that cannot be told.
    pub fn holder(folder: &Path) -> Option<String> {
        let mut file = OpenOptions::new().read(true).write(true).open(folder.join(LOCK_FILE)).ok()?;
        matches!(file.try_lock(), Err(TryLockError::WouldBlock)).then(|| signature(&mut file))
    }
}

/// Leaves word of who holds the lock, for the message of whoever comes second.
fn sign(file: &mut File) -> std::io::Result<()> {
    file.set_len(0)?;
    file.rewind()?;
    writeln!(file, "{} (process {})", program().display(), std::process::id())
}

fn program() -> PathBuf {
    let program = std::env::current_exe().unwrap_or_default();
    program.file_name().map_or_else(|| "a program".into(), PathBuf::from)
}

fn held(folder: &Path, file: &mut File) -> Error {
    let holder = signature(file);
    Error::Request(format!(
        "{}: {holder} is writing to this project; wait until it is done, or end it",
        folder.display()
    ))
}

/// Who signed the file.
fn signature(file: &mut File) -> String {
    let mut holder = String::new();
    // Unreadable where the system locks the content too (Windows).
    let known = file.take(200).read_to_string(&mut holder).is_ok() && !holder.trim().is_empty();
    if known { holder.trim().to_owned() } else { "another program".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_writer_is_told_who_the_first_is() {
        let folder = tempfile::tempdir().unwrap();
        let first = ProjectLock::take(folder.path()).unwrap();
        let message = ProjectLock::take(folder.path()).unwrap_err().to_string();
        assert!(message.contains(&format!("process {}", std::process::id())), "{message}");
        let holder = ProjectLock::holder(folder.path());
        assert!(holder.is_some_and(|holder| holder.contains("process")));
        drop(first);
        assert_eq!(ProjectLock::holder(folder.path()), None);
        ProjectLock::take(folder.path()).unwrap();
    }

    #[test]
    fn a_lock_file_that_was_left_behind_is_no_obstacle() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(LOCK_FILE), "quadratura (process 1)\n and much more\n").unwrap();
        let _lock = ProjectLock::take(folder.path()).unwrap();
        let signed = std::fs::read_to_string(folder.path().join(LOCK_FILE)).unwrap();
        assert_eq!(signed.lines().count(), 1);
    }
}
