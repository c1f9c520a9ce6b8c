//! Reading the parts of a site, with a separate result for each part.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{SitePart, SiteParts};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_files::stamp::Stamp;
use quadratura_import::cameras::{CameraNames, read_names};
use quadratura_import::models::read_model;
use quadratura_import::photo::{Match, PhotoFolder};

/// A folder of photos.
#[derive(Debug)]
pub struct PhotosFound {
    /// The image files in it.
    pub files: PhotoFolder,
}

/// A set of cameras.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CamerasFound {
    /// The program, or programs, that write such files.
    pub program: &'static str,
    /// The names of their photos, in their order.
    pub names: Vec<String>,
    /// The number of points that structure from motion triangulated.
    pub points: usize,
    /// Reasons why cameras cannot be used, one sentence each.
    pub left_out: Vec<String>,
    /// Notes of the reader.
    pub notes: Vec<String>,
}

/// A model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelFound {
    /// The number of named objects.
    pub objects: usize,
    /// The number of polygon faces.
    pub faces: usize,
    /// Notes about defects and omissions.
    pub notes: Vec<String>,
}

/// The result of matching photos with cameras.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct PhotoMatch {
    /// The number of cameras whose photo exists under its own name.
    pub exactly: usize,
    /// The number of cameras whose photo exists, possibly in another folder or format.
    pub found: usize,
    /// The number of cameras.
    pub of: usize,
    /// The names of the first missing photos.
    pub missing: Vec<String>,
}

impl PhotoMatch {
    /// The number of missing photos that are listed.
    const NAMED: usize = 5;

    /// Matches the photos that cameras refer to with the files of a folder.
    pub fn new(files: &PhotoFolder, names: &[&str]) -> Self {
        let matches = files.find(names);
        let exactly = matches.iter().filter(|found| matches!(found, Match::File(_, ""))).count();
        let found = matches.iter().filter(|found| matches!(found, Match::File(..))).count();
        let missing = names.iter().zip(&matches).filter(|(_, found)| !matches!(found, Match::File(..)));
        let missing = missing.take(Self::NAMED).map(|(name, _)| (*name).to_owned()).collect();
        Self { exactly, found, of: names.len(), missing }
    }
}

/// The result of reading one part. It is shared, so that parts without changes are not read again.
#[derive(Debug)]
pub struct PartContents<T> {
    /// The part's path.
    pub path: PathBuf,
    /// The contents, or the reason why the part cannot be used; `None` for an empty path.
    pub found: Option<Arc<Result<T>>>,
    /// The stamp of the files when they were read.
    stamp: Stamp,
}

impl<T> Clone for PartContents<T> {
    fn clone(&self) -> Self {
        Self { path: self.path.clone(), found: self.found.clone(), stamp: self.stamp.clone() }
    }
}

impl<T> PartContents<T> {
    /// Reads a part, unless it is unchanged since `before`.
    fn at(path: &Path, before: Option<&Self>, read: impl FnOnce(&Path) -> Result<T>) -> Result<Self> {
        // The stamp is taken before reading, so that a change during reading is noticed the next time.
        let stamp = stamp_of(path);
        if let Some(before) = before.filter(|before| before.path == path && before.stamp == stamp) {
            return Ok(before.clone());
        }
        let found = (!path.as_os_str().is_empty()).then(|| read(path));
        match found {
            Some(Err(Error::Cancelled)) => Err(Error::Cancelled),
            found => Ok(Self { path: path.to_path_buf(), found: found.map(Arc::new), stamp }),
        }
    }

    /// Returns the contents if the part can be used.
    pub fn good(&self) -> Option<&T> {
        self.found.as_deref()?.as_ref().ok()
    }

    /// Returns the reason why the part cannot be used.
    pub fn error(&self) -> Option<&Error> {
        self.found.as_deref()?.as_ref().err()
    }
}

/// The results of reading all parts of a site.
#[derive(Debug, Clone)]
pub struct DiscoveryReport {
    /// The photos.
    pub photos: PartContents<PhotosFound>,
    /// The cameras.
    pub cameras: PartContents<CamerasFound>,
    /// The model.
    pub model: PartContents<ModelFound>,
    /// The match between photos and cameras, where both can be used.
    pub matched: Option<PhotoMatch>,
}

impl DiscoveryReport {
    /// Returns the paths that were read.
    pub fn parts(&self) -> SiteParts {
        let [photos, cameras, model] =
            [&self.photos.path, &self.cameras.path, &self.model.path].map(PathBuf::clone);
        SiteParts { photos, cameras, model }
    }

    /// Returns the reason why a part cannot be used.
    pub fn error(&self, part: SitePart) -> Option<&Error> {
        match part {
            SitePart::Photos => self.photos.error(),
            SitePart::Cameras => self.cameras.error(),
            SitePart::Model => self.model.error(),
        }
    }

    /// Returns true when a project can be made: all parts can be used, and at least one camera has its photo.
    pub fn is_whole(&self) -> bool {
        let matched = self.matched.as_ref().is_some_and(|matched| matched.found > 0);
        matched && self.model.good().is_some()
    }
}

/// Returns the stamp of a folder, or of a file together with files of the same stem beside it, such as the buffers
/// of a glTF model.
fn stamp_of(path: &Path) -> Stamp {
    if path.as_os_str().is_empty() {
        return Stamp::default();
    }
    let around = path.parent().filter(|_| path.is_file()).and_then(|folder| std::fs::read_dir(folder).ok());
    let beside = around.into_iter().flatten().flatten().map(|entry| entry.path());
    let mut siblings: Vec<PathBuf> = beside.filter(|other| other.file_stem() == path.file_stem()).collect();
    siblings.sort();
    let siblings = siblings.iter().filter(|other| other.is_file()).map(|other| Stamp::from_path(other));
    siblings.fold(Stamp::from_path(path), Stamp::and)
}

/// Reads the parts of a site. Parts that were read `before` from the same path and are unchanged are reused.
///
/// # Errors
/// Returns [`Error::Cancelled`] only; errors of a part are in its own result.
pub fn look_at(parts: &SiteParts, before: Option<&DiscoveryReport>, task: &Task) -> Result<DiscoveryReport> {
    // Notes about a part belong to its own result, not to the observer of the task.
    let task = &Task::silent().with_stop_flag(task.stop_flag());
    let photos = PartContents::at(&parts.photos, before.map(|look| &look.photos), |path| photos(path, task))?;
    let cameras =
        PartContents::at(&parts.cameras, before.map(|look| &look.cameras), |path| cameras(path, task))?;
    let model = PartContents::at(&parts.model, before.map(|look| &look.model), |path| model(path, task))?;
    let matched = photos.good().zip(cameras.good()).map(|(photos, cameras)| {
        let names: Vec<&str> = cameras.names.iter().map(String::as_str).collect();
        PhotoMatch::new(&photos.files, &names)
    });
    Ok(DiscoveryReport { photos, cameras, model, matched })
}

/// Lists a folder of photos.
fn photos(path: &Path, task: &Task) -> Result<PhotosFound> {
    let files = PhotoFolder::scan(path, task)?;
    if files.is_empty() {
        let remedy = "give the folder of the photos: JPEG, PNG, TIFF or WebP";
        return Err(Error::input(path, "", "this folder contains no photos", remedy));
    }
    Ok(PhotosFound { files })
}

/// Reads cameras.
fn cameras(path: &Path, task: &Task) -> Result<CamerasFound> {
    let CameraNames { program, names, points, problems, notes } = read_names(path, task)?;
    let left_out = problems.iter().map(ToString::to_string).collect();
    Ok(CamerasFound { program, names, points, left_out, notes })
}

/// Reads a model.
fn model(path: &Path, task: &Task) -> Result<ModelFound> {
    let (model, notes) = read_model(path, task)?;
    Ok(ModelFound { objects: model.objects.len(), faces: model.faces.len(), notes })
}
