//! One photo of the plane sweep: its details and the faces that it shows, small enough to keep for hundreds
//! of photos.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::detail::{Detail, levels};
use crate::Projector;
use crate::model_surface::ModelSurface;
use quadratura_base::error::Result;
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::{FaceId, Model, PhotoPixels};

/// The data of one photo for the plane sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SweepView {
    /// Image size and intrinsics in pixels.
    pub camera: Pinhole,
    /// The pose, world to camera.
    pub pose: Pose,
    levels: Vec<Option<Detail>>,
    /// The face at the centre of each block of [`BLOCK_PX`] pixels, row by row from the top.
    faces_of_blocks: Vec<Option<FaceId>>,
    columns: u32,
}

/// Photos prepared for the plane sweep, which may be elsewhere than in memory until they are asked for.
pub trait SweepViews: Sync {
    /// Returns the camera and the pose of a photo.
    fn camera(&self, number: usize) -> (&Pinhole, &Pose);

    /// Returns a photo.
    ///
    /// # Errors
    /// Those of reading it back.
    fn view(&self, number: usize) -> Result<Arc<SweepView>>;
}

impl SweepViews for Vec<Arc<SweepView>> {
    fn camera(&self, number: usize) -> (&Pinhole, &Pose) {
        (&self[number].camera, &self[number].pose)
    }

    fn view(&self, number: usize) -> Result<Arc<SweepView>> {
        Ok(self[number].clone())
    }
}

/// Side of a block, in pixels: about that of a cell.
pub(super) const BLOCK_PX: u32 = 8;

/// The relative difference in depth up to which two surfaces count as one, such as windows in their wall.
pub(super) const SAME_SURFACE: f64 = 5e-4;

impl SweepView {
    /// Prepares a photo from its pixels; `surface` is the whole model's.
    pub fn new(projector: &Projector, pixels: &PhotoPixels, surface: &ModelSurface) -> Self {
        let Projector { camera, pose, .. } = projector;
        let [columns, rows] = [camera.width, camera.height].map(|side| side.div_ceil(BLOCK_PX));
        let eye = pose.center_in_world();
        let face_of_block = |block: u32| {
            let corner = DVec2::new(f64::from(block % columns), f64::from(block / columns));
            let ray = camera.ray_in_camera((corner + 0.5) * f64::from(BLOCK_PX));
            surface.nearest(eye, pose.rotation.transpose() * ray).map(|hit| hit.face)
        };
        let faces_of_blocks = (0..columns * rows).into_par_iter().map(face_of_block).collect();
        Self { camera: *camera, pose: *pose, levels: levels(pixels), faces_of_blocks, columns }
    }

    /// Returns the memory that it takes, in bytes.
    pub fn bytes(&self) -> u64 {
        let blocks = self.faces_of_blocks.len() * size_of::<Option<FaceId>>();
        self.levels.iter().flatten().map(Detail::bytes).sum::<u64>() + blocks as u64
    }

    /// Counts the blocks that show each face: sorted by face, each count above zero.
    pub fn faces(&self) -> Vec<(FaceId, u32)> {
        let mut faces: Vec<FaceId> = self.faces_of_blocks.iter().flatten().copied().collect();
        faces.sort_unstable();
        faces.chunk_by(|a, b| a == b).map(|same| (same[0], same.len() as u32)).collect()
    }

    /// Returns true when the photo shows `point`, which lies on a face and projects to `image_px` within the
    /// photo.
    pub fn shows(&self, model: &Model, face: FaceId, point: DVec3, image_px: DVec2) -> bool {
        let block = (image_px / f64::from(BLOCK_PX)).as_uvec2();
        let Some(visible) = self.faces_of_blocks[(block.y * self.columns + block.x) as usize] else {
            return false;
        };
        if visible == face {
            return true;
        }
        let plane = &model.face(visible).plane;
        let eye = self.pose.center_in_world();
        let height = plane.signed_distance(eye);
        let along = -height / plane.normal.dot(point - eye);
        (along - 1.0).abs() <= SAME_SURFACE
    }

    /// Returns the detail with about `texel_px` pixels per texel, and its actual number of pixels per texel.
    pub fn detail(&self, texel_px: f64) -> (&Detail, f64) {
        let wanted = texel_px.log2().round().clamp(0.0, 31.0) as usize;
        let kept = (0..).zip(&self.levels).filter_map(|(level, detail)| Some((level, detail.as_ref()?)));
        let nearest = kept.min_by_key(|(level, _): &(usize, _)| level.abs_diff(wanted));
        let (level, detail) = nearest.expect("the coarsest level is always kept");
        (detail, (level as f64).exp2())
    }
}
