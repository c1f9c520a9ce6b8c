//! The photos to be predicted: the project's own photos, each from the others, or held-out photos.

use std::path::Path;

use crate::photos::import_photos;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{Photo, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_import::cameras::read_cameras_of;

/// A photo to be predicted.
#[derive(Debug, Clone, PartialEq)]
pub struct Question {
    /// The photo, undistorted.
    pub photo: Photo,
    /// The project's photos that must not be used.
    pub without: Vec<PhotoId>,
}

/// Makes a question of each of the site's photos, to be predicted from all others.
pub fn leave_one_out(site: &Site) -> Vec<Question> {
    let numbered = site.photos.iter().zip((0..).map(PhotoId));
    numbered.map(|(photo, id)| Question { photo: photo.clone(), without: vec![id] }).collect()
}

/// Reads the photos of `cameras` whose files are in `photos`. Pinhole images of distorted ones are made in
/// `cache/photos`. The second list contains the problems with single photos.
///
/// # Errors
/// Returns errors that concern all photos, as [`crate::open::open`] does.
pub fn held_out(
    cameras: &Path,
    photos: &Path,
    cache: &Path,
    task: &Task,
) -> Result<(Vec<Question>, Vec<Error>)> {
    let cameras = read_cameras_of(photos, cameras, task)?;
    let import = import_photos(&cameras, photos, cache, task)?;
    cameras.notes.iter().chain(&import.notes).for_each(|note| task.note(note));
    let questions = import.photos.into_iter().map(|photo| Question { photo, without: Vec::new() }).collect();
    Ok((questions, cameras.problems.into_iter().chain(import.problems).collect()))
}
