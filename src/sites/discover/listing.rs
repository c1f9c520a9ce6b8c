//! A listing of a folder and its subfolders, limited to what could belong to a site.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_import::cameras::{CamerasThere, cameras_in};
use quadratura_import::photo::EXTENSIONS;
use quadratura_io::project::PROJECT_FILE;

/// The deepest level of subfolders that is searched: enough for `dense/0/sparse/0`, and finite where links form
/// cycles.
const DEEPEST: usize = 6;
/// The largest number of folder entries that is read: enough for a large survey with everything that COLMAP leaves,
/// and still a matter of seconds when the folder is a whole disk.
const MOST_ENTRIES: usize = 100_000;
/// The extensions of the model formats that are read.
const MODELS: [&str; 3] = ["obj", "gltf", "glb"];

/// A folder with relevant contents.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct FolderContents {
    /// The path below the root; empty for the root.
    pub path: PathBuf,
    /// The number of images in the folder itself, not in subfolders.
    pub images: usize,
    /// The cameras in it, of the first format that is there.
    pub cameras: Option<CamerasThere>,
    /// The file names and sizes in bytes of models.
    pub models: Vec<(String, u64)>,
}

/// The result of a search.
#[derive(Debug, Default)]
pub(super) struct Listing {
    /// The folders, those nearest to the root first, then by path.
    pub folders: Vec<FolderContents>,
    /// Whether the search stopped at the limit of entries.
    pub cut_short: bool,
}

impl Listing {
    /// Searches `root` and its subfolders. Hidden folders, projects of this program and unreadable folders are
    /// skipped.
    ///
    /// # Errors
    /// Returns [`Error::Io`] when `root` cannot be read, or [`Error::Cancelled`].
    pub fn new(root: &Path, task: &Task) -> Result<Self> {
        std::fs::read_dir(root).map_err(Error::io(root, "read the folder"))?;
        let mut listing = Self::default();
        let mut waiting = VecDeque::from([PathBuf::new()]);
        let mut entries = 0;
        while let Some(below) = waiting.pop_front() {
            task.check_cancelled()?;
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

/// Returns the names in a folder that are not hidden, sorted.
fn names_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.retain(|name| !name.starts_with('.'));
    names.sort_unstable();
    names
}

/// Returns a folder's relevant contents, and its subfolders.
fn sorted_out(root: &Path, below: PathBuf, names: Vec<String>) -> (FolderContents, Vec<PathBuf>) {
    let here = root.join(&below);
    let mut folder = FolderContents { path: below, cameras: cameras_in(&here), ..FolderContents::default() };
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

/// Returns true when the path has one of these extensions, in upper or lower case.
fn has_extension(path: &Path, known: &[&str]) -> bool {
    let extension = path.extension().unwrap_or_default();
    known.iter().any(|known| extension.eq_ignore_ascii_case(known))
}

/// Returns true when the path has the extension of a photo.
fn is_image(path: &Path) -> bool {
    has_extension(path, &EXTENSIONS)
}

/// Returns true when the path has the extension of a model.
pub(super) fn is_model(path: &Path) -> bool {
    has_extension(path, &MODELS)
}
