//! What is in each part of a site: read once, told part by part.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{Part, Parts};
use crate::error::{Error, Result};
use crate::io::cameras::{CameraNames, read_names};
use crate::io::models::read_model;
use crate::io::photo::{Match, PhotoFolder};
use crate::io::stamp::Stamp;
use crate::task::Task;

/// A folder of photos.
#[derive(Debug)]
pub struct PhotosFound {
    /// Its image files.
    pub files: PhotoFolder,
}

/// Cameras.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CamerasFound {
    /// The photos that they name, in their order.
    pub names: Vec<String>,
    /// Points that structure from motion triangulated.
    pub points: usize,
    /// Cameras that cannot be used, one sentence each.
    pub left_out: Vec<String>,
    /// What is worth knowing.
    pub notes: Vec<String>,
}

/// A model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelFound {
    /// Named objects.
    pub objects: usize,
    /// Polygon faces.
    pub faces: usize,
    /// What is wrong with it and what was left out.
    pub notes: Vec<String>,
}

/// How photos and cameras belong together.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Matched {
    /// Cameras whose photo is there under its own name.
    pub exactly: usize,
    /// Cameras whose photo is there, be it in another folder or format.
    pub found: usize,
    /// Cameras.
    pub of: usize,
    /// The first photos that are not there.
    pub missing: Vec<String>,
}

impl Matched {
    /// So many missing photos are named.
    const NAMED: usize = 5;

    /// Of the photos that cameras name, in a folder.
    pub fn of(files: &PhotoFolder, names: &[&str]) -> Self {
        let matches = files.find(names);
        let exactly = matches.iter().filter(|found| matches!(found, Match::File(_, ""))).count();
        let found = matches.iter().filter(|found| matches!(found, Match::File(..))).count();
        let missing = names.iter().zip(&matches).filter(|(_, found)| !matches!(found, Match::File(..)));
        let missing = missing.take(Self::NAMED).map(|(name, _)| (*name).to_owned()).collect();
        Self { exactly, found, of: names.len(), missing }
    }
}

/// What one part was found to be; shared, so that parts that did not change are not read again.
#[derive(Debug)]
pub struct Looked<T> {
    /// Where.
    pub path: PathBuf,
    /// What is there, or why it cannot be used. None for an empty path.
    pub found: Option<Arc<Result<T>>>,
    /// The files as they were by then.
    stamp: Stamp,
}

impl<T> Clone for Looked<T> {
    fn clone(&self) -> Self {
        Self { path: self.path.clone(), found: self.found.clone(), stamp: self.stamp.clone() }
    }
}

impl<T> Looked<T> {
    fn at(path: &Path, before: Option<&Self>, read: impl FnOnce(&Path) -> Result<T>) -> Result<Self> {
        // Before it is read: what changes meanwhile is looked at once more.
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

    /// What is there, where it can be used.
    pub fn good(&self) -> Option<&T> {
        self.found.as_deref()?.as_ref().ok()
    }

    /// Why it cannot be used.
    pub fn error(&self) -> Option<&Error> {
        self.found.as_deref()?.as_ref().err()
    }
}

/// What the parts of a site were found to be.
#[derive(Debug, Clone)]
pub struct Look {
    /// The photos.
    pub photos: Looked<PhotosFound>,
    /// The cameras.
    pub cameras: Looked<CamerasFound>,
    /// The model.
    pub model: Looked<ModelFound>,
    /// Photos and cameras together, where both can be used.
    pub matched: Option<Matched>,
}

impl Look {
    /// Where it was looked.
    pub fn parts(&self) -> Parts {
        let [photos, cameras, model] =
            [&self.photos.path, &self.cameras.path, &self.model.path].map(PathBuf::clone);
        Parts { photos, cameras, model }
    }

    /// Why a part cannot be used.
    pub fn error(&self, part: Part) -> Option<&Error> {
        match part {
            Part::Photos => self.photos.error(),
            Part::Cameras => self.cameras.error(),
            Part::Model => self.model.error(),
        }
    }

    /// A project can be made of it: all parts can be used, and a photo at least has its camera.
    pub fn is_whole(&self) -> bool {
        let matched = self.matched.as_ref().is_some_and(|matched| matched.found > 0);
        matched && self.model.good().is_some()
    }
}

/// Of a file with those beside it that are called so, too, as the buffers of a glTF model are; of a folder.
fn stamp_of(path: &Path) -> Stamp {
    if path.as_os_str().is_empty() {
        return Stamp::default();
    }
    let around = path.parent().filter(|_| path.is_file()).and_then(|folder| std::fs::read_dir(folder).ok());
    let beside = around.into_iter().flatten().flatten().map(|entry| entry.path());
    let mut kin: Vec<PathBuf> = beside.filter(|other| other.file_stem() == path.file_stem()).collect();
    kin.sort();
    let kin = kin.iter().filter(|other| other.is_file()).map(|other| Stamp::of(other));
    kin.fold(Stamp::of(path), Stamp::and)
}

/// Reads the parts of a site; those that were looked at `before` at the same place, and are as they were, are taken from
/// there.
///
/// # Errors
/// [`Error::Cancelled`] alone: what is wrong with a part is told in its place.
pub fn look_at(parts: &Parts, before: Option<&Look>, task: &Task) -> Result<Look> {
    // What is told of one part belongs to its place, not to whoever listens to the task.
    let task = &Task::silent().stopped_by(task.stop_flag());
    let photos = Looked::at(&parts.photos, before.map(|look| &look.photos), |path| photos(path, task))?;
    let cameras = Looked::at(&parts.cameras, before.map(|look| &look.cameras), |path| cameras(path, task))?;
    let model = Looked::at(&parts.model, before.map(|look| &look.model), |path| model(path, task))?;
    let matched = photos.good().zip(cameras.good()).map(|(photos, cameras)| {
        let names: Vec<&str> = cameras.names.iter().map(String::as_str).collect();
        Matched::of(&photos.files, &names)
    });
    Ok(Look { photos, cameras, model, matched })
}

fn photos(path: &Path, task: &Task) -> Result<PhotosFound> {
    let files = PhotoFolder::scan(path, task)?;
    if files.is_empty() {
        let remedy = "give the folder of the photos: JPEG, PNG, TIFF or WebP";
        return Err(Error::input(path, "", "there is no photo in it", remedy));
    }
    Ok(PhotosFound { files })
}

fn cameras(path: &Path, task: &Task) -> Result<CamerasFound> {
    let CameraNames { names, points, problems, notes } = read_names(path, task)?;
    Ok(CamerasFound { names, points, left_out: problems.iter().map(ToString::to_string).collect(), notes })
}

fn model(path: &Path, task: &Task) -> Result<ModelFound> {
    let (model, notes) = read_model(path, task)?;
    Ok(ModelFound { objects: model.objects.len(), faces: model.faces.len(), notes })
}
