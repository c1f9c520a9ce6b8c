//! `watch`: whatever an image editor saves in a folder is imported.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::import::{ImportOptions, Imported, Recall, import};
use crate::error::{Error, Result};
use crate::io::documents::documents;
use crate::io::exports::ExportStore;
use crate::io::hash::hash_file;
use crate::io::lock::ProjectLock;
use crate::io::stamp::Stamp;
use crate::io::taken::TakenDocuments;
use crate::io::watch::FolderWatch;
use crate::task::Task;

/// A file is complete when it stays as it is for so long, and can be read to its end. Most editors put it in place by a
/// rename, whole; one that is still being written shows by the second.
const STEADY: Duration = Duration::from_millis(50);
/// A photo's layers on a slow disk take a few seconds.
const PATIENCE: Duration = Duration::from_secs(10);
/// How often a request to stop is looked for.
const LISTEN: Duration = Duration::from_millis(200);
/// How often the project's lock is tried while another program writes to it.
const LOCK_AGAIN: Duration = Duration::from_millis(300);

/// How to watch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WatchOptions {
    /// As for an import.
    pub import: ImportOptions,
    /// End after the first import that changed something.
    pub once: bool,
    /// A file that cannot be read to its end is tried again for so long: editors write large files slowly. Then what
    /// can be read of it is taken.
    pub patience: Duration,
}

impl Default for WatchOptions {
    fn default() -> Self {
        Self { import: ImportOptions::default(), once: false, patience: PATIENCE }
    }
}

/// Imports every document in `folder` and its sub-folders whenever it was saved, until somebody asks to stop; `told`
/// hears of every import. What was saved before is imported first, unless it was taken once as it is:
/// [`TakenDocuments`].
/// `hold` gives what has to be held while the project's paint is written: its lock ([`project_lock`]), or where the
/// program has that already, whatever keeps its own writers apart.
///
/// # Errors
/// [`Error::Request`] when the folder cannot be watched; what [`import`] says of the project. A fault in a file is told
/// and ends nothing.
pub fn watch<Held>(
    project: &Path,
    folder: &Path,
    options: WatchOptions,
    hold: impl Fn() -> Result<Held>,
    task: &Task,
    mut told: impl FnMut(Imported, Duration),
) -> Result<()> {
    let events = FolderWatch::new(folder)?;
    let mut watching = Watching::begin(project, folder, options, task)?;
    loop {
        match watching.round(&hold, &mut told) {
            Err(Error::Cancelled) => return Ok(()),
            Ok(false) => return Ok(()),
            round => drop(round?),
        }
        if task.go_on().is_err() {
            return Ok(());
        }
        events.wait(LISTEN);
    }
}

type Document = (PathBuf, Stamp);

struct Watching<'a> {
    project: &'a Path,
    folder: &'a Path,
    options: WatchOptions,
    task: &'a Task,
    /// As they were when they were imported, or found to be exports that nobody changed.
    seen: BTreeMap<PathBuf, Stamp>,
    /// The same, kept in the project.
    taken: TakenDocuments,
    /// Since when a document cannot be read.
    failing: BTreeMap<PathBuf, Instant>,
    /// Most layers of a file are as they were when it was saved last.
    recall: Recall,
}

impl<'a> Watching<'a> {
    fn begin(project: &'a Path, folder: &'a Path, options: WatchOptions, task: &'a Task) -> Result<Self> {
        let taken = TakenDocuments::read(project).unwrap_or_else(|error| {
            task.note(error.to_string());
            TakenDocuments::none(project)
        });
        let mut seen = documents(folder)?;
        seen.retain(|path, stamp| taken.knows(path, stamp));
        let (failing, recall) = (BTreeMap::new(), Recall::default());
        Ok(Self { project, folder, options, task, seen, taken, failing, recall })
    }

    /// Imports what was saved; whether to go on.
    fn round<Held>(
        &mut self,
        hold: &impl Fn() -> Result<Held>,
        told: &mut impl FnMut(Imported, Duration),
    ) -> Result<bool> {
        let due = self.due()?;
        // What cannot be read may still be being written.
        let worn = |(path, _): &Document| {
            self.failing.get(path).is_some_and(|since| since.elapsed() >= self.options.patience)
        };
        let (worn, fresh): (Vec<Document>, Vec<Document>) = due.into_iter().partition(worn);
        for (batch, only_whole) in [(fresh, true), (worn, false)] {
            if batch.is_empty() {
                continue;
            }
            let _held = hold()?;
            let since = Instant::now();
            let imported = self.import(&batch, only_whole)?;
            let ends = self.options.once && imported.number.is_some();
            if !imported.files.is_empty() || !imported.failed.is_empty() {
                told(imported, since.elapsed());
            }
            self.remember(&batch);
            if ends {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The documents that were saved and are complete.
    fn due(&mut self) -> Result<Vec<Document>> {
        let first = self.changed()?;
        if first.is_empty() {
            return Ok(first);
        }
        std::thread::sleep(STEADY);
        self.task.go_on()?;
        let steady: Vec<_> =
            self.changed()?.into_iter().filter(|document| first.contains(document)).collect();
        let own = self.own_files(&steady)?;
        let (ours, due): (Vec<_>, Vec<_>) = steady.into_iter().partition(|(path, _)| own.contains(path));
        self.seen.extend(ours);
        Ok(due)
    }

    /// The documents that are not as they were when they were seen.
    fn changed(&self) -> Result<Vec<Document>> {
        let mut found = documents(self.folder)?;
        found.retain(|path, stamp| self.seen.get(path) != Some(stamp));
        Ok(found.into_iter().collect())
    }

    /// Those that are as we exported them. One that was painted on never is again: nobody exports over it.
    fn own_files(&self, documents: &[Document]) -> Result<BTreeSet<PathBuf>> {
        let may_be = |(path, _): &&Document| path.is_file() && !self.taken.has(path);
        let files: Vec<_> = documents.iter().filter(may_be).collect();
        if files.is_empty() {
            return Ok(BTreeSet::new());
        }
        let (records, _) = ExportStore::new(self.project.join("exports")).read_all()?;
        let written: BTreeSet<&str> =
            records.iter().flat_map(|record| &record.files).map(|file| file.hash.as_str()).collect();
        let is_own = |path: &Path| hash_file(path).is_ok_and(|hash| written.contains(hash.as_str()));
        Ok(files.into_iter().filter(|(path, _)| is_own(path)).map(|(path, _)| path.clone()).collect())
    }

    /// `only_whole`: what cannot be read to its end is left for another round, until it has had all patience.
    fn import(&mut self, due: &[Document], only_whole: bool) -> Result<Imported> {
        let files: Vec<PathBuf> = due.iter().map(|(path, _)| path.clone()).collect();
        let options = ImportOptions { only_whole, ..self.options.import };
        let mut imported = import(self.project, &files, options, &self.recall, self.task)?;
        if only_whole {
            for (path, _) in imported.failed.drain(..) {
                self.failing.entry(path).or_insert_with(Instant::now);
            }
            self.failing.retain(|path, _| !imported.files.iter().any(|report| report.file == *path));
        } else {
            self.failing.retain(|path, _| !files.contains(path));
        }
        self.seen.extend(due.iter().filter(|(path, _)| !self.failing.contains_key(path)).cloned());
        Ok(imported)
    }

    /// Keeps in the project which documents need not be looked at again. Where that cannot be, they are at the next
    /// opening, and nothing comes of it but time.
    fn remember(&mut self, batch: &[Document]) {
        let taken: Vec<Document> =
            batch.iter().filter(|(path, stamp)| self.seen.get(path) == Some(stamp)).cloned().collect();
        match TakenDocuments::note(self.project, &taken) {
            Ok(taken) => self.taken = taken,
            Err(error) => self.task.note(error.to_string()),
        }
    }
}

/// The project's lock. Another program may be building: that takes a while and is no reason to fail.
///
/// # Errors
/// [`Error::Cancelled`]; [`Error::Io`] when there can be no lock.
pub fn project_lock(project: &Path, task: &Task) -> Result<ProjectLock> {
    let mut said = false;
    loop {
        task.go_on()?;
        match ProjectLock::take(project) {
            Err(Error::Request(held)) => {
                if !std::mem::replace(&mut said, true) {
                    task.note(held);
                }
                std::thread::sleep(LOCK_AGAIN);
            }
            taken => return taken,
        }
    }
}
