//! What is kept of the files: photos with their cameras, and points.

use std::path::PathBuf;

use glam::{DVec2, DVec3};

use super::reprojection::Reprojection;
use quadratura_base::error::Error;
use quadratura_base::geometry::{Lens, Pinhole, Pose, RollingShutter, Undistortion};
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
    /// World to camera; of the middle row, if the camera moved.
    pub pose: Pose,
    /// The motion while the photo was taken, where it is to be taken out of the photo.
    pub shutter: Option<RollingShutter>,
    /// Where the cameras' file names it: `line 7` or `byte 1024`.
    pub place: String,
}

impl CameraPhoto {
    /// Returns whether the photo is a pinhole image already.
    pub fn is_pinhole(&self) -> bool {
        self.lens.is_none() && self.shutter.is_none()
    }

    /// Finds the photo's pinhole image; `None` where the lens's range contains no pixel of it.
    pub fn undistortion(&self) -> Option<Undistortion> {
        Undistortion::of_moving(&self.camera, self.lens, self.shutter)
    }

    /// Returns where the photo as taken shows a point of the world, in pixels; `None` for one behind the camera, or where the
    /// lens model has no value.
    pub fn image_from_world(&self, point: DVec3) -> Option<DVec2> {
        let at_rest = |point: DVec3| {
            let bent = self.lens.distort((point.z > 0.0).then(|| point.truncate() / point.z)?);
            let Pinhole { fx, fy, cx, cy, .. } = self.camera;
            Some(DVec2::new(fx * bent.x + cx, fy * bent.y + cy)).filter(|at| at.is_finite())
        };
        let point = self.pose.camera_from_world(point);
        match &self.shutter {
            None => at_rest(point),
            Some(shutter) => shutter.image_of(point, self.camera.height.into(), at_rest),
        }
    }
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
    /// How far the points' observations lie from where the cameras show them; `None` where too few are observed.
    pub reprojection: Option<Reprojection>,
    /// The entries that were left out, one error each.
    pub problems: Vec<Error>,
    /// The remarks for the user about cameras that were used.
    pub notes: Vec<String>,
}
