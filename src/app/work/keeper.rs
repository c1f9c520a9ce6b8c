//! What is not saved, kept beside the project for whatever way the program ends.
//!
//! Every edit says what the file is to hold ([`Keeper::want`]), and a job writes it at once. Whoever ends the program,
//! a signal, a display that is gone, a fault, finds here what no job has written yet; so does the end of the keeper
//! itself, which a panic reaches, too.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, Weak};

use super::waker::Waker;
use crate::document::Project;
use crate::error::Result;
use crate::io::lock::ProjectLock;
use crate::io::recovery::{UNSAVED_FILE, forget_unsaved, write_unsaved};

/// Keeps what is not saved of one project.
pub struct Keeper {
    folder: PathBuf,
    wanted: Mutex<Wanted>,
    /// Held by whoever writes or removes the file: else it could be written after a save.
    writing: Mutex<()>,
    /// Whoever writes into the project has it.
    _lock: Arc<ProjectLock>,
}

/// What the file is to hold.
#[derive(Default)]
struct Wanted {
    /// None where all is saved: then there is to be no file.
    project: Option<Arc<Project>>,
    /// The file is otherwise.
    is_due: bool,
    /// The file holds what somebody is being asked about: it stays as it is.
    is_held: bool,
}

impl Keeper {
    /// Of the project in `folder`, all of which is saved.
    pub fn new(folder: &Path, lock: Arc<ProjectLock>) -> Self {
        let (wanted, writing) = (Mutex::default(), Mutex::default());
        Self { folder: folder.to_path_buf(), wanted, writing, _lock: lock }
    }

    /// This is not saved; none where all is.
    pub fn want(&self, project: Option<Arc<Project>>) {
        let mut wanted = locked(&self.wanted);
        (wanted.project, wanted.is_due) = (project, true);
    }

    /// The file stays as it is until somebody has said what becomes of what it holds.
    pub fn hold(&self, is_held: bool) {
        locked(&self.wanted).is_held = is_held;
    }

    /// Brings the file to what is wanted last. From any thread; waits for whoever writes it just now.
    ///
    /// # Errors
    /// [`crate::Error::Io`]; it is still to be done then.
    pub fn write(&self) -> Result<()> {
        let _writing = locked(&self.writing);
        let project = {
            let mut wanted = locked(&self.wanted);
            if !wanted.is_due || wanted.is_held {
                return Ok(());
            }
            wanted.is_due = false;
            wanted.project.clone()
        };
        let written = match project {
            Some(project) => write_unsaved(&self.folder, &project),
            None => forget_unsaved(&self.folder),
        };
        written.inspect_err(|_| locked(&self.wanted).is_due = true)
    }

    /// Saves with `save`, and nothing is to be kept any more; beside what that says, whether the file is gone, which
    /// says the same as what is saved otherwise.
    ///
    /// # Errors
    /// What `save` says; all is kept as before then.
    pub fn saved<T>(&self, save: impl FnOnce() -> Result<T>) -> Result<(T, Result<()>)> {
        let _writing = locked(&self.writing);
        let saved = save()?;
        Ok((saved, self.forget_held()))
    }

    /// What is not saved is not wanted any more.
    ///
    /// # Errors
    /// [`crate::Error::Io`] when the file cannot be removed.
    pub fn forget(&self) -> Result<()> {
        let _writing = locked(&self.writing);
        self.forget_held()
    }

    fn forget_held(&self) -> Result<()> {
        *locked(&self.wanted) = Wanted::default();
        forget_unsaved(&self.folder)
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        // Nobody is left to be told.
        let _ = self.write();
    }
}

/// Whoever panicked has left the file whole: it changes by one rename.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Ends the window from outside of it, as a signal does: nobody is asked, and nothing is lost.
#[derive(Clone, Default)]
pub struct Ending(Arc<Outside>);

#[derive(Default)]
struct Outside {
    is_asked: AtomicBool,
    waker: OnceLock<Waker>,
    keeper: Mutex<Weak<Keeper>>,
    /// Of the project that was open last.
    folder: Mutex<PathBuf>,
}

impl Ending {
    /// The window is to close without asking. From any thread; when this returns, what is not saved is on disk, but for
    /// masks that are just being written: the window waits for them before it closes.
    pub fn ask(&self) {
        self.0.is_asked.store(true, Ordering::Relaxed);
        let keeper = locked(&self.0.keeper).upgrade();
        if let Some(keeper) = keeper {
            // Nobody is left to be told.
            let _ = keeper.write();
        }
        if let Some(waker) = self.0.waker.get() {
            waker.wake();
        }
    }

    /// Somebody has asked.
    pub fn is_asked(&self) -> bool {
        self.0.is_asked.load(Ordering::Relaxed)
    }

    /// The window that is to be woken.
    pub fn wakes(&self, waker: &Waker) {
        let _ = self.0.waker.set(waker.clone());
    }

    /// What is kept, and of which project.
    pub fn keeps(&self, keeper: &Arc<Keeper>) {
        *locked(&self.0.keeper) = Arc::downgrade(keeper);
        locked(&self.0.folder).clone_from(&keeper.folder);
    }

    /// The project of which something is kept that is not saved, once the window is gone.
    pub fn left_behind(&self) -> Option<PathBuf> {
        let folder = locked(&self.0.folder).clone();
        folder.join(UNSAVED_FILE).is_file().then_some(folder)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::project::{read_project, write_project};
    use crate::io::recovery::read_unsaved;
    use crate::layers::Options;

    fn project(margin: u32) -> Arc<Project> {
        let text = r#"{"version": 1, "photos": "p", "cameras": "c", "model": "m.obj"}"#;
        let project: Project = serde_json::from_str(text).unwrap();
        Arc::new(Project { options: Options { margin, ..Options::default() }, ..project })
    }

    fn bench() -> (tempfile::TempDir, Arc<Keeper>) {
        let folder = tempfile::tempdir().unwrap();
        write_project(folder.path(), &project(0)).unwrap();
        let lock = Arc::new(ProjectLock::take(folder.path()).unwrap());
        let keeper = Arc::new(Keeper::new(folder.path(), lock));
        (folder, keeper)
    }

    fn kept(folder: &Path) -> Option<u32> {
        let found = read_unsaved(folder, &read_project(folder).unwrap()).unwrap();
        found.map(|found| found.project.options.margin)
    }

    #[test]
    fn whoever_ends_the_program_leaves_what_was_wanted_last() {
        let (folder, keeper) = bench();
        keeper.want(Some(project(1)));
        keeper.want(Some(project(2)));
        assert_eq!(kept(folder.path()), None, "a job would have written it");
        let ending = Ending::default();
        ending.keeps(&keeper);
        ending.ask();
        assert_eq!((kept(folder.path()), ending.is_asked()), (Some(2), true));
        assert_eq!(ending.left_behind().as_deref(), Some(folder.path()));
        keeper.want(Some(project(3)));
        let panicked = std::thread::spawn(move || {
            let _keeper = keeper;
            panic!("the display is gone");
        });
        assert!(panicked.join().is_err());
        assert_eq!(kept(folder.path()), Some(3));
        ProjectLock::take(folder.path()).unwrap();
    }

    #[test]
    fn what_is_saved_or_forgotten_is_not_written_by_a_job_that_comes_late() {
        let (folder, keeper) = bench();
        keeper.want(Some(project(1)));
        keeper.saved(|| write_project(folder.path(), &project(1))).unwrap().1.unwrap();
        keeper.write().unwrap();
        assert!(!folder.path().join(UNSAVED_FILE).exists());
        keeper.want(Some(project(2)));
        keeper.write().unwrap();
        keeper.forget().unwrap();
        drop(keeper);
        assert!(!folder.path().join(UNSAVED_FILE).exists());
    }

    #[test]
    fn what_somebody_is_asked_about_stays_until_it_is_answered() {
        let (folder, keeper) = bench();
        write_unsaved(folder.path(), &project(7)).unwrap();
        keeper.hold(true);
        keeper.want(Some(project(1)));
        keeper.write().unwrap();
        assert_eq!(kept(folder.path()), Some(7));
        keeper.hold(false);
        keeper.write().unwrap();
        assert_eq!(kept(folder.path()), Some(1));
    }

    #[test]
    fn what_cannot_be_written_stays_wanted() {
        let (folder, keeper) = bench();
        keeper.want(Some(project(1)));
        let (file, aside) = (folder.path().join("project.json"), folder.path().join("aside.json"));
        std::fs::rename(&file, &aside).unwrap();
        keeper.write().unwrap_err();
        std::fs::rename(&aside, &file).unwrap();
        keeper.write().unwrap();
        assert_eq!(kept(folder.path()), Some(1));
    }
}
