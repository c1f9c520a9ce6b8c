//! Back from the image editor: edited files are told from what was exported, and what was painted becomes the
//! project's paint, by surface. Nothing else of the project is written, and the last imports can be taken back.

mod compare;
mod file;
mod gather;
mod identify;
mod layer;
mod mask;
mod merged;
mod originals;
pub mod pictures;
mod place;
mod recall;
pub mod report;
mod scaled;
mod settle;
mod share;
mod shift;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

pub use self::recall::Recall;

use self::file::{FilePaint, Reading};
use self::mask::MaskDesk;
use self::originals::Originals;
use self::report::FileReport;
use self::settle::{Arrival, settle};
use crate::document::export_record::ExportRecord;
use crate::document::masks::MaskChange;
use crate::document::paint::{PaintBook, PaintEntry, PaintImport, PaintedDocument, PaintedView, Patch};
use crate::error::{Error, Result};
use crate::io::baselines::Baselines;
use crate::io::documents::{documents, is_exported_folder};
use crate::io::exports::ExportStore;
use crate::io::layered::folder::read::STACK_FILE;
use crate::io::layered::format::file_names;
use crate::io::paint_store::PaintStore;
use crate::io::project::relative_to;
use crate::io::stamp::Stamp;
use crate::io::taken::{TakenDocuments, clean_up};
use crate::recipe::side_by_side::{done_and_failed, one_by_one};
use crate::task::Task;

/// How to import.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ImportOptions {
    /// Only tell what would be imported.
    pub dry_run: bool,
    /// Take the paint of images home that were scaled.
    pub scaled: bool,
    /// Refuse a file when one of its layers cannot be read, which else is left out: it may still be being written.
    pub only_whole: bool,
}

/// What became of all files, in their order.
#[derive(Debug, Default)]
pub struct Imported {
    /// Number of the import; none when it changed nothing.
    pub number: Option<u32>,
    /// Pixels whose paint is other than it was.
    pub changed: u64,
    /// Masks that came with it, or went.
    pub masks: Vec<MaskChange>,
    /// Those that were read.
    pub files: Vec<FileReport>,
    /// Those that were not, with the reason.
    pub failed: Vec<(PathBuf, Error)>,
    /// The project's paint as it is now, so that nobody needs to read it again.
    pub book: Arc<PaintBook>,
}

/// The stage that is reported.
pub const STAGE: &str = "import";

/// Imports edited files into the project in the folder `project`, as one import that can be taken back as a whole; of
/// a folder that is no export all layered files in it. A fault in one file is in [`Imported::failed`], a layer that
/// cannot be read is left out; the others go on. `recall` makes the next import of the same file fast. Whoever calls
/// holds the project's lock, unless it is a dry run.
///
/// # Errors
/// [`Error::Io`] and [`Error::Input`] when the records of exports or the project's paint cannot be read, or nothing
/// can be written; [`Error::Cancelled`]. The project's paint is then as it was.
pub fn import(
    project: &Path,
    files: &[PathBuf],
    options: ImportOptions,
    recall: &Recall,
    task: &Task,
) -> Result<Imported> {
    let exports = project.join("exports");
    let (records, problems) = task.timed("read records", || ExportStore::new(&exports).read_all())?;
    problems.iter().for_each(|problem| task.note(problem.to_string()));
    let store = PaintStore::new(project);
    let before = store.read()?;
    let mut desk = Desk {
        project,
        records,
        kept: Baselines::new(&exports),
        number: before.next_import(),
        book: before.clone(),
        store,
        pending: BTreeMap::new(),
        masks: MaskDesk::default(),
        options,
        recall,
    };
    let mut imported = Imported::default();
    let files = documents_of(files, &mut imported.failed)?;
    // One after the other: a file may paint over what one before it brought.
    let reports = one_by_one(STAGE, &files, |file| desk.file(file, task), task)?;
    let (reports, failed) = done_and_failed(&files, reports)?;
    imported.files.extend(reports);
    imported.failed.extend(failed);
    imported.changed = imported.files.iter().flat_map(|file| &file.layers).map(|layer| layer.changed).sum();
    if desk.book != before || desk.masks.changed() {
        imported.number = Some(desk.number);
        if !options.dry_run {
            let (masks, book) = task.timed("write paint", || desk.commit(&before, &imported))?;
            (imported.masks, imported.book) = (masks, Arc::new(book));
            return Ok(imported);
        }
    }
    imported.book = Arc::new(before);
    Ok(imported)
}

/// [`import`] for whoever does not watch the files: they are known as they are from now on, so that whoever watches their
/// folder later does not take them home again, also where this import is taken back.
///
/// # Errors
/// As [`import`].
pub fn import_once(
    project: &Path,
    files: &[PathBuf],
    options: ImportOptions,
    task: &Task,
) -> Result<Imported> {
    if !options.dry_run {
        clean_up(project)?;
    }
    // As they are before anything is read: what is saved meanwhile is another save.
    let documents = documents_of(files, &mut Vec::new())?;
    let stamps: Vec<(PathBuf, Stamp)> =
        documents.into_iter().map(|document| (document.clone(), Stamp::of(&document))).collect();
    let imported = import(project, files, options, &Recall::default(), task)?;
    // What changed nothing may be looked at again.
    if !options.dry_run && imported.number.is_some() {
        let is_read = |document: &PathBuf| imported.files.iter().any(|report| report.file == *document);
        let read: Vec<_> = stamps.into_iter().filter(|(document, _)| is_read(document)).collect();
        if let Err(error) = TakenDocuments::note(project, &read) {
            task.note(error.to_string());
        }
    }
    Ok(imported)
}

/// The files that were given, and instead of folders that are no exports the layered files in them.
fn documents_of(given: &[PathBuf], failed: &mut Vec<(PathBuf, Error)>) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for path in given {
        if !path.is_dir() || is_exported_folder(path) || path.join(STACK_FILE).is_file() {
            files.push(path.clone());
            continue;
        }
        let found = documents(path)?;
        if found.is_empty() {
            let finding =
                "a folder without a layered file in it, and no exported one (stack.json is not there)";
            let remedy = format!("give {} files, a folder of them, or an exported folder", file_names());
            failed.push((path.clone(), Error::input(path, "", finding, remedy)));
        }
        files.extend(found.into_keys());
    }
    Ok(files)
}

/// The last imports, oldest first.
///
/// # Errors
/// [`Error::Io`] and [`Error::Input`] when the project's paint cannot be read.
pub fn history(project: &Path) -> Result<Vec<PaintImport>> {
    Ok(PaintStore::new(project).read()?.imports)
}

/// Takes the last import back. Whoever calls holds the project's lock.
///
/// # Errors
/// [`Error::Request`] when there is none; [`Error::Io`] and [`Error::Input`] when the project's paint cannot be read
/// or written.
pub fn take_back(project: &Path) -> Result<PaintImport> {
    take_back_with_book(project).map(|(import, _)| import)
}

/// [`take_back`], and the project's paint as it is then.
///
/// # Errors
/// As [`take_back`].
pub fn take_back_with_book(project: &Path) -> Result<(PaintImport, Arc<PaintBook>)> {
    let store = PaintStore::new(project);
    let mut book = store.read()?;
    let import = book.take_back().ok_or_else(|| Error::Request("there is no import to take back".into()))?;
    mask::take_back(project, &import.masks)?;
    store.commit(&book)?;
    Ok((import, Arc::new(book)))
}

/// An import under way.
struct Desk<'a> {
    project: &'a Path,
    records: Vec<ExportRecord>,
    kept: Baselines,
    store: PaintStore,
    /// As it will be.
    book: PaintBook,
    number: u32,
    /// Paint that has no file yet, by the name that stands in for it.
    pending: BTreeMap<String, Patch>,
    /// Masks that came home.
    masks: MaskDesk,
    options: ImportOptions,
    recall: &'a Recall,
}

impl Desk<'_> {
    fn file(&mut self, file: &Path, task: &Task) -> Result<FileReport> {
        let name = |key: &str| format!("{key}@{}", self.path_of(file));
        let originals = Originals { kept: &self.kept, project: self.project, book: &self.book };
        let reading =
            Reading { records: &self.records, originals, options: self.options, recall: self.recall };
        let read = |record: &ExportRecord| self.seen_before(&name(&record.key));
        let FilePaint { record, mut report, layers, mask } = file::read(file, reading, &read, task)?;
        let document = name(&record.key);
        let view = PaintedView { photo: record.photo.clone(), camera: record.camera.clone() };
        let (view_id, known) = (view_id(&view), record.paint.clone());
        let (photo, size) = (record.photo.name.clone(), [record.photo.width, record.photo.height]);
        let mut seen: PaintedDocument = self.book.documents.get(&document).cloned().unwrap_or_default();
        for layer in layers {
            if let Some(surfaces) = layer.surfaces {
                let arrival = Arrival {
                    photo: &photo,
                    layer: &layer.token,
                    document: &document,
                    import: self.number,
                    view: &view_id,
                    known: &known,
                };
                let settled = settle(&self.book, &arrival, surfaces, &|entry| self.pixels(entry))?;
                if let Some(told) = layer.report.and_then(|index| report.layers.get_mut(index)) {
                    told.changed = settled.changed;
                    told.conflicts = settled.conflicts;
                }
                self.take(settled.removed, settled.added);
            }
            match layer.seen {
                Some(shown) if shown.painted > 0 => drop(seen.layers.insert(layer.token, shown)),
                Some(_) => drop(seen.layers.remove(&layer.token)),
                None => (),
            }
        }
        if let Some(share) = mask {
            report.layers[share.report].changed =
                self.masks.take(self.project, &photo, &document, size, share.masked)?;
        }
        if seen.layers.is_empty() {
            self.book.documents.remove(&document);
        } else {
            self.book.documents.insert(document, seen);
        }
        self.book.views.insert(view_id, view);
        self.book.tidy();
        Ok(report)
    }

    /// The file's path from the project, as far as there is one: who paints on which copy.
    fn path_of(&self, file: &Path) -> String {
        relative_to(self.project, file).unwrap_or_else(|_| file.display().to_string())
    }

    /// What a document's layers showed at its last import. Those whose paint was lost since are looked at anew.
    fn seen_before(&self, document: &str) -> PaintedDocument {
        let mut seen = self.book.documents.get(document).cloned().unwrap_or_default();
        let of_document = self.book.entries.iter().filter(|entry| entry.document == document);
        for lost in of_document.filter(|entry| self.is_lost(entry)) {
            seen.layers.remove(&lost.layer);
        }
        seen
    }

    fn is_lost(&self, entry: &PaintEntry) -> bool {
        !self.pending.contains_key(&entry.file) && self.store.check(entry).is_err()
    }

    fn pixels(&self, entry: &PaintEntry) -> Result<Option<Patch>> {
        match self.pending.get(&entry.file) {
            Some(patch) => Ok(Some(patch.clone())),
            None if self.is_lost(entry) => Ok(None),
            None => self.store.patch(entry).map(Some),
        }
    }

    fn take(&mut self, removed: Vec<PaintEntry>, added: Vec<(PaintEntry, Patch)>) {
        self.book.entries.retain(|entry| !removed.contains(entry));
        for (mut entry, patch) in added {
            // No file of paint is called so: all of them lie in folders.
            entry.file = format!("+{}", self.pending.len());
            (entry.rect, entry.pixels) = (patch.rect(), patch.count());
            self.pending.insert(entry.file.clone(), patch);
            self.book.entries.push(entry);
        }
    }

    /// Writes what is pending, then the book that names it, and at last the masks into `project.json`: after a kill
    /// in between the same file brings them once more, as an import that can be taken back.
    fn commit(mut self, before: &PaintBook, imported: &Imported) -> Result<(Vec<MaskChange>, PaintBook)> {
        for entry in &mut self.book.entries {
            if let Some(patch) = self.pending.get(&entry.file) {
                self.store.add(entry, patch)?;
            }
        }
        let names = |book: &PaintBook| book.entries.iter().map(PaintEntry::name).collect::<Vec<_>>();
        let (old, new) = (names(before), names(&self.book));
        let gone = before.entries.iter().filter(|entry| !new.contains(&entry.name()));
        let keys = self.book.documents.keys().chain(before.documents.keys());
        let changed = keys.filter(|key| self.book.documents.get(*key) != before.documents.get(*key));
        let mut photos: Vec<String> = imported.files.iter().map(|file| file.photo.clone()).collect();
        photos.sort();
        photos.dedup();
        let masks = std::mem::take(&mut self.masks).prepare(self.project)?;
        let import = PaintImport {
            masks: masks.imported(),
            number: self.number,
            time: SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs()),
            files: imported.files.iter().map(|file| self.path_of(&file.file)).collect(),
            photos,
            pixels: imported.changed,
            added: new.iter().filter(|name| !old.contains(name)).cloned().collect(),
            replaced: gone.cloned().collect(),
            documents: changed.map(|key| (key.clone(), before.documents.get(key).cloned())).collect(),
        };
        self.book.remember(import);
        self.book.tidy();
        self.store.commit(&self.book)?;
        masks.commit(self.project).inspect_err(|_| {
            // What cannot be written as a whole is taken back as a whole, as far as the disk allows.
            self.book.take_back();
            let _ = self.store.commit(&self.book);
        })?;
        Ok((masks.changes, self.book))
    }
}

/// A short name of a photo and its camera.
fn view_id(view: &PaintedView) -> String {
    let text = crate::io::json::to_json(view);
    crate::io::hash::hash_bytes(&text)[..12].to_owned()
}
