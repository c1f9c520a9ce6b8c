//! Whatever an image editor saved: recognised by its content, not by its name.

use std::io::{self, ErrorKind};
use std::path::Path;

use super::bytes::FileBytes;
use super::edited::EditedDocument;
use super::format::file_names;
use super::{FORMATS, KEY_FILE, folder};
use crate::error::{Error, Result};
use crate::io::documents::is_document;

/// Reads what a layered image says: a PSD or PSB, an XCF, an OpenRaster file, or a folder of an export (or
/// the `stack.json` in it). Pixels stay where they are until they are asked for; a file that is written anew
/// in the meantime makes them errors.
///
/// # Errors
/// [`Error::Input`] with place, finding, expectation and remedy when it is none of these, damaged, or of a kind
/// that is not read; [`Error::Io`] when it cannot be opened.
pub fn read_layered(path: &Path) -> Result<EditedDocument> {
    if path.is_dir() {
        return folder::read::read(path);
    }
    if path.file_name().is_some_and(|name| name == folder::read::STACK_FILE) {
        return folder::read::read(path.parent().unwrap_or(Path::new(".")));
    }
    let metadata = path.metadata().map_err(|error| unreachable(path, &error))?;
    // A pipe would be waited for without end.
    if !metadata.is_file() {
        let found = format!("no plain file; expected {} or a folder", file_names());
        return Err(Error::input(path, "the file", found, "give the file that the image editor saved"));
    }
    let bytes = FileBytes::open(path).map_err(|error| match error {
        Error::Io { source, .. } => unreachable(path, &source),
        error => error,
    })?;
    // Few enough for every file that may be one.
    let beginning = bytes.read(0, bytes.length().min(16))?;
    let files = FORMATS.iter().filter_map(|format| format.file.as_ref());
    match files.into_iter().find(|file| beginning.starts_with(file.signature)) {
        Some(file) => (file.read)(&bytes),
        None => Err(unknown(path, &beginning)),
    }
}

fn unreachable(path: &Path, error: &io::Error) -> Error {
    let (found, remedy) = match error.kind() {
        ErrorKind::NotFound => {
            ("there is no such file".to_owned(), "check the path, and save in the image editor")
        }
        ErrorKind::PermissionDenied => ("it may not be read".into(), "give yourself the right to read it"),
        _ => (format!("it cannot be read ({error})"), "copy the file to another place and import that"),
    };
    Error::input(path, "", found, remedy)
}

/// Formats that are often meant, by how they begin.
fn unknown(path: &Path, beginning: &[u8]) -> Error {
    let folder = path.parent().filter(|folder| folder.join(KEY_FILE).is_file());
    let whole = folder.map(|folder| format!("give the folder that it belongs to: {}", folder.display()));
    let as_psd = || whole.clone().unwrap_or_else(|| AS_PSD.to_owned());
    // What says by its name that it is one of these has lost its beginning.
    let once_more = || whole.clone().unwrap_or_else(|| ONCE_MORE.to_owned());
    let is_named_so = is_document(path);
    let (found, remedy) = match beginning {
        [] => ("an empty file".to_owned(), "wait until the image editor has saved it".to_owned()),
        [0x89, b'P', b'N', b'G', ..] => ("a PNG, which has no layers".into(), as_psd()),
        [0xff, 0xd8, ..] => ("a JPEG, which has no layers".into(), as_psd()),
        [b'I', b'I', ..] | [b'M', b'M', ..] => ("a TIFF, whose layers are not read".into(), as_psd()),
        other if is_named_so => {
            let found = format!("it is damaged: it begins with \"{}\"", other.escape_ascii());
            (found, once_more())
        }
        other => (format!("it begins with \"{}\"", other.escape_ascii()), as_psd()),
    };
    Error::input(path, "byte 0", format!("{found}; expected {} or a folder", file_names()), remedy)
}

const AS_PSD: &str = "save it from the image editor as PSD";
const ONCE_MORE: &str = "save it once more from the image editor; what was imported of it before stays";
