//! Views of layered depth images, without a project.

use std::path::PathBuf;
use std::sync::Arc;

use super::stereo::{COMFORTABLE, eyes, near_depth, side_by_side};
use quadratura_base::error::Result;
use quadratura_base::geometry::Pose;
use quadratura_base::scene::{Model, Photo, Site};
use quadratura_base::task::Task;
use quadratura_ldi::cube::{FACE, axis};
use quadratura_ldi::{Arrangement, Ldi, LdiSet, Shown, WarpOptions, warp_set, warp_shown};
use quadratura_sites::views::{RequestedView, RequestedViews, ViewRequest, views};
use quadratura_view::{Picture, Quality, Shot};

/// The share of depth pixels from which on a picture is noted as taken from too near.
const MOST_TOO_NEAR: f64 = 0.01;

/// Returns the requested views: cameras of files, camera paths, and the images' own cameras, which stand for the photos of a
/// project; [`RequestedView::photo`] is then the index of the image among those of all sets.
///
/// # Errors
/// Returns the errors of [`views`].
pub fn views_of(sets: &[LdiSet], asked: &ViewRequest, task: &Task) -> Result<RequestedViews> {
    let mut photos: Vec<Photo> = Vec::new();
    for set in sets {
        for (index, ldi) in set.images.iter().enumerate() {
            let (camera, pose) = (ldi.own_camera(), ldi.pose);
            let name = unused(&name_of(set.arrangement, ldi, index), &photos);
            photos.push(Photo {
                name,
                camera,
                pose,
                file: PathBuf::new(),
                masks: Vec::new(),
                exposure: None,
            });
        }
    }
    views(&Site { photos, model: Arc::new(Model::default()) }, asked, task)
}

/// Returns the name of an image of a file: that of the photo, or of the face of a cube.
pub fn name_of(arrangement: Arrangement, ldi: &Ldi, index: usize) -> String {
    match arrangement {
        Arrangement::Cube => ldi.report.options.get(FACE).cloned().unwrap_or_else(|| format!("face-{index}")),
        _ => ldi.sources.first().cloned().unwrap_or_else(|| "view".to_owned()),
    }
}

/// Returns a name, or NAME-2 and so on where others have it: images of one photo give pictures of different names.
fn unused(name: &str, others: &[Photo]) -> String {
    let path = PathBuf::from(name);
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let extension =
        path.extension().map_or(String::new(), |extension| format!(".{}", extension.to_string_lossy()));
    let numbered = (2u32..).map(|number| format!("{stem}-{number}{extension}"));
    let mut names = std::iter::once(name.to_owned()).chain(numbered);
    names.find(|name| others.iter().all(|other| other.name != *name)).expect("numbers do not end")
}

/// Draws views of layered depth images, each of the file with the nearest camera.
pub struct LdiDrawing<'a> {
    sets: &'a [LdiSet],
    options: WarpOptions,
    quality: Quality,
    /// The distance between the eyes in world units, for pictures of two views side by side.
    stereo: Option<f64>,
    /// What is shown instead of colours.
    shown: Option<Shown>,
    /// The views that were taken from so near that gaps stay open, with the share of depth pixels.
    pub too_near: Vec<(String, f64)>,
    /// The views that are too near for the distance between the eyes, with the depth of what is near, in world units.
    pub uncomfortable: Vec<(String, f64)>,
}

impl<'a> LdiDrawing<'a> {
    /// Prepares the drawing of images, of which there is at least one, in a quality: for one eye or two, and of their colours or of
    /// another quantity.
    pub fn new(
        sets: &'a [LdiSet],
        options: WarpOptions,
        quality: Quality,
        stereo: Option<f64>,
        shown: Option<Shown>,
    ) -> Self {
        Self { sets, options, quality, stereo, shown, too_near: Vec::new(), uncomfortable: Vec::new() }
    }

    /// Draws a view; for two eyes the left one's to the left of the right one's.
    ///
    /// # Errors
    /// Those of [`warp_set`].
    pub fn picture(&mut self, view: &RequestedView, task: &Task) -> Result<Picture> {
        let set = self.set_of(view);
        let Some(distance) = self.stereo else { return self.one(set, view, view.pose, task) };
        let near = near_depth(set, &Shot::new(view.camera, view.pose));
        if let Some(near) = near.filter(|near| distance > COMFORTABLE * near) {
            self.uncomfortable.push((view.name.clone(), near));
        }
        let [left, right] = eyes(&view.pose, distance);
        let left = self.one(set, view, left, task)?;
        let right = self.one(set, view, right, task)?;
        Ok(side_by_side(&left, &right))
    }

    fn one(&mut self, set: &LdiSet, view: &RequestedView, pose: Pose, task: &Task) -> Result<Picture> {
        let shot = Shot { backs: false, quality: self.quality, ..Shot::new(view.camera, pose) };
        let warped = match self.shown {
            Some(shown) => warp_shown(set, &shot, shown, &self.options, task)?,
            None => warp_set(set, &shot, &self.options, task)?,
        };
        let share = warped.too_near as f64 / warped.depth_pixels.max(1) as f64;
        let is_noted = self.too_near.last().is_some_and(|(name, _)| *name == view.name);
        if share > MOST_TOO_NEAR && !is_noted {
            self.too_near.push((view.name.clone(), share));
        }
        Ok(warped.picture)
    }

    /// Returns the set whose own camera a view has, else the one with the nearest camera.
    fn set_of(&self, view: &RequestedView) -> &'a LdiSet {
        let all = self.sets.iter().flat_map(|set| set.images.iter().map(move |image| (set, image)));
        let own = view.photo.and_then(|photo| all.clone().nth(photo.index()));
        let nearest = || all.min_by(|a, b| nearer(&view.pose, a.1, b.1));
        own.or_else(nearest).expect("there is at least one layered depth image").0
    }
}

/// Compares how near the cameras of two images are to a pose; of those at one place the one that looks in the more similar
/// direction is nearer.
fn nearer(pose: &Pose, a: &Ldi, b: &Ldi) -> std::cmp::Ordering {
    let distance = |ldi: &Ldi| ldi.pose.center_in_world().distance(pose.center_in_world());
    let turned = |ldi: &Ldi| -axis(&ldi.pose).dot(axis(pose));
    distance(a).total_cmp(&distance(b)).then_with(|| turned(a).total_cmp(&turned(b)))
}
