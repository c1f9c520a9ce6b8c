//! Discovery of mask files beside the photos, by their usual names.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::MaskEdit;
use super::undistorted::read_undistorted;
use crate::document::Project;
use crate::document::masks::MaskOrigin;
use crate::document::names::without_extension;
use crate::error::{Error, Result};
use crate::geometry::Spans;
use crate::io::cameras::{CameraPhoto, read_cameras_of};
use crate::io::named_file::{NamedFile, NamedFiles};
use crate::io::project::resolved;
use crate::recipe::named::index_of_photo;
use crate::scene::Site;
use crate::scene::alike::difference;
use crate::task::Task;

/// Returns the possible names of a photo's mask, as paths from the photo folder: `0028.mask.png` and
/// `0028_mask.png` beside the photo, also after its full name; and, as COLMAP does it, in a folder `masks` in or
/// beside the photo folder, `masks/0028.jpg.png`.
pub fn mask_names(photo: &str) -> [String; 6] {
    let stem = without_extension(photo);
    [
        format!("{stem}.mask.png"),
        format!("{stem}_mask.png"),
        format!("{photo}.mask.png"),
        format!("{photo}_mask.png"),
        format!("masks/{photo}.png"),
        format!("../masks/{photo}.png"),
    ]
}

/// A mask file that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundMask {
    /// The photo's name.
    pub photo: String,
    /// The file, as a path from the photo folder.
    pub file: String,
    /// The masked pixels of the pinhole image.
    pub masked: Spans,
}

impl FoundMask {
    /// Returns the edit that adds the mask to the project.
    pub fn edit(self) -> MaskEdit {
        MaskEdit::Put { photo: self.photo, from: MaskOrigin::File(self.file), masked: self.masked }
    }
}

/// Returns all masks that are beside photos of the site, and the problems with others.
///
/// # Errors
/// Returns [`Error::Input`] and [`Error::Io`] when the cameras cannot be read, or [`Error::Cancelled`].
pub fn masks_beside(
    folder: &Path,
    project: &Project,
    site: &Site,
    task: &Task,
) -> Result<(Vec<FoundMask>, Vec<Error>)> {
    let root = resolved(folder, &project.photos);
    let (files, mut problems) = mask_files(&root, site, task);
    if files.is_empty() {
        return Ok((Vec::new(), problems));
    }
    let cameras = cameras(folder, project, task)?;
    let mut found = Vec::new();
    for (photo, file) in files {
        task.go_on()?;
        match read_whole(&root.join(&file), &cameras[photo]) {
            Ok(masked) => found.push(FoundMask { photo: photo.to_owned(), file, masked }),
            Err(problem) => problems.push(problem),
        }
    }
    Ok((found, problems))
}

/// Finds the mask files of photos, as paths from the photo folder, and the names that several files could have.
fn mask_files<'a>(root: &Path, site: &'a Site, task: &Task) -> (Vec<(&'a str, String)>, Vec<Error>) {
    let mut named = NamedFiles::default();
    let (mut files, mut problems): (Vec<(&str, String)>, Vec<Error>) = Default::default();
    for photo in &site.photos {
        let mut of_photo: BTreeSet<String> = BTreeSet::new();
        for name in mask_names(&photo.name) {
            match named.find(root, &name) {
                NamedFile::Missing => {}
                NamedFile::Found(file) => {
                    let how = difference(&name, &file);
                    if of_photo.insert(file.clone()) && !how.is_empty() {
                        task.note(format!("{}: its mask was found {how}, as {file}", photo.name));
                    }
                }
                NamedFile::Several(files) => {
                    let found = format!(
                        "{} files could be {name}: their names differ in Unicode form or letter case",
                        files.len()
                    );
                    problems.push(Error::input(
                        root.join(&files[0]),
                        "",
                        found,
                        "keep one of them, or give it exactly this name",
                    ));
                }
            }
        }
        files.extend(of_photo.into_iter().map(|file| (photo.name.as_str(), file)));
    }
    (files, problems)
}

/// Reads a file as the mask of one photo, whose name may be abbreviated.
///
/// # Errors
/// Returns [`Error::Request`] for a name that matches no photo; otherwise the errors of [`masks_beside`].
pub fn mask_of_file(
    folder: &Path,
    project: &Project,
    site: &Site,
    (photo, file): (&str, &Path),
    task: &Task,
) -> Result<FoundMask> {
    let photo = site.photo(index_of_photo(site, photo)?).name.clone();
    let cameras = cameras(folder, project, task)?;
    let masked = read_whole(file, &cameras[&photo])?;
    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(FoundMask { photo, file: name, masked })
}

/// Reads the cameras by photo name; every photo of the site is among them.
fn cameras(folder: &Path, project: &Project, task: &Task) -> Result<BTreeMap<String, CameraPhoto>> {
    let file: PathBuf = resolved(folder, &project.cameras);
    let cameras = read_cameras_of(&resolved(folder, &project.photos), &file, task)?;
    Ok(cameras.photos.into_iter().map(|photo| (photo.name.clone(), photo)).collect())
}

/// Reads a mask. One that covers the whole photo is rejected, because it is probably inverted.
fn read_whole(file: &Path, photo: &CameraPhoto) -> Result<Spans> {
    let masked = read_undistorted(file, photo)?;
    let all = u64::from(photo.camera.width) * u64::from(photo.camera.height);
    if photo.lens.is_none() && masked.count() == all {
        let remedy = "paint the area to be masked black and the rest white, or remove the file";
        return Err(Error::input(file, "", "it masks the whole photo", remedy));
    }
    Ok(masked)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_names_of_a_mask_are_those_that_people_give_it() {
        let names = mask_names("nord/1.jpg");
        for name in ["nord/1.mask.png", "nord/1_mask.png", "nord/1.jpg.mask.png", "masks/nord/1.jpg.png"] {
            assert!(names.iter().any(|known| known == name), "{name}");
        }
    }
}
