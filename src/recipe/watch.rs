//! `watch`: whatever an image editor saves in a folder is imported.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use super::import::{ImportOptions, Imported, Recall, import};
use crate::error::{Error, Result};
use crate::io::documents::{Stamp, documents};
use crate::io::exports::ExportStore;
use crate::io::hash::hash_file;
use crate::io::lock::ProjectLock;
use crate::io::watch::FolderWatch;
use crate::task::Task;

/// A file is complete when it stays as it is for so long, and can be read to its end.
const STEADY: Duration = Duration::from_millis(150);
/// A file that cannot be read is tried again for so long: editors write large files slowly.
const PATIENCE: Duration = Duration::from_secs(10);
/// How often a request to stop is looked for.
const LISTEN: Duration = Duration::from_millis(200);
/// How often the project's lock is tried while another program writes to it.
const LOCK_AGAIN: Duration = Duration::from_millis(300);

/// How to watch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WatchOptions {
    /// As for an import.
    pub import: ImportOptions,
    /// End after the first import that changed something.
    pub once: bool,
    /// Documents that were last changed before this are taken for known: they are imported once they are saved
    /// again.
    pub since: Option<SystemTime>,
}

/// Imports every document in `folder` and its sub-folders whenever it was saved, until somebody asks to stop; `told`
/// hears of every import. What was changed before is imported first.
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
    let mut watching = Watching {
        project,
        folder,
        options,
        task,
        taken: BTreeMap::new(),
        failing: BTreeMap::new(),
        recall: Recall::default(),
    };
    if let Some(since) = options.since {
        let known = documents(folder)?.into_iter().filter(|(_, stamp)| stamp.last_change() <= Some(since));
        watching.taken.extend(known);
    }
    loop {
        let round = watching.round().and_then(|due| watching.import(&due, &hold));
        let (imported, spent) = match round {
            Err(Error::Cancelled) => return Ok(()),
            round => round?,
        };
        let ends = options.once && imported.number.is_some();
        if !imported.files.is_empty() || !imported.failed.is_empty() {
            told(imported, spent);
        }
        if task.go_on().is_err() || ends {
            return Ok(());
        }
        events.wait(LISTEN);
    }
}

struct Watching<'a> {
    project: &'a Path,
    folder: &'a Path,
    options: WatchOptions,
    task: &'a Task,
    /// As they were when they were imported, or found to be exports that nobody changed.
    taken: BTreeMap<PathBuf, Stamp>,
    /// Since when a document cannot be read.
    failing: BTreeMap<PathBuf, Instant>,
    /// Most layers of a file are as they were when it was saved last.
    recall: Recall,
}

impl Watching<'_> {
    /// The documents that were saved and are complete.
    fn round(&mut self) -> Result<Vec<(PathBuf, Stamp)>> {
        let changed = |found: BTreeMap<PathBuf, Stamp>, taken: &BTreeMap<PathBuf, Stamp>| {
            found.into_iter().filter(|(path, stamp)| taken.get(path) != Some(stamp)).collect::<Vec<_>>()
        };
        let first = changed(documents(self.folder)?, &self.taken);
        if first.is_empty() {
            return Ok(first);
        }
        std::thread::sleep(STEADY);
        self.task.go_on()?;
        let second = changed(documents(self.folder)?, &self.taken);
        let steady: Vec<_> = second.into_iter().filter(|document| first.contains(document)).collect();
        let own = self.own_files(&steady)?;
        let (ours, due): (Vec<_>, Vec<_>) = steady.into_iter().partition(|(path, _)| own.contains(path));
        self.taken.extend(ours);
        Ok(due)
    }

    /// Those that are as we exported them.
    fn own_files(&self, documents: &[(PathBuf, Stamp)]) -> Result<BTreeSet<PathBuf>> {
        let files: Vec<_> = documents.iter().filter(|(path, _)| path.is_file()).collect();
        if files.is_empty() {
            return Ok(BTreeSet::new());
        }
        let (records, _) = ExportStore::new(self.project.join("exports")).read_all()?;
        let written: BTreeSet<&str> =
            records.iter().flat_map(|record| &record.files).map(|file| file.hash.as_str()).collect();
        let is_own = |path: &Path| hash_file(path).is_ok_and(|hash| written.contains(hash.as_str()));
        Ok(files.into_iter().filter(|(path, _)| is_own(path)).map(|(path, _)| path.clone()).collect())
    }

    fn import<Held>(
        &mut self,
        due: &[(PathBuf, Stamp)],
        hold: &impl Fn() -> Result<Held>,
    ) -> Result<(Imported, Duration)> {
        if due.is_empty() {
            return Ok((Imported::default(), Duration::ZERO));
        }
        let held = hold()?;
        let started = Instant::now();
        let mut imported = self.import_patiently(due)?;
        drop(held);
        let failing = &mut self.failing;
        imported.failed.retain(|(path, _)| {
            failing.entry(path.clone()).or_insert_with(Instant::now).elapsed() >= PATIENCE
        });
        for (path, stamp) in due {
            let read = imported.files.iter().any(|report| report.file == *path);
            if read || imported.failed.iter().any(|(failed, _)| failed == path) {
                self.failing.remove(path);
                self.taken.insert(path.clone(), stamp.clone());
            }
        }
        Ok((imported, started.elapsed()))
    }

    /// What cannot be read may still be written: it is tried again, and in the end what can be read of it is taken.
    fn import_patiently(&self, due: &[(PathBuf, Stamp)]) -> Result<Imported> {
        let worn = |path: &PathBuf| self.failing.get(path).is_some_and(|since| since.elapsed() >= PATIENCE);
        let files = due.iter().map(|(path, _)| path.clone());
        let (worn, fresh): (Vec<PathBuf>, Vec<PathBuf>) = files.partition(worn);
        let whole = ImportOptions { only_whole: true, ..self.options.import };
        let mut imported = import(self.project, &fresh, whole, &self.recall, self.task)?;
        if !worn.is_empty() {
            let rest = import(self.project, &worn, self.options.import, &self.recall, self.task)?;
            imported.number = rest.number.or(imported.number);
            imported.changed += rest.changed;
            imported.files.extend(rest.files);
            imported.failed.extend(rest.failed);
        }
        Ok(imported)
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
