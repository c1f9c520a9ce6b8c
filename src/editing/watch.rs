//! The command `watch`: imports the documents that an image editor saves in a folder.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::import::{ImportOptions, Imported, LayerCache, import};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_files::hash::hash_file;
use quadratura_files::lock::ProjectLock;
use quadratura_files::stamp::Stamp;
use quadratura_io::documents::documents;
use quadratura_io::exports::ExportStore;
use quadratura_io::import_ledger::ImportLedger;
use quadratura_io::watch::FolderWatch;

/// The time for which a file has to stay unchanged, and be readable to its end, to be complete. Most editors rename
/// a complete file into place; one that is still being written is detected by its end.
const STEADY: Duration = Duration::from_millis(50);
/// The default of [`WatchOptions::patience`]. A photo's layers on a slow disk take a few seconds.
const PATIENCE: Duration = Duration::from_secs(10);
/// The interval at which cancellation is checked.
const LISTEN: Duration = Duration::from_millis(200);
/// The interval at which the project's lock is tried while another program holds it.
const LOCK_AGAIN: Duration = Duration::from_millis(300);

/// Options of [`watch`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WatchOptions {
    /// The options of each import.
    pub import: ImportOptions,
    /// Whether to end after the first import that changed something.
    pub once: bool,
    /// The time for which a file that cannot be read to its end is tried again, because editors write large files
    /// slowly. After that, its readable part is imported.
    pub patience: Duration,
}

impl Default for WatchOptions {
    fn default() -> Self {
        Self { import: ImportOptions::default(), once: false, patience: PATIENCE }
    }
}

/// Imports every document in `folder` and its subfolders whenever it is saved, until the task is cancelled, and
/// passes each result to `report`. Documents that were saved before are imported first, unless they were imported
/// in their present state already (see [`ImportLedger`]). `hold` returns what has to be held while the project's
/// paint is written: the lock ([`project_lock`]) or, where the program has that already, whatever synchronises its
/// own writers.
///
/// # Errors
/// Returns [`Error::Request`] when the folder cannot be watched, and the errors of [`import`] that concern the
/// project. A problem with one file is passed to `report` and does not end the watch.
pub fn watch<Held>(
    project: &Path,
    folder: &Path,
    options: WatchOptions,
    hold: impl Fn() -> Result<Held>,
    task: &Task,
    mut report: impl FnMut(Imported, Duration),
) -> Result<()> {
    let events = FolderWatch::new(folder)?;
    let mut watching = WatchState::begin(project, folder, options, task)?;
    loop {
        match watching.round(&hold, &mut report) {
            Err(Error::Cancelled) => return Ok(()),
            Ok(false) => return Ok(()),
            round => drop(round?),
        }
        if task.check_cancelled().is_err() {
            return Ok(());
        }
        events.wait(LISTEN);
    }
}

type StampedDocument = (PathBuf, Stamp);

/// A watch in progress.
struct WatchState<'a> {
    project: &'a Path,
    folder: &'a Path,
    options: WatchOptions,
    task: &'a Task,
    /// The documents with their stamps at the time when they were imported, or recognised as unedited exports.
    seen: BTreeMap<PathBuf, Stamp>,
    /// The documents that were imported in earlier sessions, as stored in the project.
    taken: ImportLedger,
    /// The time since which a document cannot be read.
    failing: BTreeMap<PathBuf, Instant>,
    /// The layers at their last import, because most of a file's layers do not change between two saves.
    recall: LayerCache,
}

impl<'a> WatchState<'a> {
    /// Starts a watch; the documents that were imported before are known from the project.
    fn begin(project: &'a Path, folder: &'a Path, options: WatchOptions, task: &'a Task) -> Result<Self> {
        let taken = ImportLedger::read(project).unwrap_or_else(|error| {
            task.note(&error);
            ImportLedger::none(project)
        });
        let mut seen = documents(folder)?;
        seen.retain(|path, stamp| taken.knows(path, stamp));
        let failing = BTreeMap::new();
        let recall = LayerCache::default();
        Ok(Self { project, folder, options, task, seen, taken, failing, recall })
    }

    /// Imports the saved documents; returns whether to continue.
    fn round<Held>(
        &mut self,
        hold: &impl Fn() -> Result<Held>,
        report: &mut impl FnMut(Imported, Duration),
    ) -> Result<bool> {
        let complete = self.complete_documents()?;
        // A document that cannot be read may still be being written.
        let overdue = |(path, _): &StampedDocument| {
            self.failing.get(path).is_some_and(|since| since.elapsed() >= self.options.patience)
        };
        let (overdue, fresh): (Vec<StampedDocument>, Vec<StampedDocument>) =
            complete.into_iter().partition(overdue);
        for (batch, only_whole) in [(fresh, true), (overdue, false)] {
            if batch.is_empty() {
                continue;
            }
            let _held = hold()?;
            let since = Instant::now();
            let imported = self.import(&batch, only_whole)?;
            let ends = self.options.once && imported.number.is_some();
            // A file with a question is asked about again when the folder is next watched, until it is imported.
            let answered =
                batch.iter().filter(|(path, _)| !imported.questioned.iter().any(|of| of.file == *path));
            let answered: Vec<StampedDocument> = answered.cloned().collect();
            if !(imported.files.is_empty() && imported.failed.is_empty() && imported.questioned.is_empty()) {
                report(imported, since.elapsed());
            }
            self.remember(&answered);
            if ends {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Returns the documents that were saved and are complete.
    fn complete_documents(&mut self) -> Result<Vec<StampedDocument>> {
        let first = self.changed()?;
        if first.is_empty() {
            return Ok(first);
        }
        std::thread::sleep(STEADY);
        self.task.check_cancelled()?;
        let steady: Vec<_> =
            self.changed()?.into_iter().filter(|document| first.contains(document)).collect();
        let own = self.own_files(&steady)?;
        let (ours, others): (Vec<_>, Vec<_>) = steady.into_iter().partition(|(path, _)| own.contains(path));
        self.seen.extend(ours);
        Ok(others)
    }

    /// Returns the documents whose stamp differs from the known one.
    fn changed(&self) -> Result<Vec<StampedDocument>> {
        let mut found = documents(self.folder)?;
        found.retain(|path, stamp| self.seen.get(path) != Some(stamp));
        Ok(found.into_iter().collect())
    }

    /// Returns the documents that are unedited exports. One that was ever painted on does not count, because
    /// exports do not overwrite it.
    fn own_files(&self, documents: &[StampedDocument]) -> Result<BTreeSet<PathBuf>> {
        let may_be = |(path, _): &&StampedDocument| path.is_file() && !self.taken.has(path);
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

    /// Imports documents. With `only_whole`, incomplete ones are left for a later round, until their time is over.
    fn import(&mut self, documents: &[StampedDocument], only_whole: bool) -> Result<Imported> {
        let files: Vec<PathBuf> = documents.iter().map(|(path, _)| path.clone()).collect();
        let options = ImportOptions { only_whole, ..self.options.import };
        let mut imported = import(self.project, &files, options, &self.recall, self.task)?;
        if only_whole {
            for (path, _) in imported.failed.drain(..) {
                self.failing.entry(path).or_insert_with(Instant::now);
            }
            let read = || imported.files.iter().chain(&imported.questioned);
            self.failing.retain(|path, _| !read().any(|report| report.file == *path));
        } else {
            self.failing.retain(|path, _| !files.contains(path));
        }
        self.seen.extend(documents.iter().filter(|(path, _)| !self.failing.contains_key(path)).cloned());
        Ok(imported)
    }

    /// Stores in the project which documents need not be imported again. If that fails, they are read again at the
    /// next opening, which only takes time.
    fn remember(&mut self, batch: &[StampedDocument]) {
        let taken: Vec<StampedDocument> =
            batch.iter().filter(|(path, stamp)| self.seen.get(path) == Some(stamp)).cloned().collect();
        match ImportLedger::note(self.project, &taken) {
            Ok(taken) => self.taken = taken,
            Err(error) => self.task.note(&error),
        }
    }
}

/// Takes the project's lock, waiting while another program holds it, for example for a build.
///
/// # Errors
/// Returns [`Error::Cancelled`], or [`Error::Io`] when the lock cannot be created.
pub fn project_lock(project: &Path, task: &Task) -> Result<ProjectLock> {
    ProjectLock::take_after(project, |_| true, LOCK_AGAIN, task)
}
