//! Import from the image editor: edited files are compared with what was exported, and the differences become the
//! project's paint, by surface. Nothing else of the project is changed except masks, and the last imports can be
//! undone.

pub mod before_after;
mod colours;
mod compare;
pub mod context;
pub mod elsewhere;
pub mod file;
mod gather;
mod identify;
pub mod layer;
mod mask;
mod merged;
pub mod originals;
pub mod pictures;
mod place;
pub mod question;
mod real;
mod recall;
pub mod report;
mod scaled;
pub(super) mod session;
pub(super) mod settle;
pub(super) mod share;
mod shift;
mod tones;
mod turned;

use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use self::recall::LayerCache;

use self::context::ReadContext;
use self::elsewhere::PaintElsewhere;
use self::file::FilePaint;
use self::mask::MaskSession;
use self::originals::ExportedPixels;
use self::question::Question;
use self::report::{FileReport, LayerState};
use self::session::{PaintMade, PaintSession, PaintedPlace};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_document::export_record::ExportRecord;
use quadratura_document::masks::MaskChange;
use quadratura_document::paint::{PaintBook, PaintImport, PaintedDocument, PaintedView};
use quadratura_files::stamp::Stamp;
use quadratura_io::baselines::Baselines;
use quadratura_io::documents::documents;
use quadratura_io::exports::ExportStore;
use quadratura_io::import_ledger::{ImportLedger, remove_leftovers_of_import};
use quadratura_io::paint_store::PaintStore;
use quadratura_io::project::{change_project, read_project, relative_to};
use quadratura_layered_files::folder::read::STACK_FILE;
use quadratura_layered_files::format::file_names;
use quadratura_layered_files::read_layered;
use quadratura_layered_files::recognise::is_exported_folder;
use quadratura_sites::side_by_side::{done_and_failed, one_by_one};

/// Options of [`import`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ImportOptions {
    /// Whether the import is only simulated and reported.
    pub dry_run: bool,
    /// Whether paint of images that were scaled is imported.
    pub scaled: bool,
    /// Whether a file is rejected when one of its layers cannot be read, because it may still be being written;
    /// otherwise the layer is left out.
    pub only_whole: bool,
    /// Whether the paint stays in its photo: it is not projected to other photos.
    pub only_here: bool,
    /// Whether paint is left out where a photo, this one or another, shows the surface.
    pub only_unseen: bool,
    /// Whether a file is imported in which most pixels of most layers have changed at once; otherwise nothing of it is.
    pub all: bool,
}

/// The results for all files, in their order.
#[derive(Debug, Default)]
pub struct Imported {
    /// The number of the import; `None` when it changed nothing.
    pub number: Option<u32>,
    /// The number of pixels whose paint or masking changed.
    pub changed: u64,
    /// The number of these whose masking changed.
    pub masked: u64,
    /// The masks that were added, replaced or removed.
    pub masks: Vec<MaskChange>,
    /// The paint of other photos that differs at the same places, which these photos keep.
    pub elsewhere: Vec<PaintElsewhere>,
    /// The reports of files that were read.
    pub files: Vec<FileReport>,
    /// The reports of files of which nothing was imported, because so much has changed at once; see
    /// [`ImportOptions::all`].
    pub questioned: Vec<FileReport>,
    /// The files that failed, with the reasons.
    pub failed: Vec<(PathBuf, Error)>,
    /// The project's paint as it is now, so that it need not be read again.
    pub book: Arc<PaintBook>,
}

/// The stage that is reported.
pub const STAGE: &str = "import";

/// Imports edited files into the project in the folder `project`, as one import that can be undone as a whole. For
/// a folder that is not an export, all layered files in it are imported. An error in one file is in
/// [`Imported::failed`], and an unreadable layer is left out; neither stops the others. `recall` makes the next
/// import of the same file fast. The caller holds the project's lock, unless it is a dry run.
///
/// # Errors
/// Returns [`Error::Io`] and [`Error::Input`] when the records of exports or the project's paint cannot be read, or
/// nothing can be written, or [`Error::Cancelled`]. The project's paint is then unchanged.
pub fn import(
    project: &Path,
    files: &[PathBuf],
    options: ImportOptions,
    recall: &LayerCache,
    task: &Task,
) -> Result<Imported> {
    let exports = project.join("exports");
    let (records, problems) = task.timed("read records", || ExportStore::new(&exports).read_all())?;
    problems.iter().for_each(|problem| task.note(problem));
    let known = read_project(project)?;
    let mut session = ImportSession {
        records,
        kept: Baselines::new(&exports),
        paint: PaintSession::begin(project, known.fill)?,
        masks: MaskSession::new(known.masks),
        options,
        recall,
    };
    let mut imported = Imported::default();
    let files = documents_of(files, &mut imported.failed)?;
    // One after the other: a file may paint over what one before it brought.
    let reports = one_by_one(STAGE, &files, |file| session.file(file, task), task)?;
    let (reports, failed) = done_and_failed(&files, reports)?;
    (imported.questioned, imported.files) = reports.into_iter().partition(|report| report.question.is_some());
    imported.failed.extend(failed);
    let layers = || imported.files.iter().flat_map(|file| &file.layers);
    let masked: u64 =
        layers().filter(|layer| layer.state == LayerState::Mask).map(|layer| layer.changed).sum();
    (imported.changed, imported.masked) = (layers().map(|layer| layer.changed).sum(), masked);
    if session.paint.changed() || session.masks.changed() {
        imported.number = Some(session.paint.number());
        imported.elsewhere = session.paint.elsewhere(options.only_here)?;
        if !options.dry_run {
            let (masks, book) = task.timed("write paint", || session.commit(&imported))?;
            (imported.masks, imported.book) = (masks, Arc::new(book));
            return Ok(imported);
        }
    }
    imported.book = Arc::new(session.paint.before().clone());
    Ok(imported)
}

/// Imports edited files into the project in the folder `project`, as one import that can be undone as a whole. For a
/// folder that is not an export, all layered files in it are imported. An error in one file is in
/// [`Imported::failed`], and an unreadable layer is left out; neither stops the others. The files are recorded in their
/// present state, so that a later watch of their folder does not import them again, even if this import is undone. The
/// caller holds the project's lock, unless it is a dry run.
///
/// # Errors
/// Returns [`Error::Io`] and [`Error::Input`] when the records of exports or the project's paint cannot be read, or
/// nothing can be written, or [`Error::Cancelled`]. The project's paint is then unchanged.
pub fn import_once(
    project: &Path,
    files: &[PathBuf],
    options: ImportOptions,
    task: &Task,
) -> Result<Imported> {
    if !options.dry_run {
        remove_leftovers_of_import(project)?;
    }
    // Stamps are taken before anything is read, so that a file saved in the meantime counts as changed.
    let documents = documents_of(files, &mut Vec::new())?;
    let stamps: Vec<(PathBuf, Stamp)> =
        documents.into_iter().map(|document| (document.clone(), Stamp::from_path(&document))).collect();
    let imported = import(project, files, options, &LayerCache::default(), task)?;
    // A file that changed nothing may be read again.
    if !options.dry_run && imported.number.is_some() {
        let is_read = |document: &PathBuf| imported.files.iter().any(|report| report.file == *document);
        let read: Vec<_> = stamps.into_iter().filter(|(document, _)| is_read(document)).collect();
        if let Err(error) = ImportLedger::note(project, &read) {
            task.note(&error);
        }
    }
    Ok(imported)
}

/// Returns the error for an export of a species of tree, where a file is one, else this error.
fn tree_export_or(project: &Path, file: &Path, error: Error) -> Error {
    let key = read_layered(file).ok().and_then(|document| document.key);
    let record = key.map(|key| project.join("exports").join("trees").join(format!("{key}.json")));
    if !record.is_some_and(|record| record.is_file()) {
        return error;
    }
    let found = "it is an export of a species of tree, expected one of a photo";
    Error::input(file, "", found, "import it with `quadratura tree import`")
}

/// Returns the given files, with folders that are not exports replaced by the layered files in them.
pub(super) fn documents_of(given: &[PathBuf], failed: &mut Vec<(PathBuf, Error)>) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for path in given {
        if !path.is_dir() || is_exported_folder(path) || path.join(STACK_FILE).is_file() {
            files.push(path.clone());
            continue;
        }
        let found = documents(path)?;
        if found.is_empty() {
            let finding =
                "this folder contains no layered file and is not an exported one (it has no stack.json)";
            let remedy = format!("give {} files, a folder of them, or an exported folder", file_names());
            failed.push((path.clone(), Error::input(path, "", finding, remedy)));
        }
        files.extend(found.into_keys());
    }
    Ok(files)
}

/// Returns the last imports, oldest first.
///
/// # Errors
/// Returns [`Error::Io`] and [`Error::Input`] when the project's paint cannot be read.
pub fn history(project: &Path) -> Result<Vec<PaintImport>> {
    Ok(PaintStore::new(project).read()?.imports)
}

/// Undoes the last import. The caller holds the project's lock.
///
/// # Errors
/// Returns [`Error::Request`] when there is none, or [`Error::Io`] and [`Error::Input`] when the project's paint
/// cannot be read or written.
pub fn take_back(project: &Path) -> Result<PaintImport> {
    take_back_one(project, None).map(|(import, _)| import)
}

/// Undoes the import of this number, or the last one, and returns the project's paint as it is then. The caller holds the
/// project's lock.
///
/// # Errors
/// As [`take_back`]; also [`Error::Request`] when a later import changed what this one brought.
pub fn take_back_one(project: &Path, number: Option<u32>) -> Result<(PaintImport, Arc<PaintBook>)> {
    let store = PaintStore::new(project);
    let before = store.read()?;
    let mut book = before.clone();
    let last = book.imports.last().map(|import| import.number);
    let number = number.or(last).ok_or_else(|| Error::Request("there is no import to undo".into()))?;
    let import = book.take_back_one(number).map_err(|why| Error::Request(why.to_string()))?;
    mask::take_back(project, &import.masks)?;
    store.commit(&book, &before)?;
    let book = store.held(book);
    if read_project(project)?.fill.only_here.imports.contains(&import.number) {
        change_project(project, |project| {
            let mut project = project?;
            project.fill.only_here.imports.remove(&import.number);
            Ok(project)
        })?;
    }
    Ok((import, Arc::new(book)))
}

/// An import in progress.
struct ImportSession<'a> {
    records: Vec<ExportRecord>,
    kept: Baselines,
    /// The paint with this import.
    paint: PaintSession<'a>,
    /// Masks of this import.
    masks: MaskSession,
    options: ImportOptions,
    recall: &'a LayerCache,
}

impl ImportSession<'_> {
    /// Imports one file.
    fn file(&mut self, file: &Path, task: &Task) -> Result<FileReport> {
        let project = self.paint.project();
        let name = |key: &str| format!("{key}@{}", self.path_of(file));
        let originals = ExportedPixels { kept: &self.kept, project, book: self.paint.book() };
        let reading =
            ReadContext { records: &self.records, originals, options: self.options, recall: self.recall };
        let read = |record: &ExportRecord| self.seen_before(&name(&record.key));
        let found =
            file::read(file, reading, &read, task).map_err(|error| tree_export_or(project, file, error));
        let FilePaint { record, mut report, mut layers, mask } = found?;
        let document = name(&record.key);
        let view = PaintedView { photo: record.photo.clone(), camera: record.camera.clone() };
        let known = record.paint.clone();
        let photo = record.photo.name.clone();
        let size = [record.photo.width, record.photo.height];
        let before = self.paint.state();
        let mut weighed = Vec::new();
        for layer in &mut layers {
            let Some(surfaces) = layer.surfaces.take() else { continue };
            let place = PaintedPlace { view: &view, layer: &layer.token, document: &document, known: &known };
            let settled = self.paint.settle(&place, surfaces)?;
            weighed.extend(layer.weighed(settled.changed));
            if let Some(entry) = layer.report.and_then(|index| report.layers.get_mut(index)) {
                entry.changed = settled.changed;
                entry.conflicts = settled.conflicts;
                if entry.state == LayerState::Unchanged && entry.changed > 0 {
                    entry.state = LayerState::Restored;
                }
            }
        }
        weighed.extend(layers.iter().filter(|layer| layer.is_as_before).filter_map(|layer| layer.weighed(0)));
        report.question = Question::of(&weighed).filter(|_| !self.options.all);
        if report.question.is_some() {
            self.paint.restore(before);
            return Ok(report);
        }
        let mut seen: PaintedDocument =
            self.paint.book().documents.get(&document).cloned().unwrap_or_default();
        for layer in layers {
            match layer.seen {
                Some(layer_state) if layer_state.painted > 0 => {
                    drop(seen.layers.insert(layer.token, layer_state))
                }
                Some(_) => drop(seen.layers.remove(&layer.token)),
                None => (),
            }
        }
        if let Some(share) = mask {
            report.layers[share.report].changed =
                self.masks.take(project, &photo, &document, size, share.masked);
        }
        self.paint.note_document(document, seen, &view);
        Ok(report)
    }

    /// Returns the file's path from the project, if there is one; it distinguishes copies of one export.
    fn path_of(&self, file: &Path) -> String {
        relative_to(self.paint.project(), file).unwrap_or_else(|_| file.display().to_string())
    }

    /// Returns what a document's layers showed at its last import. Layers whose paint was lost since are omitted,
    /// so that they are compared again.
    fn seen_before(&self, document: &str) -> PaintedDocument {
        let book = self.paint.book();
        let mut seen = book.documents.get(document).cloned().unwrap_or_default();
        let of_document = book.entries.iter().filter(|entry| entry.document == document);
        for lost in of_document.filter(|entry| self.paint.is_lost(entry)) {
            seen.layers.remove(&lost.layer);
        }
        seen
    }

    /// Writes the paint and the masks. If the program is killed in between, the same file imports the masks again, as
    /// an import that can be undone.
    fn commit(mut self, imported: &Imported) -> Result<(Vec<MaskChange>, PaintBook)> {
        let project = self.paint.project();
        let masks = std::mem::take(&mut self.masks).prepare(project)?;
        let made = PaintMade {
            files: imported.files.iter().map(|file| self.path_of(&file.file)).collect(),
            photos: imported.files.iter().map(|file| file.photo.clone()).collect(),
            pixels: imported.changed,
            masks: masks.imported(),
            brush: None,
        };
        let committed = self.paint.commit(made, self.options.only_here)?;
        masks.commit(project).inspect_err(|_| {
            // The import is atomic: if the masks cannot be written, the paint is undone, too, as far as the disk
            // permits.
            let _ = committed.undone();
        })?;
        Ok((masks.changes, committed.book))
    }
}
