//! Calibrated cameras: COLMAP's files, text or binary, `transforms.json`, Bundler's `.out`.
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
mod format;
mod formats;
mod kept;
mod lines;
mod locate;
mod photo_name;
mod photo_paths;
mod pose;
mod raw;
mod recognise;
mod reconstruction;
mod rigs;
mod sizes;
mod text;
mod transforms;
mod transforms_lens;

#[cfg(test)]
mod spellings;
#[cfg(test)]
mod tests;
mod three_formats;
mod wrong_files;

pub use assembly::Assembly;
pub use format::CameraFormat;
pub use formats::plug_in;
pub use kept::{CameraPhoto, Cameras, LARGEST_SIDE, MOST_PIXELS};
pub use locate::{CamerasThere, accepted, cameras_in, extensions, is_camera_file};
pub use raw::RawCamera;
pub use reconstruction::ReconstructionFiles;
use sizes::SizeSource;

/// The names of the cameras' photos, and the number of points; the photos' sizes are not needed for them.
#[derive(Debug, Default)]
pub struct CameraNames {
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
    read_with(path, SizeSource::Named, task)
}

/// Reads cameras like [`read_cameras`], with the sizes of the photos in a folder where the format does not state them.
///
/// # Errors
/// Returns the errors of [`read_cameras`], and one when the folder is needed and cannot be read.
pub fn read_cameras_of(photos: &Path, path: &Path, task: &Task) -> Result<Cameras> {
    read_with(path, SizeSource::Folder(photos), task)
}

/// Reads the names of the cameras' photos, whether these photos exist or not.
///
/// # Errors
/// As [`read_cameras`].
pub fn read_names(path: &Path, task: &Task) -> Result<CameraNames> {
    let Cameras { photos, points, problems, notes, .. } = read_with(path, SizeSource::Unneeded, task)?;
    let names = photos.into_iter().map(|photo| photo.name).collect();
    Ok(CameraNames { names, points: points.len(), problems, notes })
}

fn read_with(path: &Path, sizes: SizeSource<'_>, task: &Task) -> Result<Cameras> {
    let located = locate::locate(path)?;
    guarded(path, "export the cameras again", || {
        let mut assembly = Assembly::new(&located.files, sizes);
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
