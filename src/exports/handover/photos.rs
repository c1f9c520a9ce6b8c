//! The files of undistorted photos, as a folder for other programs refers to them.

use std::path::Path;

use super::folder::HandoverFolder;
use super::origin::Placement;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Photo;
use quadratura_document::names::file_name_of_photo;
use quadratura_handover::camera::HandoverCamera;
use quadratura_io::project::relative_to;

/// Returns whether the photo's picture was resampled by this program; else it is the user's own file.
pub fn is_resampled(project: &Path, photo: &Photo) -> bool {
    let cache = project.join("cache");
    photo.file.starts_with(&cache) || cache.canonicalize().is_ok_and(|cache| photo.file.starts_with(cache))
}

/// Copies the undistorted picture of a photo to `folder` below the export's, as it is, and returns its path in the export.
///
/// # Errors
/// Returns [`Error::Io`].
pub fn copied(folder: &mut HandoverFolder, below: &str, photo: &Photo) -> Result<String> {
    let content = std::fs::read(&photo.file).map_err(Error::io(&photo.file, "read it"))?;
    let ending = photo.file.extension().unwrap_or_default().to_string_lossy().into_owned();
    let mut name = format!("{below}/{}", file_name_of_photo(&photo.name));
    if !name.to_lowercase().ends_with(&format!(".{}", ending.to_lowercase())) {
        name = format!("{name}.{ending}");
    }
    folder.write(&name, &content)?;
    Ok(name)
}

/// Returns the path of a photo's own file, relative to the export's folder.
///
/// # Errors
/// Returns [`Error::Io`] when it no longer exists, or [`Error::Input`] for a path that is not Unicode.
pub fn linked(folder: &HandoverFolder, photo: &Photo) -> Result<String> {
    relative_to(folder.path(), &photo.file)
}

/// Returns the camera of a photo, whose picture is `file`, as it is placed in the files.
pub fn camera_of(photo: &Photo, file: String, placement: &Placement) -> HandoverCamera {
    let pose = placement.pose(&photo.pose);
    HandoverCamera { name: photo.name.clone(), file, camera: photo.camera, pose }
}
