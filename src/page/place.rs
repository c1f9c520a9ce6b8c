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
pub const MANIFEST: &str = "quadratura-page.json";

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

/// A file of a page.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PageFile {
    /// The path in the folder, with `/`.
    pub name: String,
    /// The size in bytes.
    pub bytes: u64,
}

/// A page that is being written.
#[derive(Debug)]
pub struct PageFolder {
    folder: PathBuf,
    hashes: BTreeMap<String, String>,
    files: Vec<PageFile>,
}

impl PageFolder {
    /// Writes a file, whose path in the folder is `name`, with `/`.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn write(&mut self, name: &str, bytes: &[u8]) -> Result<()> {
        let file = self.folder.join(name);
        let parent = file.parent().unwrap_or(&self.folder);
        fs::create_dir_all(parent).map_err(Error::io(parent, "create the folder"))?;
        fs::write(&file, bytes).map_err(Error::io(&file, "write it"))?;
        self.hashes.insert(name.to_owned(), hash_bytes(bytes));
        self.files.push(PageFile { name: name.to_owned(), bytes: bytes.len() as u64 });
        Ok(())
    }

    /// Returns the files that were written so far.
    pub fn files(&self) -> &[PageFile] {
        &self.files
    }

    fn finish(mut self) -> Result<Vec<PageFile>> {
        let manifest =
            Manifest { format: "quadratura-page".to_owned(), files: std::mem::take(&mut self.hashes) };
        let mut text = serde_json::to_vec_pretty(&manifest).expect("plain data is JSON");
        text.push(b'\n');
        self.write(MANIFEST, &text)?;
        Ok(self.files)
    }
}

/// Returns the first of `NAME`, `NAME-2` and so on that is free, empty, or an unchanged page of this program.
pub fn place_of_page(out: &Path) -> PagePlace {
    let FreePath { path, spared } = free_path(out, is_unchanged);
    PagePlace { folder: path, spared }
}

/// Returns whether a folder is empty or holds the files of its manifest, unchanged, and nothing else.
fn is_unchanged(folder: &Path) -> bool {
    let Some(names) = names_below(folder, "") else { return false };
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

/// Returns the paths of all files below a folder, with `/` and after `prefix`; `None` where it is none, or cannot be read. A folder
/// without files counts as one, since the program makes none.
fn names_below(folder: &Path, prefix: &str) -> Option<Vec<String>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).ok()? {
        let entry = entry.ok()?;
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        if entry.file_type().ok()?.is_dir() {
            let below = names_below(&entry.path(), &format!("{name}/"))?;
            names.extend(if below.is_empty() { vec![name] } else { below });
        } else {
            names.push(name);
        }
    }
    Some(names)
}

/// Creates the folder with what `write` puts into the one that it is given, and with a manifest. The page that it replaces is moved
/// away before, and back if writing fails. Returns the files.
///
/// # Errors
/// The errors of `write`, and [`Error::Io`].
pub fn put(place: &PagePlace, write: impl FnOnce(&mut PageFolder) -> Result<()>) -> Result<Vec<PageFile>> {
    let folder = &place.folder;
    let filled = |at: &Path| {
        let mut page = PageFolder { folder: at.to_owned(), hashes: BTreeMap::new(), files: Vec::new() };
        write(&mut page)?;
        page.finish()
    };
    let is_page = folder.join(MANIFEST).is_file();
    if !is_page {
        return create_folder_with(folder, filled);
    }
    let absolute = std::path::absolute(folder).map_err(Error::io(folder, "find the folder"))?;
    let parent = absolute.parent().unwrap_or(Path::new("."));
    let beside = tempfile::Builder::new().prefix(".quadratura-").tempdir_in(parent);
    let beside = beside.map_err(Error::io(parent, "create a folder in it"))?;
    let (new, old) = (beside.path().join("new"), beside.path().join("old"));
    let files = create_folder_with(&new, filled)?;
    fs::rename(folder, &old).map_err(Error::io(folder, "move the former page away"))?;
    let Err(error) = fs::rename(&new, folder) else { return Ok(files) };
    if fs::rename(&old, folder).is_err() {
        // The former page stays where it is; whoever reads the error finds it there.
        let kept = beside.keep().join("old");
        return Err(Error::io(&kept, "put the former page, which is here now, back in its place")(error));
    }
    Err(Error::io(folder, "put the page in place")(error))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(out: &Path, text: &str) -> PathBuf {
        let place = place_of_page(out);
        put(&place, |page| page.write("data/a b.js", text.as_bytes())).unwrap();
        place.folder
    }

    #[test]
    fn an_unchanged_page_is_replaced_and_a_changed_one_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("the page \u{e9}");
        assert_eq!(written(&out, "one"), out);
        assert_eq!(written(&out, "two"), out);
        assert_eq!(fs::read(out.join("data/a b.js")).unwrap(), b"two");
        fs::write(out.join("data/mine.txt"), "mine").unwrap();
        let second = written(&out, "three");
        assert_eq!(second, folder.path().join("the page \u{e9}-2"));
        assert_eq!(fs::read(out.join("data/mine.txt")).unwrap(), b"mine");
        fs::write(second.join("data/a b.js"), "changed").unwrap();
        assert_eq!(written(&out, "four"), folder.path().join("the page \u{e9}-3"));
    }
}
