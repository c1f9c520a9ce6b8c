//! What is kept of the files: photos with their cameras, and points.

use std::path::PathBuf;

use quadratura_base::error::Error;
use quadratura_base::geometry::{Lens, Pinhole, Pose};
use quadratura_base::scene::SparsePoint;

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
    /// The lens distortion.
    pub lens: Lens,
    /// World to camera.
    pub pose: Pose,
    /// Where the cameras' file names it: `line 7` or `byte 1024`.
    pub place: String,
}

/// The cameras that were read, with problems and notes.
#[derive(Debug, Default)]
pub struct Cameras {
    /// The file with the photos' poses.
    pub file: PathBuf,
    /// The number of photos that the files list, with those that cannot be used.
    pub listed: usize,
    /// In file order.
    pub photos: Vec<CameraPhoto>,
    /// In file order; `observations` count through `photos`.
    pub points: Vec<SparsePoint>,
    /// The entries that were left out, one error each.
    pub problems: Vec<Error>,
    /// The remarks for the user about cameras that were used.
    pub notes: Vec<String>,
}
