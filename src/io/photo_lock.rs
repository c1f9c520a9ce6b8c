//! The locks of a project's photos, and of the estimates that all photos share: whoever makes a stack, a filling or an estimate
//! holds one, so that programs on several machines work on one project without doing anything twice.
//!
//! ```text
//! cache/locks/<photo>.lock     who builds or fills the photo
//! cache/locks/+site.lock       who makes what all photos share: gains, relief, agreement, surroundings, mattes
//! cache/readers/<name>.lock    who reads stacks, so that their former versions stay
//! ```

use std::path::{Path, PathBuf};

use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_document::names::{file_name_of_photo, photo_of_file_name};
use quadratura_files::lease::{Holder, Lease};

const LOCKS: &str = "cache/locks";
const END: &str = ".lock";
/// No photo's file has this name, because `+` is written `%2B` there.
const SITE: &str = "+site";

/// The right to make something, until it is dropped.
#[derive(Debug)]
pub struct WorkLock {
    lease: Lease,
    of: String,
}

impl WorkLock {
    /// Waits for the lock of a photo of the project in `folder`.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Cancelled`].
    pub fn of_photo(folder: &Path, photo: &str, task: &Task) -> Result<Self> {
        Self::wait(&photo_file(folder, photo), "this photo", task)
    }

    /// Waits for the lock of what all photos share.
    ///
    /// # Errors
    /// As [`Self::of_photo`].
    pub fn of_site(folder: &Path, task: &Task) -> Result<Self> {
        Self::wait(&file(folder, SITE), "the estimates of this project", task)
    }

    /// Takes the lock of a photo if it is free.
    pub fn try_of_photo(folder: &Path, photo: &str) -> Option<Self> {
        let file = photo_file(folder, photo);
        std::fs::create_dir_all(file.parent()?).ok()?;
        let lease = Lease::try_take(&file).ok()?.ok()?;
        Some(Self { lease, of: photo.to_owned() })
    }

    fn wait(file: &Path, of: &str, task: &Task) -> Result<Self> {
        let waits = |holder: &Holder| format!("{holder} is working on {of}; waiting for it");
        let takes_over = |holder: &Holder| {
            format!("{holder} was working on {of} and ended without finishing; its lock was taken over")
        };
        Ok(Self { lease: Lease::wait(file, task, waits, takes_over)?, of: of.to_owned() })
    }

    /// Checks before something becomes current that this is still the holder.
    ///
    /// # Errors
    /// [`Error::Request`] where another program has taken the lock over.
    pub fn check(&self) -> Result<()> {
        if self.lease.is_held() {
            return Ok(());
        }
        let of = &self.of;
        Err(Error::Request(format!(
            "another program has taken over the work on {of}, because this one did not renew its lock for a minute; nothing was \
             changed: run the command again"
        )))
    }
}

/// Something that is worked on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Work {
    /// The photo; `None` for what all photos share.
    pub photo: Option<String>,
    /// Who works on it.
    pub holder: Holder,
}

/// Returns what is worked on in the project in `folder`, by the names of the photos.
pub fn works(folder: &Path) -> Vec<Work> {
    let entries = std::fs::read_dir(folder.join(LOCKS)).into_iter().flatten().flatten();
    let mut works: Vec<Work> = entries
        .filter_map(|entry| {
            let name = entry.file_name().into_string().ok()?;
            let name = name.strip_suffix(END)?;
            let photo = if name == SITE { None } else { Some(photo_of_file_name(name)?) };
            Some(Work { photo, holder: Lease::holder(&entry.path())? })
        })
        .collect();
    works.sort_by(|a, b| a.photo.cmp(&b.photo));
    works
}

fn photo_file(folder: &Path, photo: &str) -> PathBuf {
    file(folder, &file_name_of_photo(photo))
}

fn file(folder: &Path, name: &str) -> PathBuf {
    folder.join(LOCKS).join(format!("{name}{END}"))
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::*;
    use quadratura_base::task::Event;

    #[test]
    fn the_second_to_work_on_a_photo_waits_and_says_so_once_and_another_photo_is_free() {
        let folder = tempfile::tempdir().unwrap();
        let first = WorkLock::of_photo(folder.path(), "a/b.jpg", &Task::silent()).unwrap();
        assert!(WorkLock::try_of_photo(folder.path(), "a/b.jpg").is_none());
        let other = WorkLock::try_of_photo(folder.path(), "c.jpg").unwrap();
        let site = WorkLock::of_site(folder.path(), &Task::silent()).unwrap();
        let photos: Vec<_> = works(folder.path()).into_iter().map(|work| work.photo).collect();
        assert_eq!(photos, [None, Some("a/b.jpg".into()), Some("c.jpg".into())]);
        let notes: Arc<Mutex<Vec<String>>> = Arc::default();
        let sink = notes.clone();
        let (told, hears) = std::sync::mpsc::channel();
        let task = Task::new(move |event| {
            if let Event::Note { text, .. } = event {
                sink.lock().unwrap().push(text.to_string());
                told.send(()).unwrap();
            }
        });
        std::thread::scope(|scope| {
            let second = scope.spawn(|| WorkLock::of_photo(folder.path(), "a/b.jpg", &task).unwrap().check());
            hears.recv().unwrap();
            drop(first);
            second.join().unwrap().unwrap();
        });
        let notes = notes.lock().unwrap();
        assert!(notes.len() == 1 && notes[0].contains("is working on this photo; waiting"), "{notes:?}");
        drop((other, site));
        assert!(works(folder.path()).is_empty());
    }

    #[test]
    fn who_has_lost_the_lock_makes_nothing_current() {
        let folder = tempfile::tempdir().unwrap();
        let lock = WorkLock::of_photo(folder.path(), "a.jpg", &Task::silent()).unwrap();
        lock.check().unwrap();
        std::fs::write(photo_file(folder.path(), "a.jpg"), "another's").unwrap();
        assert!(lock.check().unwrap_err().to_string().contains("has taken over the work on"));
    }
}
