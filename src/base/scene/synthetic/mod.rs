//! Synthetic scenes with known answers, for tests, benchmarks and examples.
//!
//! [`closed_form`] holds the typical situations of coarse models, each with the layers that the sort must find;
//! [`farmyard`] is a scene of a paper; [`random`] makes any number of scenes from seeds; [`large`] makes heavy ones.
//!
//! ```
//! use quadratura_base::scene::synthetic::{Truth, closed_form};
//!
//! let scene = closed_form::two_quads();
//! assert_eq!(scene.model.faces.len(), 2);
//! assert_eq!(scene.truth, Truth::Layers(vec![vec!["near"], vec!["far"]]));
//! ```

pub mod closed_form;
pub mod farmyard;
pub mod large;
mod modeller;
pub mod random;
pub mod rng;

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DMat3, DVec3};

pub use modeller::Modeller;
pub use rng::Rng;

use super::{Model, Photo, Site};
use crate::geometry::{Pinhole, Pose};

/// A model and one camera that looks at it.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// A description of the scene, with the seed where there is one.
    pub name: String,
    /// The model in world coordinates.
    pub model: Arc<Model>,
    /// The camera: size and K in pixels.
    pub camera: Pinhole,
    /// The pose, world to camera.
    pub pose: Pose,
    /// The expected result of the visibility sort.
    pub truth: Truth,
}

/// The expected result of the visibility sort, as far as it is known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Truth {
    /// The names of the objects in the working set, by visibility layer, sorted. Each object is one element,
    /// nothing is cut and no occlusion is ignored.
    Layers(Vec<Vec<&'static str>>),
    /// Some faces occlude each other in a cycle and have to be cut.
    Cycle,
    /// Nothing beyond the invariants is known.
    Unknown,
}

impl Scene {
    /// Returns the scene's photo, which has no file.
    pub fn photo(&self) -> Photo {
        Photo {
            name: self.name.clone(),
            camera: self.camera,
            pose: self.pose,
            file: PathBuf::new(),
            masks: Vec::new(),
            exposure: None,
        }
    }

    /// Returns the site with this one photo.
    pub fn site(&self) -> Site {
        Site { photos: vec![self.photo()], model: self.model.clone() }
    }

    /// Returns the scene photographed at another width in pixels, with the same proportions.
    pub fn resized(mut self, width: u32) -> Self {
        let scale = f64::from(width) / f64::from(self.camera.width);
        let Pinhole { height, fx, fy, cx, cy, .. } = self.camera;
        let height = (f64::from(height) * scale).round() as u32;
        let [fx, fy, cx, cy] = [fx, fy, cx, cy].map(|length_px| length_px * scale);
        self.camera = Pinhole { width, height, fx, fy, cx, cy };
        self
    }
}

/// Makes a camera with the principal point in the centre and the same focal length in both directions.
pub fn centred(width: u32, height: u32, focal_px: f64) -> Pinhole {
    let (cx, cy) = (0.5 * f64::from(width), 0.5 * f64::from(height));
    Pinhole { width, height, fx: focal_px, fy: focal_px, cx, cy }
}

/// Returns the pose whose camera frame is the world: x right, y down, z forward.
pub fn camera_is_world() -> Pose {
    Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO }
}

/// Returns the pose of a camera at `eye` that looks at `target`, in a world with z up. The view must not be
/// vertical.
pub fn look_at(eye: DVec3, target: DVec3) -> Pose {
    let forward = (target - eye).normalize();
    let right = forward.cross(DVec3::Z).normalize();
    let down = forward.cross(right);
    let rotation = DMat3::from_cols(right, down, forward).transpose();
    Pose { rotation, translation: -(rotation * eye) }
}

#[cfg(test)]
mod tests;
