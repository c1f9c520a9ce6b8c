//! A photo as a witness of relief: what it shows where, small enough to keep for hundreds of photos.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::detail::{Detail, levels};
use crate::geometry::{Pinhole, Pose};
use crate::projection::Projector;
use crate::projection::surface::Surface;
use crate::scene::{FaceId, Model, PhotoPixels};

/// A photo's details and which faces it shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Witness {
    /// Size and K in pixels.
    pub camera: Pinhole,
    /// World to camera.
    pub pose: Pose,
    levels: Vec<Option<Detail>>,
    /// The face in the middle of each block of [`BLOCK_PX`] pixels, row by row from the top.
    shown: Vec<Option<FaceId>>,
    columns: u32,
}

/// Side of a block, in pixels: about a cell's.
pub(super) const BLOCK_PX: u32 = 8;

/// Two surfaces this near to each other, relative to their depth, are one: windows in their wall.
pub(super) const SAME_SURFACE: f64 = 5e-4;

impl Witness {
    /// Of a photo with its pixels; `surface` is the whole model's.
    pub fn new(projector: &Projector, pixels: &PhotoPixels, surface: &Surface) -> Self {
        let Projector { camera, pose, .. } = projector;
        let [columns, rows] = [camera.width, camera.height].map(|side| side.div_ceil(BLOCK_PX));
        let eye = pose.center_in_world();
        let shown = |block: u32| {
            let corner = DVec2::new(f64::from(block % columns), f64::from(block / columns));
            let ray = camera.ray_in_camera((corner + 0.5) * f64::from(BLOCK_PX));
            surface.nearest(eye, pose.rotation.transpose() * ray).map(|hit| hit.face)
        };
        let shown = (0..columns * rows).into_par_iter().map(shown).collect();
        Self { camera: *camera, pose: *pose, levels: levels(pixels), shown, columns }
    }

    /// Of a photo whose pixels are not known: it shows nothing.
    pub fn blind(projector: &Projector) -> Self {
        let Projector { camera, pose, .. } = projector;
        Self { camera: *camera, pose: *pose, levels: Vec::new(), shown: Vec::new(), columns: 0 }
    }

    /// Its pixels are known.
    pub fn sees(&self) -> bool {
        !self.levels.is_empty()
    }

    /// How many blocks show each face: sorted by face, each above zero.
    pub fn faces(&self) -> Vec<(FaceId, u32)> {
        let mut faces: Vec<FaceId> = self.shown.iter().flatten().copied().collect();
        faces.sort_unstable();
        faces.chunk_by(|a, b| a == b).map(|same| (same[0], same.len() as u32)).collect()
    }

    /// Whether the photo shows `point`, which lies on a face and projects to `image_px` within the photo.
    pub fn shows(&self, model: &Model, face: FaceId, point: DVec3, image_px: DVec2) -> bool {
        let block = (image_px / f64::from(BLOCK_PX)).as_uvec2();
        let Some(shown) = self.shown[(block.y * self.columns + block.x) as usize] else { return false };
        if shown == face {
            return true;
        }
        let plane = &model.face(shown).plane;
        let eye = self.pose.center_in_world();
        let height = plane.signed_distance(eye);
        let along = -height / plane.normal.dot(point - eye);
        (along - 1.0).abs() <= SAME_SURFACE
    }

    /// The detail with about `texel_px` pixels to a texel, and the pixels that it has.
    pub fn detail(&self, texel_px: f64) -> (&Detail, f64) {
        let wanted = texel_px.log2().round().clamp(0.0, 31.0) as usize;
        let kept = (0..).zip(&self.levels).filter_map(|(level, detail)| Some((level, detail.as_ref()?)));
        let nearest = kept.min_by_key(|(level, _): &(usize, _)| level.abs_diff(wanted));
        let (level, detail) = nearest.expect("the coarsest level is always kept");
        (detail, (level as f64).exp2())
    }
}
