//! Where a page goes: never over files that the program did not write, or that were changed since.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use quadratura_base::error::{Error, Result};
use quadratura_files::atomic::create_folder_with;
use quadratura_files::free_path::{FreePath, free_path};
use quadratura_files::hash::hash_bytes;

/// The file that lists the others with their hashes.
pub(super) const MANIFEST: &str = "quadratura-page.json";

/// Where a page is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PagePlace {
    /// The folder; what exists there is an unchanged page of this program, or empty.
    pub folder: PathBuf,
    /// Existing files and folders of that name that are kept.
    pub spared: Vec<PathBuf>,
}

#[derive(Serialize, Deserialize)]
struct Manifest {
    format: String,
    files: BTreeMap<String, String>,
}

/// Returns the manifest of files as the last of them.
pub(super) fn manifest(files: &[(String, Vec<u8>)]) -> (String, Vec<u8>) {
    let hashes = files.iter().map(|(name, bytes)| (name.clone(), hash_bytes(bytes))).collect();
    let manifest = Manifest { format: "quadratura-page".to_owned(), files: hashes };
    let mut text = serde_json::to_vec_pretty(&manifest).expect("plain data is JSON");
    text.push(b'\n');
    (MANIFEST.to_owned(), text)
}

/// Returns the first of `NAME`, `NAME-2` and so on that is free, empty, or an unchanged page of this program.
pub fn place_of_page(out: &Path) -> PagePlace {
    let FreePath { path, spared } = free_path(out, is_unchanged);
    PagePlace { folder: path, spared }
}

/// Returns whether a folder is empty or holds the files of its manifest, unchanged, and nothing else.
fn is_unchanged(folder: &Path) -> bool {
    let Ok(entries) = fs::read_dir(folder) else { return false };
    let names: Vec<String> =
        entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    if names.is_empty() {
        return true;
    }
    let Some(manifest) = fs::read(folder.join(MANIFEST))
        .ok()
        .and_then(|bytes| serde_json::from_slice::<Manifest>(&bytes).ok())
    else {
        return false;
    };
    let is_as_written = |name: &String| {
        name == MANIFEST
            || manifest.files.get(name).is_some_and(|hash| {
                fs::read(folder.join(name)).is_ok_and(|bytes| hash_bytes(&bytes) == *hash)
            })
    };
    names.iter().all(is_as_written)
}

/// Creates the folder with what `write` puts into the one that it is given. The page that it replaces is moved away before,
/// and back if writing fails.
pub(super) fn put(place: &PagePlace, write: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
    let folder = &place.folder;
    let is_page = folder.join(MANIFEST).is_file();
    if !is_page {
        return create_folder_with(folder, write);
    }
    let absolute = std::path::absolute(folder).map_err(Error::io(folder, "find the folder"))?;
    let parent = absolute.parent().unwrap_or(Path::new("."));
    let beside = tempfile::Builder::new().prefix(".quadratura-").tempdir_in(parent);
    let beside = beside.map_err(Error::io(parent, "create a folder in it"))?;
    let (new, old) = (beside.path().join("new"), beside.path().join("old"));
    create_folder_with(&new, write)?;
    fs::rename(folder, &old).map_err(Error::io(folder, "move the former page away"))?;
    let Err(error) = fs::rename(&new, folder) else { return Ok(()) };
    if fs::rename(&old, folder).is_err() {
        // The former page stays where it is; whoever reads the error finds it there.
        let kept = beside.keep().join("old");
        return Err(Error::io(&kept, "put the former page, which is here now, back in its place")(error));
    }
    Err(Error::io(folder, "put the page in place")(error))
}
