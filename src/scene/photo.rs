//! A photo with its camera, and the site they make with the model.

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::Model;
use crate::geometry::{Pinhole, Pose};

/// A photo: from import on an undistorted pinhole image with its own K and pose. The pixels stay
/// in the file; its valid area is its alpha (an image without alpha is valid everywhere) without what is masked.
#[derive(Debug, Clone, PartialEq)]
pub struct Photo {
    /// Unique name: the path below the photo folder as the cameras name it, with `/`.
    pub name: String,
    /// Size and K in pixels.
    pub camera: Pinhole,
    /// World to camera.
    pub pose: Pose,
    /// The pinhole image: the user's own file where nothing had to be resampled, else the cache.
    pub file: PathBuf,
    /// Pictures of what is no content of it (see `io::mask_file`), as large as the pinhole image.
    pub masks: Vec<PathBuf>,
}

/// A point that structure from motion triangulated.
#[derive(Debug, Clone, PartialEq)]
pub struct SparsePoint {
    /// In the cameras' world.
    pub position: DVec3,
    /// `(index of the photo: in the cameras' list while that is read, in [`Site::photos`] once a
    /// project is open; image position in pixels of the photo as taken, that is with its distortion)`.
    pub observations: Vec<(u32, DVec2)>,
}

/// The photos with their cameras, and the model, all in the cameras' world.
#[derive(Debug, Clone, PartialEq)]
pub struct Site {
    /// Sorted by name.
    pub photos: Vec<Photo>,
    /// In world coordinates.
    pub model: Arc<Model>,
}
