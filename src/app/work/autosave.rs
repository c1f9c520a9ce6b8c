//! The autosave: keeps unsaved changes beside the project, however the program ends.
//!
//! Every edit sets the contents of the file ([`AutosaveWriter::want`]), and a job writes it at once. When the program is ended
//! by a signal, a lost display connection or a fault, the contents that no job has written yet are written from here;
//! so they are when the writer is dropped, which happens in a panic, too.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, Weak};

use super::waker::Waker;
use quadratura_base::error::Result;
use quadratura_document::Project;
use quadratura_files::lock::ProjectLock;
use quadratura_io::recovery::{UNSAVED_FILE, forget_unsaved, write_unsaved};

/// Writes the autosave of one project.
pub struct AutosaveWriter {
    folder: PathBuf,
    wanted: Mutex<AutosaveContents>,
    /// A lock for writing or removing the file: without it the file could be written after a save.
    writing: Mutex<()>,
    /// The lock of the project, which every writer holds.
    _lock: Arc<ProjectLock>,
}

/// The requested contents of the file.
#[derive(Default)]
struct AutosaveContents {
    /// The project; none where all is saved and the file is to be removed.
    project: Option<Arc<Project>>,
    /// Whether the file differs from the request.
    is_due: bool,
    /// Whether the file must not change, because the user is asked about its contents.
    is_held: bool,
}

impl AutosaveWriter {
    /// Makes the autosave of the project in `folder`, without unsaved changes.
    pub fn new(folder: &Path, lock: Arc<ProjectLock>) -> Self {
        let (wanted, writing) = (Mutex::default(), Mutex::default());
        Self { folder: folder.to_path_buf(), wanted, writing, _lock: lock }
    }

    /// Sets the unsaved project; none where all is saved.
    pub fn want(&self, project: Option<Arc<Project>>) {
        let mut wanted = locked(&self.wanted);
        (wanted.project, wanted.is_due) = (project, true);
    }

    /// Protects the file from changes until the user has answered about its contents.
    pub fn hold(&self, is_held: bool) {
        locked(&self.wanted).is_held = is_held;
    }

    /// Writes or removes the file as requested last. May be called from any thread; waits for another writer.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Io`]; the request stays pending.
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

    /// Saves with `save`, and drops the requested contents. Also returns whether the file was removed; a file that
    /// remains has the same contents as the saved project.
    ///
    /// # Errors
    /// The error of `save`; the request stays as before.
    pub fn saved<T>(&self, save: impl FnOnce() -> Result<T>) -> Result<(T, Result<()>)> {
        let _writing = locked(&self.writing);
        let saved = save()?;
        Ok((saved, self.forget_held()))
    }

    /// Drops the unsaved changes and removes the file.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Io`] when the file cannot be removed.
    pub fn forget(&self) -> Result<()> {
        let _writing = locked(&self.writing);
        self.forget_held()
    }

    fn forget_held(&self) -> Result<()> {
        *locked(&self.wanted) = AutosaveContents::default();
        forget_unsaved(&self.folder)
    }
}

impl Drop for AutosaveWriter {
    fn drop(&mut self) {
        // An error cannot be reported any more.
        let _ = self.write();
    }
}

/// Locks a mutex, also after a panic: that leaves the file complete, because it changes by one rename.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Ends the window from outside, as a signal does: without questions, and without losing changes.
#[derive(Clone, Default)]
pub struct Ending(Arc<Outside>);

#[derive(Default)]
struct Outside {
    is_asked: AtomicBool,
    waker: OnceLock<Waker>,
    autosave: Mutex<Weak<AutosaveWriter>>,
    /// The folder of the project that was open last.
    folder: Mutex<PathBuf>,
}

impl Ending {
    /// Requests the window to close without questions. May be called from any thread. When this returns, unsaved
    /// changes are on disk, except for masks that are being written: the window waits for them before it closes.
    pub fn request(&self) {
        self.0.is_asked.store(true, Ordering::Relaxed);
        let autosave = locked(&self.0.autosave).upgrade();
        if let Some(autosave) = autosave {
            // An error cannot be reported any more.
            let _ = autosave.write();
        }
        if let Some(waker) = self.0.waker.get() {
            waker.wake();
        }
    }

    /// Returns whether closing was requested.
    pub fn is_asked(&self) -> bool {
        self.0.is_asked.load(Ordering::Relaxed)
    }

    /// Sets the window to be woken.
    pub fn wakes(&self, waker: &Waker) {
        let _ = self.0.waker.set(waker.clone());
    }

    /// Sets the autosave of the open project.
    pub fn keeps(&self, autosave: &Arc<AutosaveWriter>) {
        *locked(&self.0.autosave) = Arc::downgrade(autosave);
        locked(&self.0.folder).clone_from(&autosave.folder);
    }

    /// Returns the project that has unsaved changes in its autosave, once the window is gone.
    pub fn left_behind(&self) -> Option<PathBuf> {
        let folder = locked(&self.0.folder).clone();
        folder.join(UNSAVED_FILE).is_file().then_some(folder)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_io::project::{read_project, write_project};
    use quadratura_io::recovery::read_unsaved;
    use quadratura_layers::Options;

    fn project(margin: u32) -> Arc<Project> {
        let text = r#"{"version": 1, "photos": "p", "cameras": "c", "model": "m.obj"}"#;
        let project: Project = serde_json::from_str(text).unwrap();
        Arc::new(Project { options: Options { margin, ..Options::default() }, ..project })
    }

    fn bench() -> (tempfile::TempDir, Arc<AutosaveWriter>) {
        let folder = tempfile::tempdir().unwrap();
        write_project(folder.path(), &project(0)).unwrap();
        let lock = Arc::new(ProjectLock::take(folder.path()).unwrap());
        let autosave = Arc::new(AutosaveWriter::new(folder.path(), lock));
        (folder, autosave)
    }

    fn kept(folder: &Path) -> Option<u32> {
        let found = read_unsaved(folder, &read_project(folder).unwrap()).unwrap();
        found.map(|found| found.project.options.margin)
    }

    #[test]
    fn whoever_ends_the_program_leaves_what_was_wanted_last() {
        let (folder, autosave) = bench();
        autosave.want(Some(project(1)));
        autosave.want(Some(project(2)));
        assert_eq!(kept(folder.path()), None, "a job would have written it");
        let ending = Ending::default();
        ending.keeps(&autosave);
        ending.request();
        assert_eq!((kept(folder.path()), ending.is_asked()), (Some(2), true));
        assert_eq!(ending.left_behind().as_deref(), Some(folder.path()));
        autosave.want(Some(project(3)));
        let panicked = std::thread::spawn(move || {
            let _autosave = autosave;
            panic!("the display is gone");
        });
        assert!(panicked.join().is_err());
        assert_eq!(kept(folder.path()), Some(3));
        ProjectLock::take(folder.path()).unwrap();
    }

    #[test]
    fn what_is_saved_or_forgotten_is_not_written_by_a_job_that_comes_late() {
        let (folder, autosave) = bench();
        autosave.want(Some(project(1)));
        autosave.saved(|| write_project(folder.path(), &project(1))).unwrap().1.unwrap();
        autosave.write().unwrap();
        assert!(!folder.path().join(UNSAVED_FILE).exists());
        autosave.want(Some(project(2)));
        autosave.write().unwrap();
        autosave.forget().unwrap();
        drop(autosave);
        assert!(!folder.path().join(UNSAVED_FILE).exists());
    }

    #[test]
    fn what_somebody_is_asked_about_stays_until_it_is_answered() {
        let (folder, autosave) = bench();
        write_unsaved(folder.path(), &project(7)).unwrap();
        autosave.hold(true);
        autosave.want(Some(project(1)));
        autosave.write().unwrap();
        assert_eq!(kept(folder.path()), Some(7));
        autosave.hold(false);
        autosave.write().unwrap();
        assert_eq!(kept(folder.path()), Some(1));
    }

    #[test]
    fn what_cannot_be_written_stays_wanted() {
        let (folder, autosave) = bench();
        autosave.want(Some(project(1)));
        let (file, aside) = (folder.path().join("project.json"), folder.path().join("aside.json"));
        std::fs::rename(&file, &aside).unwrap();
        autosave.write().unwrap_err();
        std::fs::rename(&aside, &file).unwrap();
        autosave.write().unwrap();
        assert_eq!(kept(folder.path()), Some(1));
    }
}
