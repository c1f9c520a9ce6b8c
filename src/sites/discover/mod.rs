//! Discovery of a site's parts: photos, cameras and a model in a folder, and what each of them contains.
//!
//! [`find_site`] searches a folder and lists candidates, the likeliest first; [`look_at`] reads the chosen parts
//! and reports on each separately, so that the caller can show each error where it belongs.

mod listing;
mod look;
mod ranking;

#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_import::cameras::{self, cameras_in, is_camera_file, read_names};
use quadratura_import::photo::PhotoFolder;
use quadratura_io::project::check_is_empty;

use listing::Listing;
pub use look::{CamerasFound, DiscoveryReport, ModelFound, PartContents, PhotoMatch, PhotosFound, look_at};

/// A part of a site, in the order in which the user is asked for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SitePart {
    /// The folder of the photos.
    Photos,
    /// The cameras: a file or a folder of one of the formats that are read.
    Cameras,
    /// The model's file.
    Model,
}

impl SitePart {
    /// All parts, in order.
    pub const ALL: [Self; 3] = [Self::Photos, Self::Cameras, Self::Model];

    /// Returns the name that is displayed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Photos => "Photos",
            Self::Cameras => "Cameras",
            Self::Model => "Model",
        }
    }

    /// Returns a description of what the user may choose.
    pub fn accepted(self) -> String {
        match self {
            Self::Photos => "a folder of JPEG, PNG, TIFF or WebP photos, sub-folders too".into(),
            Self::Cameras => cameras::accepted(),
            Self::Model => "a coarse model as OBJ, glTF or GLB".into(),
        }
    }

    /// Returns a short description: for cameras the programs instead of their files.
    pub fn accepted_shortly(self) -> String {
        match self {
            Self::Cameras => format!("the cameras of {}", cameras::programs()),
            Self::Photos | Self::Model => self.accepted(),
        }
    }
}

/// The paths of a site's parts. An empty path is not known yet.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SiteParts {
    /// The folder of the photos.
    pub photos: PathBuf,
    /// The folder of the cameras, or one of their files.
    pub cameras: PathBuf,
    /// The model's file.
    pub model: PathBuf,
}

impl SiteParts {
    /// Returns the path of a part.
    pub fn path(&self, part: SitePart) -> &Path {
        match part {
            SitePart::Photos => &self.photos,
            SitePart::Cameras => &self.cameras,
            SitePart::Model => &self.model,
        }
    }

    /// Returns the path of a part for modification.
    pub fn path_mut(&mut self, part: SitePart) -> &mut PathBuf {
        match part {
            SitePart::Photos => &mut self.photos,
            SitePart::Cameras => &mut self.cameras,
            SitePart::Model => &mut self.model,
        }
    }

    /// Returns the part that an error concerns: the one whose path is the closest ancestor of the error's file.
    /// `None` for errors that concern no part, such as those of the project's own folder.
    pub fn part_of_error(&self, error: &Error) -> Option<SitePart> {
        let file = match error {
            Error::Input { file, .. } => file,
            Error::Io { path, .. } => path,
            _ => return None,
        };
        let file = file.canonicalize().unwrap_or_else(|_| file.clone());
        let of_part = |part: SitePart| {
            let path = self.path(part);
            let whole = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
            // Cameras may be given by one of their files, and an error may concern another one.
            let whole = match part {
                SitePart::Cameras if whole.is_file() => whole.parent().map(PathBuf::from).unwrap_or_default(),
                _ => whole,
            };
            (!path.as_os_str().is_empty() && file.starts_with(&whole))
                .then(|| (whole.components().count(), part))
        };
        SitePart::ALL.into_iter().filter_map(of_part).max_by_key(|(depth, _)| *depth).map(|(_, part)| part)
    }
}

/// The candidates found in a folder, for each part the likeliest first.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Candidates {
    /// Folders of photos.
    pub photos: Vec<PathBuf>,
    /// Folders with cameras.
    pub cameras: Vec<PathBuf>,
    /// Model files.
    pub models: Vec<PathBuf>,
    /// Whether the folder has too many entries, so that not all of it was searched.
    pub cut_short: bool,
}

impl Candidates {
    /// Returns the candidates for one part.
    pub fn of(&self, part: SitePart) -> &[PathBuf] {
        match part {
            SitePart::Photos => &self.photos,
            SitePart::Cameras => &self.cameras,
            SitePart::Model => &self.models,
        }
    }
}

/// The number of photo folders that are compared with the cameras' names; the others are less likely by their own
/// names.
const LOOKED_AT: usize = 12;

/// Searches `root` and its subfolders for the parts of a site. Photo folders are ranked by how many of the
/// likeliest cameras' photos they contain, everything else by names, locations and sizes.
///
/// # Errors
/// Returns [`Error::Input`] when `root` is not a folder, [`Error::Io`] when it cannot be read, or
/// [`Error::Cancelled`].
pub fn find_site(root: &Path, task: &Task) -> Result<Candidates> {
    if !root.is_dir() {
        return Err(Error::input(root, "", "this folder does not exist", "check the path"));
    }
    let listing = Listing::new(root, task)?;
    let below = |paths: Vec<PathBuf>| paths.iter().map(|path| joined(root, path)).collect::<Vec<_>>();
    let cameras = below(ranking::cameras(&listing));
    let models = below(ranking::models(&listing));
    let photos = below(ranking::photos(&listing));
    let names = cameras.first().map(|folder| names_in(folder, task)).transpose()?.unwrap_or_default();
    let photos = by_names(photos, &names, task)?;
    Ok(Candidates { photos, cameras, models, cut_short: listing.cut_short })
}

/// Joins two paths; an empty second path gives `root` without a trailing slash.
fn joined(root: &Path, below: &Path) -> PathBuf {
    if below.as_os_str().is_empty() { root.to_path_buf() } else { root.join(below) }
}

/// Returns the names of the photos that the cameras refer to. The result is empty where the cameras cannot be read;
/// the caller that uses them reports the error.
fn names_in(cameras: &Path, task: &Task) -> Result<Vec<String>> {
    match read_names(cameras, &Task::silent().with_stop_flag(task.stop_flag())) {
        Ok(cameras) => Ok(cameras.names),
        Err(Error::Cancelled) => Err(Error::Cancelled),
        Err(_) => Ok(Vec::new()),
    }
}

/// Sorts folders by how many of the photos they contain; of equal ones, those with fewer other files come first.
fn by_names(mut folders: Vec<PathBuf>, names: &[String], task: &Task) -> Result<Vec<PathBuf>> {
    folders.truncate(LOOKED_AT);
    if names.is_empty() {
        return Ok(folders);
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut ranked = Vec::with_capacity(folders.len());
    for folder in folders {
        task.check_cancelled()?;
        let Ok(files) = PhotoFolder::scan(&folder, task) else { continue };
        let matched = PhotoMatch::new(&files, &names);
        ranked.push((matched.exactly, matched.found, files.len(), folder));
    }
    ranked.sort_by(|a, b| (b.0, b.1).cmp(&(a.0, a.1)).then(a.2.cmp(&b.2)));
    Ok(ranked.into_iter().map(|(.., folder)| folder).collect())
}

/// Returns the part that a file or folder is by its name and contents; `None` for a folder that may contain a whole
/// site.
pub fn part_at(path: &Path) -> Option<SitePart> {
    if path.is_dir() {
        return cameras_in(path).map(|_| SitePart::Cameras);
    }
    if listing::is_model(path) {
        return Some(SitePart::Model);
    }
    (is_camera_file(path) && !cameras::camera_files(path).is_empty()).then_some(SitePart::Cameras)
}

/// Returns a folder for the project of a site in `root`: beside it, named after it, and new or empty.
pub fn folder_beside(root: &Path) -> PathBuf {
    let root = root.canonicalize().unwrap_or_else(|_| root.to_path_buf());
    let name = root.file_name().map_or_else(|| "site".into(), |name| name.to_string_lossy().into_owned());
    let beside = root.parent().unwrap_or(&root).to_path_buf();
    first_folder(&beside, &format!("{name}-project"), |folder| check_is_empty(folder).is_ok())
}

/// Returns the first of the folders `name`, `name-2`, `name-3` and so on in `parent` that fits; `name` where none does.
pub(crate) fn first_folder(parent: &Path, name: &str, fits: impl Fn(&Path) -> bool) -> PathBuf {
    let named = |number: u32| match number {
        1 => parent.join(name),
        number => parent.join(format!("{name}-{number}")),
    };
    (1..1000).map(named).find(|folder| fits(folder)).unwrap_or_else(|| named(1))
}
