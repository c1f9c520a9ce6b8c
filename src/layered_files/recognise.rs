//! Which files and folders are layered documents, by their names.

use std::path::Path;

use crate::KEY_FILE;
use crate::format::extensions;

/// Returns whether `path` is a layered document: a file by its extension, a folder by its key file.
pub fn is_document(path: &Path) -> bool {
    (has_extension(path) && path.is_file()) || is_exported_folder(path)
}

/// Returns whether a path is called as a layered file.
pub fn has_extension(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    extensions().contains(&extension.as_str())
}

/// Returns whether `export --format folder` wrote this folder.
pub fn is_exported_folder(folder: &Path) -> bool {
    folder.join(KEY_FILE).is_file()
}
