//! The plan for importing a photo: to use its own file, or a pinhole image made from it.

use std::path::{Path, PathBuf};

use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Pinhole, Undistortion};
use quadratura_base::scene::alike::composed;
use quadratura_base::scene::resample::undistorted;
use quadratura_base::scene::{Photo, PhotoPixels};
use quadratura_base::task::Task;
use quadratura_document::names::file_name_of_photo;
use quadratura_import::cameras::CameraPhoto;
use quadratura_import::photo::{Match, PhotoFolder, check_photo, make_pinhole_image, read_photo};

/// The plan for importing a photo.
pub(super) struct PhotoPlan {
    /// The photo with its own file or its pinhole image, which may still have to be made.
    pub photo: Photo,
    /// Notes for the user, each beginning with the photo's name.
    pub notes: Vec<String>,
    /// The photo's own file.
    source: PathBuf,
    /// The undistortion, for a photo with distortion.
    undistortion: Option<Undistortion>,
    /// The bytes per sample.
    sample_bytes: u64,
}

impl PhotoPlan {
    /// Makes the plan for the file that was found for a photo, from its header alone. Pinhole images go to
    /// `images`.
    ///
    /// # Errors
    /// Returns the reason why the photo cannot be used: [`Error::Input`] or [`Error::Io`].
    pub fn new(photo: &CameraPhoto, found: &Match, folder: &PhotoFolder, images: &Path) -> Result<Self> {
        let CameraPhoto { name, camera, pose, .. } = photo;
        let (source, difference) = located(photo, found, folder)?;
        let header = check_photo(&source, camera.width, camera.height)?;
        let undistortion = if photo.is_pinhole() {
            None
        } else {
            Some(photo.undistortion().ok_or_else(|| beyond_its_lens(photo, &source))?)
        };
        let (camera, file) = match &undistortion {
            None => (*camera, source.clone()),
            Some(to) => (to.pinhole, images.join(format!("{}.png", file_name_of_photo(name)))),
        };
        let lost = undistortion.as_ref().and_then(lost);
        let notes = difference.into_iter().chain(header.notes).chain(lost);
        let notes = notes.map(|note| format!("{name}: {note}")).collect();
        let photo = Photo {
            name: name.clone(),
            camera,
            pose: *pose,
            file,
            masks: Vec::new(),
            exposure: header.exposure,
        };
        Ok(Self { photo, notes, source, undistortion, sample_bytes: header.sample_bytes })
    }

    /// Returns true when the photo is used with a pinhole image.
    pub fn needs_image(&self) -> bool {
        self.undistortion.is_some()
    }

    /// Makes the pinhole image if one is needed and does not exist yet.
    ///
    /// # Errors
    /// Returns the errors of [`make_pinhole_image`].
    pub fn make_image(&self, task: &Task) -> Result<()> {
        match &self.undistortion {
            None => Ok(()),
            Some(to) => {
                make_pinhole_image(&self.source, to, &self.photo.file, &task.with_subject(&self.photo.name))
            }
        }
    }

    /// Reads the pixels of the pinhole image, without writing one.
    ///
    /// # Errors
    /// Returns the errors of [`read_photo`], or [`Error::Cancelled`].
    pub fn pixels(&self, task: &Task) -> Result<PhotoPixels> {
        let of = self.undistortion.as_ref().map_or(&self.photo.camera, |to| &to.photo);
        let pixels = read_photo(&self.source, of.width, of.height)?;
        match &self.undistortion {
            None => Ok(pixels),
            Some(to) => undistorted(&pixels, to, task),
        }
    }

    /// Returns the most memory in bytes that [`PhotoPlan::make_image`] takes: the photo's pixels, those of the
    /// image, and as much again for the compressed image.
    pub fn memory(&self) -> u64 {
        let pixels = |camera: &Pinhole| u64::from(camera.width) * u64::from(camera.height);
        let with = |to: &Undistortion| (4 * pixels(&to.photo) + 8 * pixels(&to.pinhole)) * self.sample_bytes;
        self.undistortion.as_ref().map_or(0, with)
    }
}

/// Returns the file of a photo, and a description of how its name differs from the photo's, if it does.
fn located(photo: &CameraPhoto, found: &Match, folder: &PhotoFolder) -> Result<(PathBuf, Option<String>)> {
    match found {
        Match::File(file, "") => Ok((folder.path(*file), None)),
        Match::File(file, difference) => {
            let note = format!("the file was found {difference}, as {}", folder.name(*file));
            Ok((folder.path(*file), Some(note)))
        }
        // Reading its header says what it is instead.
        Match::NotRead(file) => Ok((folder.path(*file), None)),
        Match::Missing => Err(missing(photo, folder)),
        Match::Ambiguous { files, photos } => Err(ambiguous(photo, folder, files, *photos)),
    }
}

/// Returns a note about pixels of the photo that the pinhole image does not show, if any.
fn lost(undistortion: &Undistortion) -> Option<String> {
    let percent = 100.0 * undistortion.lost;
    let why = "they lie more than 60 degrees off the axis, or where the lens model ends, or beyond twice \
               the photo's size";
    (percent > 0.0).then(|| format!("about {percent:.1} % of its pixels are left out: {why}"))
}

/// Makes the error for a photo outside of its lens model's valid range.
fn beyond_its_lens(photo: &CameraPhoto, file: &Path) -> Error {
    let found = format!("no pixel is in the valid range of the lens model ({})", photo.lens);
    Error::input(file, "", found, "calibrate the camera again, with a simpler model")
}

/// Makes the error for a photo without a file.
fn missing(photo: &CameraPhoto, folder: &PhotoFolder) -> Error {
    let found = "there is no file of this name, nor one in a sub-folder or in another format";
    let remedy = "put the photo there, or give the folder that the cameras' names are relative to";
    Error::input(folder.root().join(&photo.name), "", found, remedy)
}

/// Makes the error for a photo with several possible files.
fn ambiguous(photo: &CameraPhoto, folder: &PhotoFolder, files: &[usize], photos: usize) -> Error {
    let listed: Vec<_> = files.iter().take(4).map(|&file| folder.name(file)).collect();
    let more = if files.len() > listed.len() { ", .." } else { "" };
    let listed = format!("{}{more}", listed.join(", "));
    let found = match photos {
        1 => format!("{} matches {} files ({listed})", photo.name, files.len()),
        _ => format!("{} and {} other photos match {listed}", photo.name, photos - 1),
    };
    let same = files.iter().all(|file| composed(folder.name(*file)) == composed(folder.name(files[0])));
    let found = if files.len() > 1 && same {
        format!("{found}, whose names differ in their Unicode form")
    } else {
        found
    };
    let remedy = "give the files the paths in the cameras' file";
    Error::input(folder.path(files[0]), "", found, remedy)
}
