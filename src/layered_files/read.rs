//! Reads any layered file, recognised by its content, not by its name.

use std::io::{self, ErrorKind};
use std::path::Path;

use super::bytes::FileBytes;
use super::edited::{EditedDocument, SAVE_AGAIN};
use super::format::{file_names, formats};
use super::{KEY_FILE, folder};
use crate::recognise::is_document;
use quadratura_base::error::{Error, Result};
use quadratura_files::guarded::guarded;

/// Reads a layered image: a PSD or PSB, an XCF, an OpenRaster file, or an exported folder (or the
/// `stack.json` in it). Pixels stay in the file until they are requested; if the file is rewritten meanwhile,
/// reading them fails.
///
/// # Errors
/// [`Error::Input`] with place, finding, expectation and remedy when the file is none of these, damaged, or
/// of an unsupported kind; [`Error::Io`] when it cannot be opened.
pub fn read_layered(path: &Path) -> Result<EditedDocument> {
    guarded(path, SAVE_AGAIN, || opened(path))
}

fn opened(path: &Path) -> Result<EditedDocument> {
    if path.is_dir() {
        return folder::read::read(path);
    }
    if path.file_name().is_some_and(|name| name == folder::read::STACK_FILE) {
        return folder::read::read(path.parent().unwrap_or(Path::new(".")));
    }
    let metadata = path.metadata().map_err(|error| unreachable(path, &error))?;
    // Reading a pipe could block forever.
    if !metadata.is_file() {
        let found = format!("this is not a regular file; expected {} or a folder", file_names());
        return Err(Error::input(path, "the file", found, "give the file that the image editor saved"));
    }
    let bytes = FileBytes::open(path).map_err(|error| match error {
        Error::Io { source, .. } => unreachable(path, &source),
        error => error,
    })?;
    // All signatures fit into 16 bytes.
    let beginning = bytes.read(0, bytes.length().min(16))?;
    let files = formats().filter_map(|format| format.file.as_ref());
    match files.into_iter().find(|file| beginning.starts_with(file.signature)) {
        Some(file) => (file.read)(&bytes),
        None => Err(unknown(path, &beginning)),
    }
}

fn unreachable(path: &Path, error: &io::Error) -> Error {
    let (found, remedy) = match error.kind() {
        ErrorKind::NotFound => {
            ("the file does not exist".to_owned(), "check the path, and save in the image editor")
        }
        ErrorKind::PermissionDenied => {
            ("no permission to read the file".into(), "give yourself read permission")
        }
        _ => (format!("the file cannot be read ({error})"), "copy the file to another place and import that"),
    };
    Error::input(path, "", found, remedy)
}

/// Returns the error for an unknown format; common ones are recognised by how they begin.
fn unknown(path: &Path, beginning: &[u8]) -> Error {
    let folder = path.parent().filter(|folder| folder.join(KEY_FILE).is_file());
    let whole = folder.map(|folder| format!("give the folder that contains it: {}", folder.display()));
    let as_psd = || whole.clone().unwrap_or_else(|| AS_PSD.to_owned());
    // A file that has the extension of a layered format has lost its beginning.
    let save_again = || whole.clone().unwrap_or_else(|| SAVE_AGAIN.to_owned());
    let has_layered_extension = is_document(path);
    let (found, remedy) = match beginning {
        [] => ("an empty file".to_owned(), "wait until the image editor has saved it".to_owned()),
        [0x89, b'P', b'N', b'G', ..] => ("a PNG, which has no layers".into(), as_psd()),
        [0xff, 0xd8, ..] => ("a JPEG, which has no layers".into(), as_psd()),
        [b'I', b'I', ..] | [b'M', b'M', ..] => ("a TIFF, whose layers are not read".into(), as_psd()),
        other if has_layered_extension => {
            let found = format!("the file is damaged: it begins with \"{}\"", other.escape_ascii());
            (found, save_again())
        }
        other => (format!("the file begins with \"{}\"", other.escape_ascii()), as_psd()),
    };
    Error::input(path, "byte 0", format!("{found}; expected {} or a folder", file_names()), remedy)
}

const AS_PSD: &str = "save it from the image editor as PSD";
