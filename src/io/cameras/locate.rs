//! Finds the files of the cameras from a path to a folder or file.

use std::path::{Path, PathBuf};

use super::Files;
use crate::error::{Error, Result};

/// Folders in which COLMAP puts a model below the folder that users give.
const FOLDERS: [&str; 4] = ["", "sparse", "sparse/0", "0"];

/// Finds the model's files for a path to a folder or to one of the files.
///
/// # Errors
/// [`Error::Input`] when there is no complete model; it names what was searched and what is missing.
pub(super) fn locate(path: &Path) -> Result<Files> {
    if path.is_file() {
        return beside(path);
    }
    if !path.is_dir() {
        return Err(Error::input(path, "", "this file or folder does not exist", "check the path"));
    }
    let found = FOLDERS.iter().find_map(|below| {
        let folder = if below.is_empty() { path.to_path_buf() } else { path.join(below) };
        complete(&folder, true).or_else(|| complete(&folder, false))
    });
    let mut files = found.ok_or_else(|| nothing_in(path))?;
    files.notes.extend(other_models(&files.cameras));
    Ok(files)
}

/// Returns the model that a given file belongs to, in that file's own format.
fn beside(file: &Path) -> Result<Files> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let binary = file.extension().is_some_and(|extension| extension == "bin");
    complete(folder, binary).ok_or_else(|| {
        let [cameras, images, _] = names(binary);
        let remedy = "give the folder or one of the files that COLMAP wrote \
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

/// Returns the files in `folder` if it has both cameras and photos.
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

/// Returns whether `folder` itself contains COLMAP's list of cameras and list of photos; they are not read.
pub fn holds_cameras(folder: &Path) -> bool {
    [true, false].into_iter().any(|binary| complete(folder, binary).is_some())
}

fn nothing_in(path: &Path) -> Error {
    let found =
        "no cameras and images files (.bin or .txt) in this folder or below it in sparse, sparse/0 or 0";
    let remedy = "give the folder with COLMAP's cameras.bin and images.bin or cameras.txt and \
                  images.txt; other programs can export to that format";
    Error::input(path, "", found, remedy)
}

/// Returns a note where COLMAP wrote several reconstructions that it could not join; only one of them is
/// read.
fn other_models(cameras: &Path) -> Option<String> {
    let folder = cameras.parent()?;
    let number: u32 = folder.file_name()?.to_str()?.parse().ok()?;
    let others: Vec<PathBuf> = (0..64)
        .filter(|&other| other != number)
        .filter_map(|other| Some(folder.parent()?.join(other.to_string())))
        .filter(|other| other.is_dir())
        .collect();
    let other = others.first()?;
    let used = folder.display();
    let all = others.len() + 1;
    Some(format!(
        "{used}: the first of {all} separate reconstructions is used; to use another, give its folder, \
         for example {}",
        other.display()
    ))
}
