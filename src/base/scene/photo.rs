//! Photos with their cameras, and the site that they form with the model.

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::Model;
use crate::geometry::{Pinhole, Pose};

/// The index of a photo in [`Site::photos`]. Whatever lists one entry per photo is in the same order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct PhotoId(pub u32);

impl PhotoId {
    /// Returns the id of the photo at a position.
    pub fn new(position: usize) -> Self {
        Self(position as u32)
    }

    /// Returns the position in lists with one entry per photo.
    pub fn index(self) -> usize {
        self.0 as usize
    }

    /// Returns the ids of `count` photos.
    pub fn all(count: usize) -> impl ExactSizeIterator<Item = Self> + DoubleEndedIterator + Clone {
        (0..count as u32).map(Self)
    }
}

/// A photo. From import on it is an undistorted pinhole image with its own K and pose. The pixels stay in the file;
/// the valid area is where alpha is full (everywhere in an image without alpha), without the masked pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Photo {
    /// The unique name: the path below the photo folder as the cameras file gives it, with `/`.
    pub name: String,
    /// The camera: size and K in pixels.
    pub camera: Pinhole,
    /// The pose, world to camera.
    pub pose: Pose,
    /// The file of the pinhole image: the user's own file where nothing had to be resampled, else one in the cache.
    pub file: PathBuf,
    /// Mask files that mark pixels as not part of the photo (see `io::mask_file`), as large as the pinhole image.
    pub masks: Vec<PathBuf>,
    /// What the camera wrote down about the exposure; `None` where it did not.
    pub exposure: Option<CameraExposure>,
}

/// The exposure that a camera wrote into a photo's file. All values are positive and finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraExposure {
    /// The exposure time in seconds.
    pub seconds: f64,
    /// The aperture: focal length over diameter.
    pub f_number: f64,
    /// The sensitivity, ISO.
    pub iso: f64,
    /// Whether a flash fired.
    pub flash: bool,
}

impl CameraExposure {
    /// Returns the natural logarithm of how bright a photo shows the same light, up to a constant of its camera. `None` with a flash,
    /// which is a light of its own.
    pub fn log(&self) -> Option<f64> {
        (!self.flash).then(|| (self.seconds * self.iso / self.f_number.powi(2)).ln())
    }
}

/// A point that structure from motion triangulated, with its observations.
#[derive(Debug, Clone, PartialEq)]
pub struct SparsePoint {
    /// The position in the cameras' world.
    pub position: DVec3,
    /// The observations: the photo's index (into the cameras' list while that is read, into [`Site::photos`] once a
    /// project is open), and the image position in pixels of the photo as taken, with its distortion.
    pub observations: Vec<(u32, DVec2)>,
}

/// A site: the photos with their cameras, and the model, all in the cameras' world.
#[derive(Debug, Clone, PartialEq)]
pub struct Site {
    /// The photos, sorted by name.
    pub photos: Vec<Photo>,
    /// The model in world coordinates.
    pub model: Arc<Model>,
}

impl Site {
    /// Returns the photo with this id.
    pub fn photo(&self, id: PhotoId) -> &Photo {
        &self.photos[id.index()]
    }

    /// Returns the ids of all photos, in order.
    pub fn photo_ids(&self) -> impl ExactSizeIterator<Item = PhotoId> + DoubleEndedIterator + Clone + use<> {
        PhotoId::all(self.photos.len())
    }

    /// Returns all photos with their ids, in order.
    pub fn numbered_photos(&self) -> impl ExactSizeIterator<Item = (PhotoId, &Photo)> + Clone {
        self.photo_ids().zip(&self.photos)
    }

    /// Returns the id of the photo with exactly this name.
    pub fn photo_named(&self, name: &str) -> Option<PhotoId> {
        self.photos.iter().position(|photo| photo.name == name).map(PhotoId::new)
    }
}

/// Returns the mean up direction of the photos: most are taken with a roughly level camera.
pub fn up(photos: &[Photo]) -> DVec3 {
    up_of(photos.iter().map(|photo| &photo.pose))
}

/// Returns the mean up direction of cameras.
pub fn up_of<'a>(poses: impl Iterator<Item = &'a Pose>) -> DVec3 {
    let ups = poses.map(|pose| -(pose.rotation.transpose() * DVec3::Y));
    ups.sum::<DVec3>().try_normalize().unwrap_or(DVec3::Z)
}
