//! Finding the cameras' files, whatever the user pointed at.

use std::path::{Path, PathBuf};

use super::Files;
use crate::error::{Error, Result};

/// Where COLMAP puts a model below the folder that people call theirs.
const FOLDERS: [&str; 4] = ["", "sparse", "sparse/0", "0"];

/// The model's files for a path to a folder or to one of the files.
///
/// # Errors
/// [`Error::Input`] when there is no complete model, naming what was looked for and what is missing.
pub(super) fn locate(path: &Path) -> Result<Files> {
    if path.is_file() {
        return beside(path);
    }
    if !path.is_dir() {
        return Err(Error::input(path, "", "there is no such file or folder", "check the path"));
    }
    let found = FOLDERS.iter().find_map(|below| {
        let folder = if below.is_empty() { path.to_path_buf() } else { path.join(below) };
        complete(&folder, true).or_else(|| complete(&folder, false))
    });
    let mut files = found.ok_or_else(|| nothing_in(path))?;
    files.notes.extend(other_models(&files.cameras));
    Ok(files)
}

/// The model that a named file belongs to, in that file's own format.
fn beside(file: &Path) -> Result<Files> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let binary = file.extension().is_some_and(|extension| extension == "bin");
    complete(folder, binary).ok_or_else(|| {
        let [cameras, images, _] = names(binary);
        let remedy = "point at the folder or at one of the files that COLMAP wrote \
                      (cameras, images, points3D; .bin or .txt)";
        Error::input(file, "", format!("{cameras} and {images} are not both beside it"), remedy)
    })
}

fn names(binary: bool) -> [&'static str; 3] {
    if binary {
        ["cameras.bin", "images.bin", "points3D.bin"]
    } else {
        ["cameras.txt", "images.txt", "points3D.txt"]
    }
}

/// The files in `folder`, when cameras and photos are both there.
fn complete(folder: &Path, binary: bool) -> Option<Files> {
    let [cameras, images, points] = names(binary).map(|name| folder.join(name));
    if !cameras.is_file() || !images.is_file() {
        return None;
    }
    let mut notes = Vec::new();
    if binary && folder.join("images.txt").is_file() {
        notes.push(format!("{}: read instead of images.txt beside it", images.display()));
    }
    let points = points.is_file().then_some(points);
    Some(Files { binary, cameras, images, points, notes })
}

/// Whether COLMAP's list of cameras and list of photos both stand in `folder` itself; they are not read.
pub fn holds_cameras(folder: &Path) -> bool {
    [true, false].into_iter().any(|binary| complete(folder, binary).is_some())
}

fn nothing_in(path: &Path) -> Error {
    let found = "no cameras and images files (.bin or .txt) in it, in sparse, in sparse/0 or in 0";
    let remedy = "point at the folder with COLMAP's cameras.bin and images.bin or cameras.txt and \
                  images.txt; other programs can export to that format";
    Error::input(path, "", found, remedy)
}

/// COLMAP numbers the parts of a reconstruction that it could not join; only one is read.
fn other_models(cameras: &Path) -> Option<String> {
    let folder = cameras.parent()?;
    let number: u32 = folder.file_name()?.to_str()?.parse().ok()?;
    let others: Vec<PathBuf> = (0..64)
        .filter(|&other| other != number)
        .filter_map(|other| Some(folder.parent()?.join(other.to_string())))
        .filter(|other| other.is_dir())
        .collect();
    let other = others.first()?;
    let (used, all) = (folder.display(), others.len() + 1);
    Some(format!(
        "{used}: the first of {all} separate reconstructions is used; to use another, point at it, \
         for instance {}",
        other.display()
    ))
}
