//! To the image editor and on with it: which document of a photo is opened, and where those documents lie.

use std::path::{Path, PathBuf};

use super::export::{ExportOptions, export};
use crate::document::Stack;
use crate::document::export_record::{ExportFormat, ExportRecord};
use crate::document::paint::PaintBook;
use crate::error::{Error, Result};
use crate::io::exports::ExportStore;
use crate::io::paint_store::PaintStore;
use crate::io::stack_store::StackStore;
use crate::scene::Photo;
use crate::task::Task;

/// Where documents lie that are painted on, in the project's folder: beside `exports/`, which tells them. It holds
/// the artist's own files, so nothing in it is ever removed, or overwritten once it was changed.
pub const FOLDER: &str = "editing";

/// The folder of documents that are painted on.
pub fn folder(project: &Path) -> PathBuf {
    project.join(FOLDER)
}

/// A document to be opened in an image editor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ToEdit {
    /// The file.
    pub file: PathBuf,
    /// It was painted on before, and holds what its artist left in it.
    pub begun: bool,
}

/// The document of a photo to go on with: the one that was painted on last, if it is of the layers as they are now,
/// else a new export with `options`, whose layer [`ExportOptions::selected`] is the one that is painted on. `fresh`: a new
/// export in any case. What was changed since it was exported is never overwritten. Whoever calls holds the project's lock.
///
/// # Errors
/// What [`export`] says of the project and of the photo.
pub fn to_edit(
    project: &Path,
    photo: &Photo,
    options: &ExportOptions,
    fresh: bool,
    task: &Task,
) -> Result<ToEdit> {
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
            return Ok(ToEdit { file, begun: true });
        }
    }
    let mut exported = export(project, &[photo], &folder(project), options, task)?;
    match (exported.done.pop(), exported.failed.pop()) {
        (Some(report), _) => Ok(ToEdit { file: report.path, begun: false }),
        (None, Some((_, error))) => Err(error),
        (None, None) => Err(Error::Request(format!("{}: nothing was exported", photo.name))),
    }
}

/// The documents with paint, as paths from the project, that lie in [`FOLDER`] and were exported of this stack as it
/// is, in this format.
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
