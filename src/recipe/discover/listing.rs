//! What is in a folder and below it, as far as it could belong to a site.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::io::cameras::{CamerasThere, cameras_in};
use crate::io::photo::EXTENSIONS;
use crate::io::project::PROJECT_FILE;
use crate::task::Task;

/// How deep sub-folders are followed: `dense/0/sparse/0` with room above; links may go in circles.
const DEEPEST: usize = 6;
/// So many entries of folders are looked at: a large survey with all that COLMAP leaves beside it, and still a
/// matter of seconds where somebody points at a whole disk.
const MOST_ENTRIES: usize = 100_000;
/// Model formats that are read.
const MODELS: [&str; 3] = ["obj", "gltf", "glb"];

/// A folder in which something was found.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Folder {
    /// Below the root; empty for the root.
    pub path: PathBuf,
    /// Images that stand in it, not in its sub-folders.
    pub images: usize,
    /// Cameras of the best of their formats.
    pub cameras: Option<CamerasThere>,
    /// Models' file names and bytes.
    pub models: Vec<(String, u64)>,
}

/// What was found.
#[derive(Debug, Default)]
pub(super) struct Listing {
    /// The nearest to the root first, then by path.
    pub folders: Vec<Folder>,
    /// There was more than is looked at.
    pub cut_short: bool,
}

impl Listing {
    /// Looks at `root` and below. Hidden folders and projects of this program are left out, folders that cannot
    /// be read, too.
    ///
    /// # Errors
    /// [`Error::Io`] when `root` cannot be read; [`Error::Cancelled`].
    pub fn of(root: &Path, task: &Task) -> Result<Self> {
        std::fs::read_dir(root).map_err(Error::io(root, "read the folder"))?;
        let mut listing = Self::default();
        let (mut waiting, mut entries) = (VecDeque::from([PathBuf::new()]), 0);
        while let Some(below) = waiting.pop_front() {
            task.go_on()?;
            let names = names_in(&root.join(&below));
            entries += names.len();
            if entries > MOST_ENTRIES {
                listing.cut_short = true;
                break;
            }
            let (folder, sub_folders) = sorted_out(root, below, names);
            if folder.path.components().count() < DEEPEST {
                waiting.extend(sub_folders);
            }
            if folder.images > 0 || folder.cameras.is_some() || !folder.models.is_empty() {
                listing.folders.push(folder);
            }
        }
        Ok(listing)
    }
}

/// Names that are not hidden, sorted.
fn names_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.retain(|name| !name.starts_with('.'));
    names.sort_unstable();
    names
}

/// A folder's own content, and its sub-folders.
fn sorted_out(root: &Path, below: PathBuf, names: Vec<String>) -> (Folder, Vec<PathBuf>) {
    let here = root.join(&below);
    let mut folder = Folder { path: below, cameras: cameras_in(&here), ..Folder::default() };
    let mut sub_folders = Vec::new();
    for name in names {
        if is_image(Path::new(&name)) {
            folder.images += 1;
            continue;
        }
        let path = here.join(&name);
        if is_model(Path::new(&name)) {
            folder.models.extend(std::fs::metadata(&path).map(|file| (name, file.len())));
        } else if path.is_dir() && !path.join(PROJECT_FILE).is_file() {
            sub_folders.push(folder.path.join(name));
        }
    }
    (folder, sub_folders)
}

fn has_extension(path: &Path, known: &[&str]) -> bool {
    let extension = path.extension().unwrap_or_default();
    known.iter().any(|known| extension.eq_ignore_ascii_case(known))
}

fn is_image(path: &Path) -> bool {
    has_extension(path, &EXTENSIONS)
}

/// A model, by its extension.
pub(super) fn is_model(path: &Path) -> bool {
    has_extension(path, &MODELS)
}
