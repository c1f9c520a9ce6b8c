//! Calibrated cameras of other programs: COLMAP, Metashape, Meshroom, OpenSfM, OpenMVG, nerfstudio, VisualSFM, Bundler, RealityScan,
//! fSpy, Pix4D, MVE, Polycam.
//!
//! [`read_cameras`] finds the files and streams them through their format's reader (`formats` has the table)
//! into one place that judges and keeps (`assembly`). What is wrong with one camera, photo or point is
//! reported and leaves it out; only a file that cannot be understood at all stops the reading.

use std::path::{Path, PathBuf};

use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_files::guarded::guarded;

mod assembly;
mod binary;
mod bundler;
mod bundler_list;
mod colmap;
mod colmap_model;
mod foreign_text;
mod format;
mod formats;
mod fspy;
mod kept;
mod lines;
mod locate;
mod meshroom;
mod metashape;
mod mve;
mod nvm;
mod openmvg;
mod opensfm;
mod options;
mod photo_name;
mod photo_paths;
mod pix4d;
mod polycam;
mod pose;
mod raw;
mod realityscan;
mod recognise;
mod reconstruction;
mod reprojection;
mod rigs;
mod sizes;
mod text;
mod transforms;
mod transforms_lens;
mod triangulate;

#[cfg(test)]
mod invented;
#[cfg(test)]
mod spellings;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod three_formats;
#[cfg(test)]
mod wrong_files;

pub use assembly::Assembly;
pub use format::CameraFormat;
pub use formats::plug_in;
pub use kept::{CameraPhoto, Cameras, LARGEST_SIDE, MOST_PIXELS};
pub use locate::{CamerasThere, accepted, cameras_in, described, extensions, is_camera_file, programs};
pub use options::CameraOptions;
pub use raw::RawCamera;
pub use reconstruction::ReconstructionFiles;
pub use reprojection::Reprojection;
use sizes::SizeSource;

/// The names of the cameras' photos, and the number of points; the photos' sizes are not needed for them.
#[derive(Debug, Default)]
pub struct CameraNames {
    /// The program, or programs, that write such files.
    pub program: &'static str,
    /// The photos' names, in file order.
    pub names: Vec<String>,
    /// The number of points.
    pub points: usize,
    /// The entries that were left out, one error each.
    pub problems: Vec<Error>,
    /// The remarks for the user about cameras that were used.
    pub notes: Vec<String>,
}

/// Reads cameras: for COLMAP its `cameras`, `images` and, where it is there, `points3D`.
///
/// `path` is the folder with the files, a folder above it (for COLMAP `sparse`, `sparse/0`, `0` are looked
/// into), or one of the files, whose content says which format it is. Of several formats in one folder COLMAP's comes
/// first; COLMAP's binary files win over text files in the same folder, except over one that was named itself.
///
/// Where a format does not state the sizes of photos, they are read from the photos that it names;
/// [`read_cameras_of`] takes them from a folder instead.
///
/// # Errors
/// [`Error::Input`] when there are no such files, when a file is not what its name says or ends too
/// early, or when no photo at all could be used; [`Error::Io`]; [`Error::Cancelled`].
pub fn read_cameras(path: &Path, task: &Task) -> Result<Cameras> {
    read_with(path, SizeSource::Named, &CameraOptions::default(), task)
}

/// Reads cameras like [`read_cameras`], with the sizes of the photos in a folder where the format does not state them.
///
/// # Errors
/// Returns the errors of [`read_cameras`], and one when the folder is needed and cannot be read.
pub fn read_cameras_of(photos: &Path, path: &Path, task: &Task) -> Result<Cameras> {
    read_cameras_as(photos, path, &CameraOptions::default(), task)
}

/// Reads cameras like [`read_cameras_of`], in the way that the user decided.
///
/// # Errors
/// As [`read_cameras_of`], and [`Error::Input`] for an option that the format does not have.
pub fn read_cameras_as(photos: &Path, path: &Path, options: &CameraOptions, task: &Task) -> Result<Cameras> {
    read_with(path, SizeSource::Folder(photos), options, task)
}

/// Reads the names of the cameras' photos, whether these photos exist or not.
///
/// # Errors
/// As [`read_cameras`].
pub fn read_names(path: &Path, task: &Task) -> Result<CameraNames> {
    let Cameras { photos, points, problems, notes, .. } =
        read_with(path, SizeSource::Unneeded, &CameraOptions::default(), task)?;
    let names = photos.into_iter().map(|photo| photo.name).collect();
    let program = locate::locate(path)?.format.format().program();
    Ok(CameraNames { program, names, points: points.len(), problems, notes })
}

fn read_with(path: &Path, sizes: SizeSource<'_>, options: &CameraOptions, task: &Task) -> Result<Cameras> {
    let located = locate::locate(path)?;
    if let Some(chunk) = options.chunk.as_ref().filter(|_| !located.format.format().has_chunks()) {
        let found = format!("the chunk {chunk:?} was asked for, and only files of Metashape have chunks");
        return Err(Error::input(path, "", found, "leave out the chunk"));
    }
    guarded(path, "export the cameras again", || {
        let mut assembly = Assembly::new(&located.files, sizes, options);
        located.format.format().read(&located.files, &mut assembly, task)?;
        assembly.finish(located.files.notes)
    })
}

/// Lists the files that [`read_cameras`] reads; the list is empty where there are no cameras.
pub fn camera_files(path: &Path) -> Vec<PathBuf> {
    locate::locate(path).map_or(Vec::new(), |located| located.files.all())
}

/// Checks that a path to cameras exists.
///
/// # Errors
/// [`Error::Input`], which names a folder above it with cameras, where there is one.
pub fn check_exists(path: &Path) -> Result<()> {
    if path.exists() { Ok(()) } else { locate::locate(path).map(|_| ()) }
}
