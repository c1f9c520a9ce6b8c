//! Rolling shutters: the motion of a camera while a photo was taken, and how far it moves what the photo shows.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DMat3, DQuat, DVec2, DVec3};
use roxmltree::Node;

use super::super::assembly::Assembly;
use super::super::foreign_text::{child, numbers};
use super::super::kept::CameraPhoto;
use super::super::pose::rotation_and_scale;
use quadratura_base::geometry::RollingShutter;
use quadratura_base::raster::robust::upper_median;

/// The motion of a camera from its middle row to its last one, in the camera's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Motion {
    /// An axis times an angle in radians.
    rotation: DVec3,
    /// In lengths of the chunk.
    translation: DVec3,
}

/// What a file says of the motion of a camera is none that a camera can have.
#[derive(Debug, Clone, Copy)]
pub(super) struct UnreadableMotion;

impl Motion {
    /// Reads the motion of a camera; `None` where it did not move.
    ///
    /// # Errors
    /// [`UnreadableMotion`] for what is no number, and for a motion that is larger than one during a photo can be.
    pub fn of(camera: Node<'_, '_>) -> Result<Option<Self>, UnreadableMotion> {
        let Some(node) = child(camera, "rolling_shutter") else { return Ok(None) };
        let text = |name: &str| child(node, name).and_then(|node| node.text()).unwrap_or_default();
        let vector = |text: &str| match text.trim().is_empty() {
            true => Ok(DVec3::ZERO),
            false => numbers::<3>(text, "").map(DVec3::from).map_err(|_| UnreadableMotion),
        };
        let rotation = match numbers::<9>(text("rotation"), "") {
            Ok(rows) => {
                let rotation = rotation_and_scale(DMat3::from_cols_array(&rows).transpose(), "");
                DQuat::from_mat3(&rotation.map_err(|_| UnreadableMotion)?.0).to_scaled_axis()
            }
            Err(_) => vector(text("rotation"))?,
        };
        let translation = vector(text("translation"))?;
        if rotation.length() >= 1.0 || translation.length() >= 1e6 {
            return Err(UnreadableMotion);
        }
        let moves = rotation != DVec3::ZERO || translation != DVec3::ZERO;
        Ok(moves.then_some(Self { rotation, translation }))
    }
}

/// The motions of photos.
#[derive(Debug, Default)]
pub(super) struct Shutters {
    /// Photos by their index, with the scale from lengths of the chunk to those of the world.
    motions: Vec<(u32, Motion, f64)>,
    /// The number of photos whose motion cannot be read.
    unreadable: usize,
}

/// A motion of fewer pixels is within what observations scatter.
const NOTABLE_PX: f64 = 0.5;

impl Shutters {
    /// Adds what is known of the motion of a photo; `scale` is that from lengths of the chunk to those of the world.
    pub fn add(&mut self, photo: u32, motion: Result<Option<Motion>, UnreadableMotion>, scale: f64) {
        match motion {
            Ok(Some(motion)) => self.motions.push((photo, motion, scale)),
            Ok(None) => {}
            Err(UnreadableMotion) => self.unreadable += 1,
        }
    }

    /// Returns whether the file says of no camera that it moved.
    pub fn is_empty(&self) -> bool {
        self.motions.is_empty() && self.unreadable == 0
    }

    /// Has the motions taken out of the photos, if the user wishes, or tells how far they move what the photos show. `depths` are
    /// the distances of what photos show, by index; the median holds for the others.
    pub fn apply(self, file: &Path, depths: &BTreeMap<u32, f64>, assembly: &mut Assembly<'_>) {
        let usual = upper_median(&mut depths.values().copied().collect::<Vec<_>>());
        let (mut largest, mut count) = (0.0f64, 0);
        for (photo, motion, scale) in self.motions {
            let depth = depths.get(&photo).copied().or(usual);
            // Without any distance the motion is that of what is far away.
            let translation = if depth.is_some() { motion.translation * scale } else { DVec3::ZERO };
            let shutter = RollingShutter {
                rotation: motion.rotation,
                motion: translation,
                depth: depth.unwrap_or(1.0),
            };
            let moved = displacement(assembly.taken(photo), shutter);
            largest = largest.max(moved);
            count += usize::from(moved > NOTABLE_PX);
            if assembly.options().rolling_shutter {
                assembly.shutter(photo, shutter);
            }
        }
        if count > 0 {
            let what = match assembly.options().rolling_shutter {
                true => "their pinhole images are resampled by row to the pose of the middle row",
                false => {
                    "they are used at the pose of the middle row; --rolling-shutter of `new`, or \"rolling_shutter\" in \
                     project.json, resamples them by row"
                }
            };
            assembly.note(format!(
                "{}: the cameras of {count} of the photos moved while a rolling shutter took them, which displaces their first and last rows \
                 by up to {largest:.1} px; {what}",
                file.display()
            ));
        }
        if self.unreadable > 0 {
            assembly.note(format!(
                "{}: the motion of a rolling shutter cannot be read for {} of the cameras, which are used as if they had stood still",
                file.display(),
                self.unreadable
            ));
        }
    }
}

/// Returns how far the motion moves the corners and the middles of the borders of a photo, in pixels.
fn displacement(photo: &CameraPhoto, shutter: RollingShutter) -> f64 {
    let (w, h) = (f64::from(photo.camera.width), f64::from(photo.camera.height));
    let still = CameraPhoto { shutter: None, ..photo.clone() };
    let moving = CameraPhoto { shutter: Some(shutter), ..photo.clone() };
    let at = [0.0, 0.5, 1.0].into_iter().flat_map(|x| [0.0, 1.0].map(|y| DVec2::new(x * w, y * h)));
    let moved = at.filter_map(|at| {
        // A little inside of the corner, which the lens may move out of its range.
        let ray = photo.camera.ray_in_camera(at * 0.9 + DVec2::new(w, h) * 0.05);
        let point = photo.pose.world_from_camera(ray * shutter.depth);
        Some(still.image_from_world(point)?.distance(moving.image_from_world(point)?))
    });
    moved.fold(0.0, f64::max)
}
