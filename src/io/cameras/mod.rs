//! Calibrated cameras as COLMAP writes them, text or binary.
//!
//! [`read_cameras`] finds the files, streams them through one of two parsers (`text`, `binary`) into
//! one place that judges and keeps (`assembly`). What is wrong with one camera, photo or point is
//! reported and leaves it out; only a file that cannot be understood at all stops the reading.

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

/// The largest side of a photo in pixels: what JPEG can hold.
pub const LARGEST_SIDE: u64 = 65_535;
/// The most pixels of a photo: beyond any single-shot camera, and still below the memory of a
/// desk's machine when it is decoded.
pub const MOST_PIXELS: u64 = 1 << 28;

/// A photo as the cameras know it: before import, with its distortion.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraPhoto {
    /// Unique path below the photo folder, with `/`; it never leads out of that folder.
    pub name: String,
    /// Size of the photo as taken; focal lengths and principal point of its distorted image.
    pub camera: Pinhole,
    /// Its distortion.
    pub lens: Lens,
    /// World to camera.
    pub pose: Pose,
    /// Where the cameras' file names it: `line 7` or `byte 1024`.
    pub place: String,
}

/// What was read.
#[derive(Debug, Default)]
pub struct Cameras {
    /// The file with the photos' poses.
    pub file: PathBuf,
    /// In file order.
    pub photos: Vec<CameraPhoto>,
    /// In file order; `observations` count through `photos`.
    pub points: Vec<SparsePoint>,
    /// What was left out, and why; one each.
    pub problems: Vec<Error>,
    /// What the user should know and that left nothing out.
    pub notes: Vec<String>,
}

/// Reads COLMAP's `cameras`, `images` and, where it is there, `points3D`.
///
/// `path` is the folder with these files, a folder above it (`sparse`, `sparse/0`, `0` are looked
/// into), or one of the files. Binary files win over text files in the same folder, except over one
/// that was named itself.
///
/// # Errors
/// [`Error::Input`] when there are no such files, when a file is not what its name says or ends too
/// early, or when no photo at all could be used; [`Error::Io`]; [`Error::Cancelled`].
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

/// The files that [`read_cameras`] would read; none where there are none.
pub fn camera_files(path: &Path) -> Vec<PathBuf> {
    let files = locate::locate(path).ok();
    files.map_or(Vec::new(), |files| [files.cameras, files.images].into_iter().chain(files.points).collect())
}

/// The model's three files.
#[derive(Debug)]
struct Files {
    binary: bool,
    cameras: PathBuf,
    images: PathBuf,
    points: Option<PathBuf>,
    notes: Vec<String>,
}

/// A camera as parsed, not yet judged.
struct RawCamera<'a> {
    id: u32,
    model: &'static colmap_model::ColmapModel,
    width: u64,
    height: u64,
    parameters: &'a [f64],
}

/// A photo as parsed, not yet judged.
struct RawImage<'a> {
    id: u32,
    /// w, x, y, z.
    quaternion: [f64; 4],
    translation: [f64; 3],
    camera: u32,
    name: &'a str,
    /// Image position in pixels and point id, of those keypoints that have one.
    observations: Vec<([f64; 2], u64)>,
}

/// Problems of one reading, kept in number: a hostile file may hold one in every line.
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
            self.kept.push(Error::input(file, "", found, "mend those above first"));
        }
        self.kept
    }
}
