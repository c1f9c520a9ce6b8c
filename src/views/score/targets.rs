//! The photos to be predicted: the project's own photos, each from the others, or held-out photos.

use std::path::Path;

use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{Photo, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_import::cameras::read_cameras_of;
use quadratura_sites::photos::import_photos;

/// A photo to be predicted from others, and then compared with the prediction.
#[derive(Debug, Clone, PartialEq)]
pub struct PredictionTarget {
    /// The photo, undistorted.
    pub photo: Photo,
    /// The project's photos that must not be used.
    pub without: Vec<PhotoId>,
}

/// Makes a prediction target of each of the site's photos, to be predicted from all others.
pub fn leave_one_out(site: &Site) -> Vec<PredictionTarget> {
    let numbered = site.photos.iter().zip((0..).map(PhotoId));
    numbered.map(|(photo, id)| PredictionTarget { photo: photo.clone(), without: vec![id] }).collect()
}

/// Reads the photos of `cameras` whose files are in `photos`. Pinhole images of distorted ones are made in
/// `cache/photos`. The second list contains the problems with single photos.
///
/// # Errors
/// Returns errors that concern all photos, as [`quadratura_sites::open::open`] does.
pub fn held_out(
    cameras: &Path,
    photos: &Path,
    cache: &Path,
    task: &Task,
) -> Result<(Vec<PredictionTarget>, Vec<Error>)> {
    let cameras = read_cameras_of(photos, cameras, task)?;
    let import = import_photos(&cameras, photos, cache, task)?;
    cameras.notes.iter().chain(&import.notes).for_each(|note| task.note(note));
    let targets =
        import.photos.into_iter().map(|photo| PredictionTarget { photo, without: Vec::new() }).collect();
    Ok((targets, cameras.problems.into_iter().chain(import.problems).collect()))
}
