//! Invented scenes with known answers, for tests, benchmarks and examples.
//!
//! [`closed_form`] holds the situations that coarse models are made of, each with the layers that
//! it must give; [`random`] makes scenes without end from seeds; [`large`] makes the heavy ones.
//!
//! ```
//! use quadratura::scene::synthetic::{Truth, closed_form};
//!
//! let scene = closed_form::two_quads();
//! assert_eq!(scene.model.faces.len(), 2);
//! assert_eq!(scene.truth, Truth::Layers(vec![vec!["near"], vec!["far"]]));
//! ```

pub mod closed_form;
pub mod dice;
pub mod large;
mod modeller;
pub mod random;

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DMat3, DVec3};

pub use dice::Dice;
pub use modeller::Modeller;

use super::{Model, Photo, Site};
use crate::geometry::{Pinhole, Pose};

/// A model and one camera that looks at it.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Says what the scene is about; with the seed, where there is one.
    pub name: String,
    /// In world coordinates.
    pub model: Arc<Model>,
    /// Size and K in pixels.
    pub camera: Pinhole,
    /// World to camera.
    pub pose: Pose,
    /// What the visibility sort must find.
    pub truth: Truth,
}

/// What is known of a scene beforehand.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Truth {
    /// The names of the objects in the working set, by visibility layer, sorted. Each object is
    /// whole, nothing is cut and nothing forgiven.
    Layers(Vec<Vec<&'static str>>),
    /// Some faces occlude each other in a circle and have to be cut.
    Cycle,
    /// Only the invariants.
    Unknown,
}

impl Scene {
    /// The photo of this scene; it has no file.
    pub fn photo(&self) -> Photo {
        Photo {
            name: self.name.clone(),
            camera: self.camera,
            pose: self.pose,
            file: PathBuf::new(),
            masks: Vec::new(),
        }
    }

    /// The site with this one photo.
    pub fn site(&self) -> Site {
        Site { photos: vec![self.photo()], model: self.model.clone() }
    }

    /// The same scene photographed with another number of pixels, in the same proportions.
    pub fn resized(mut self, width: u32) -> Self {
        let scale = f64::from(width) / f64::from(self.camera.width);
        let Pinhole { height, fx, fy, cx, cy, .. } = self.camera;
        let height = (f64::from(height) * scale).round() as u32;
        let [fx, fy, cx, cy] = [fx, fy, cx, cy].map(|length_px| length_px * scale);
        self.camera = Pinhole { width, height, fx, fy, cx, cy };
        self
    }
}

/// A camera with its principal point in the centre; `focal_px` in both directions.
pub fn centred(width: u32, height: u32, focal_px: f64) -> Pinhole {
    let (cx, cy) = (0.5 * f64::from(width), 0.5 * f64::from(height));
    Pinhole { width, height, fx: focal_px, fy: focal_px, cx, cy }
}

/// The camera frame is the world: x right, y down, z forward.
pub fn camera_is_world() -> Pose {
    Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO }
}

/// A camera at `eye` that looks at `target`, in a world with z up. They must not be one above the
/// other.
pub fn look_at(eye: DVec3, target: DVec3) -> Pose {
    let forward = (target - eye).normalize();
    let right = forward.cross(DVec3::Z).normalize();
    let down = forward.cross(right);
    let rotation = DMat3::from_cols(right, down, forward).transpose();
    Pose { rotation, translation: -(rotation * eye) }
}

#[cfg(test)]
mod tests;
