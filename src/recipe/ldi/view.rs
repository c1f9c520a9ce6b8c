//! Views of layered depth images, without a project.

use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;

use crate::error::Result;
use crate::geometry::Pose;
use crate::ldi::{Ldi, WarpOptions, warp};
use crate::projection::{Picture, Shot};
use crate::recipe::views::{RequestedView, RequestedViews, ViewRequest, views};
use crate::scene::{Model, Photo, Site};
use crate::task::Task;

/// The share of depth pixels from which on a picture is noted as taken from too near.
const MOST_TOO_NEAR: f64 = 0.01;

/// Returns the requested views: cameras of files, camera paths, and the reference cameras of the images, which stand for the
/// photos of a project; [`RequestedView::photo`] is then the index of the image.
///
/// # Errors
/// Returns the errors of [`views`].
pub fn views_of(ldis: &[Ldi], asked: &ViewRequest, task: &Task) -> Result<RequestedViews> {
    let name = |ldi: &Ldi| ldi.sources.first().cloned().unwrap_or_else(|| "view".to_owned());
    let unique = |(index, ldi): (usize, &Ldi)| {
        let before = ldis[..index].iter().filter(|other| name(other) == name(ldi)).count();
        let name = PathBuf::from(name(ldi));
        let stem = name.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let extension = name.extension().map(|extension| format!(".{}", extension.to_string_lossy()));
        // Images of one photo give pictures of different names.
        match before {
            0 => name.to_string_lossy().into_owned(),
            _ => format!("{stem}-{}{}", before + 1, extension.unwrap_or_default()),
        }
    };
    let photo = |(index, ldi): (usize, &Ldi)| Photo {
        name: unique((index, ldi)),
        camera: ldi.camera,
        pose: ldi.pose,
        file: PathBuf::new(),
        masks: Vec::new(),
    };
    let site =
        Site { photos: ldis.iter().enumerate().map(photo).collect(), model: Arc::new(Model::default()) };
    views(&site, asked, task)
}

/// Draws views of layered depth images, each of the one with the nearest camera.
pub struct LdiDrawing<'a> {
    ldis: &'a [Ldi],
    options: WarpOptions,
    /// The views that were taken from so near that gaps stay open, with the share of depth pixels.
    pub too_near: Vec<(String, f64)>,
}

impl<'a> LdiDrawing<'a> {
    /// Prepares the drawing of images, of which there is at least one.
    pub fn new(ldis: &'a [Ldi], options: WarpOptions) -> Self {
        Self { ldis, options, too_near: Vec::new() }
    }

    /// Draws a view.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`].
    pub fn picture(&mut self, view: &RequestedView, task: &Task) -> Result<Picture> {
        let own = view.photo.and_then(|photo| self.ldis.get(photo.index()));
        let ldi = own.unwrap_or_else(|| nearest(self.ldis, &view.pose));
        let shot = Shot { backs: false, ..Shot::new(view.camera, view.pose) };
        let warped = warp(ldi, &shot, &self.options, task)?;
        let share = warped.too_near as f64 / ldi.levels[warped.level].len().max(1) as f64;
        if share > MOST_TOO_NEAR {
            self.too_near.push((view.name.clone(), share));
        }
        Ok(warped.picture)
    }
}

/// Returns the image whose camera is nearest to a pose; of those at one place the one that looks in the most similar
/// direction.
fn nearest<'a>(ldis: &'a [Ldi], pose: &Pose) -> &'a Ldi {
    let axis = |pose: &Pose| pose.rotation.transpose() * DVec3::Z;
    let distance = |ldi: &Ldi| ldi.pose.center_in_world().distance(pose.center_in_world());
    let turned = |ldi: &Ldi| -axis(&ldi.pose).dot(axis(pose));
    let nearer = |a: &&Ldi, b: &&Ldi| {
        distance(a).total_cmp(&distance(b)).then_with(|| turned(a).total_cmp(&turned(b)))
    };
    ldis.iter().min_by(nearer).expect("there is at least one layered depth image")
}
