//! Finds the layered documents in a folder, such as an image editor may have saved there.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::project::PROJECT_FILE;
use quadratura_base::error::{Error, Result};
use quadratura_files::stamp::Stamp;
use quadratura_layered_files::recognise::{has_extension, is_exported_folder};

/// Sub-folders are searched down to this depth; exports are never nested that deeply.
const DEEPEST: usize = 16;

/// Finds the layered documents in a folder and its sub-folders: files by their extension, exported folders by
/// their key file; `folder` itself counts if it is an exported one. Hidden folders, links to folders and
/// projects are skipped.
///
/// # Errors
/// [`Error::Io`] when the folder cannot be read. Entries below it that vanish meanwhile or cannot be read are
/// left out.
pub fn documents(folder: &Path) -> Result<BTreeMap<PathBuf, Stamp>> {
    let mut found = BTreeMap::new();
    if is_exported_folder(folder) {
        found.insert(folder.to_owned(), Stamp::from_path(folder));
    } else {
        fs::read_dir(folder).map_err(Error::io(folder, "read the folder"))?;
        search(folder, 0, &mut found);
    }
    Ok(found)
}

fn search(folder: &Path, depth: usize, found: &mut BTreeMap<PathBuf, Stamp>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let name = entry.file_name().to_string_lossy().into_owned();
        // Temporary files of editors and of this program.
        if name.starts_with('.') || name.ends_with('~') {
            continue;
        }
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            if is_exported_folder(&path) {
                found.insert(path.clone(), Stamp::from_path(&path));
            } else if depth < DEEPEST && !path.join(PROJECT_FILE).exists() {
                search(&path, depth + 1, found);
            }
        } else if has_extension(&path) {
            let stamp = Stamp::from_path(&path);
            if !stamp.is_empty() {
                found.insert(path, stamp);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use quadratura_layered_files::KEY_FILE;

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let below = |path: PathBuf| path.strip_prefix(folder).unwrap().to_string_lossy().replace('\\', "/");
        documents(folder).unwrap().into_keys().map(below).collect()
    }

    #[test]
    fn layered_files_and_exported_folders_are_documents_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str| {
            let file = folder.path().join(name);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, "x").unwrap();
        };
        for name in ["a.psd", "B.ORA", "c.xcf", "d.png", ".hidden.psd", "e.psd~", "notes.txt"] {
            put(name);
        }
        for name in ["exported/a.psd", "north/side/f.psd", ".trash/g.psd", "project/h.psd"] {
            put(name);
        }
        put(&format!("exported/{KEY_FILE}"));
        put(&format!("project/{PROJECT_FILE}"));
        assert_eq!(names(folder.path()), ["B.ORA", "a.psd", "c.xcf", "exported", "north/side/f.psd"]);
        assert_eq!(names(&folder.path().join("exported")), [""], "the folder itself");
        assert!(documents(&folder.path().join("nowhere")).is_err());
    }
}
