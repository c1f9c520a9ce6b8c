//! Reads calibrated cameras as COLMAP writes them, text or binary.
//!
//! [`read_cameras`] finds the files and streams them through one of two parsers (`text`, `binary`) into one
//! place that validates and collects (`assembly`). A problem with one camera, photo or point is reported and
//! leaves it out; reading stops only where a file cannot be understood at all.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::geometry::{Lens, Pinhole, Pose};
use crate::scene::SparsePoint;
use crate::task::Task;

mod assembly;
mod binary;
mod colmap_model;
mod locate;
mod photo_name;
mod text;

#[cfg(test)]
mod tests;

use assembly::Assembly;
pub use locate::holds_cameras;

/// The largest side of a photo in pixels, which is the limit of JPEG.
pub const LARGEST_SIDE: u64 = 65_535;
/// The largest number of pixels of a photo: more than any single-shot camera takes, and few enough to be
/// decoded in the memory of a desktop computer.
pub const MOST_PIXELS: u64 = 1 << 28;

/// A calibrated photo before import, with its distortion.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraPhoto {
    /// Unique path below the photo folder, with `/`; it never leads out of that folder.
    pub name: String,
    /// Size of the photo as taken; focal lengths and principal point of the distorted image, in pixels.
    pub camera: Pinhole,
    /// The distortion of the lens.
    pub lens: Lens,
    /// The pose, world to camera.
    pub pose: Pose,
    /// The place in the cameras' file: `line 7` or `byte 1024`.
    pub place: String,
}

/// The result of reading cameras.
#[derive(Debug, Default)]
pub struct Cameras {
    /// The file with the photos' poses.
    pub file: PathBuf,
    /// The photos, in file order.
    pub photos: Vec<CameraPhoto>,
    /// The sparse points, in file order; `observations` refer to indices of `photos`.
    pub points: Vec<SparsePoint>,
    /// One error for each camera, photo or point that was left out.
    pub problems: Vec<Error>,
    /// Notes for the user about things that left nothing out.
    pub notes: Vec<String>,
}

/// Reads COLMAP's `cameras`, `images` and, where it exists, `points3D`.
///
/// `path` is the folder with these files, a folder above it (`sparse`, `sparse/0` and `0` are searched), or
/// one of the files. Binary files take precedence over text files in the same folder, unless `path` is a text
/// file.
///
/// # Errors
/// [`Error::Input`] when there are no such files, when a file is not what its name says or ends too early, or
/// when no photo can be used; [`Error::Io`]; [`Error::Cancelled`].
pub fn read_cameras(path: &Path, task: &Task) -> Result<Cameras> {
    let found = locate::locate(path)?;
    let mut assembly = Assembly::new(&found);
    if found.binary {
        binary::read(&found, &mut assembly, task)?;
    } else {
        text::read(&found, &mut assembly, task)?;
    }
    assembly.finish(found.notes)
}

/// Returns the files that [`read_cameras`] would read; empty where there are none.
pub fn camera_files(path: &Path) -> Vec<PathBuf> {
    let files = locate::locate(path).ok();
    files.map_or(Vec::new(), |files| [files.cameras, files.images].into_iter().chain(files.points).collect())
}

/// The files of a COLMAP model.
#[derive(Debug)]
struct Files {
    binary: bool,
    cameras: PathBuf,
    images: PathBuf,
    points: Option<PathBuf>,
    notes: Vec<String>,
}

/// A camera as parsed, before validation.
struct RawCamera<'a> {
    id: u32,
    model: &'static colmap_model::ColmapModel,
    width: u64,
    height: u64,
    parameters: &'a [f64],
}

/// A photo as parsed, before validation.
struct RawImage<'a> {
    id: u32,
    /// Rotation, world to camera: w, x, y, z.
    quaternion: [f64; 4],
    translation: [f64; 3],
    camera: u32,
    name: &'a str,
    /// Image position in pixels and point id, for keypoints that have a point.
    observations: Vec<([f64; 2], u64)>,
}

/// The problems of one reading, limited in number, because a hostile file may have one in every line.
#[derive(Debug, Default)]
struct Problems {
    kept: Vec<Error>,
    dropped: BTreeMap<PathBuf, usize>,
}

impl Problems {
    const MOST: usize = 200;

    fn push(&mut self, file: &Path, problem: Error) {
        if self.kept.len() < Self::MOST {
            self.kept.push(problem);
        } else {
            *self.dropped.entry(file.to_path_buf()).or_default() += 1;
        }
    }

    fn finish(mut self) -> Vec<Error> {
        for (file, count) in self.dropped {
            let found = format!("{count} more problems that are not listed");
            self.kept.push(Error::input(file, "", found, "correct those above first"));
        }
        self.kept
    }
}
