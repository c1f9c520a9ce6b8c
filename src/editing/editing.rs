//! Documents for the image editor: which document of a photo is opened for painting, and where these documents are.

use std::path::{Path, PathBuf};

use crate::export::{ExportOptions, export};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Photo;
use quadratura_base::task::Task;
use quadratura_document::Stack;
use quadratura_document::export_record::{ExportFormat, ExportRecord};
use quadratura_document::paint::PaintBook;
use quadratura_io::exports::ExportStore;
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_store::StackStore;

/// The project's subfolder of documents for painting, beside `exports/` with their records. It contains the
/// artist's own files, so nothing in it is ever removed, nor overwritten once it was changed.
pub const FOLDER: &str = "editing";

/// Returns the folder of documents for painting.
pub fn folder(project: &Path) -> PathBuf {
    project.join(FOLDER)
}

/// A document to be opened in an image editor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EditDocument {
    /// The file.
    pub file: PathBuf,
    /// Whether the document existed and was painted on before.
    pub begun: bool,
}

/// Returns a photo's document to paint on: the most recently changed one that was exported from the current layers,
/// or else a new export with `options`, whose layer [`ExportOptions::selected`] is the one to paint on. With
/// `fresh` it is always a new export. Documents that were changed after their export are never overwritten. The
/// caller holds the project's lock.
///
/// # Errors
/// Returns the errors of [`export`] for the project and the photo.
pub fn document_to_edit(
    project: &Path,
    photo: &Photo,
    options: &ExportOptions,
    fresh: bool,
    task: &Task,
) -> Result<EditDocument> {
    let stack = StackStore::new(project).current(&photo.name)?;
    if let Some(stack) = stack.filter(|_| !fresh) {
        let (records, _) = ExportStore::new(project.join("exports")).read_all()?;
        let book = PaintStore::new(project).read()?;
        let found = begun(&book, &records, &stack, options.format).into_iter().map(|path| project.join(path));
        let newest = found.filter(|file| file.is_file()).max_by_key(|file| {
            let changed = file.metadata().and_then(|metadata| metadata.modified()).ok();
            (changed, file.clone())
        });
        if let Some(file) = newest {
            return Ok(EditDocument { file, begun: true });
        }
    }
    let mut exported = export(project, &[photo], &folder(project), options, task)?;
    match (exported.done.pop(), exported.failed.pop()) {
        (Some(report), _) => Ok(EditDocument { file: report.path, begun: false }),
        (None, Some((_, error))) => Err(error),
        (None, None) => Err(Error::Request(format!("{}: nothing was exported", photo.name))),
    }
}

/// Returns the documents with paint, as paths from the project, that are in [`FOLDER`] and were exported from this
/// stack in this format.
fn begun(book: &PaintBook, records: &[ExportRecord], stack: &Stack, format: ExportFormat) -> Vec<String> {
    let is_current = |key: &str| {
        let record = records.iter().find(|record| record.key == key);
        record.is_some_and(|record| {
            record.photo == stack.photo
                && record.inputs == stack.inputs
                && record.format == format
                && record.evened.is_none()
        })
    };
    let documents = book.documents.keys().filter_map(|document| document.split_once('@'));
    let of_stack = documents.filter(|(key, path)| is_current(key) && path.starts_with(&format!("{FOLDER}/")));
    of_stack.map(|(_, path)| path.to_owned()).collect()
}
