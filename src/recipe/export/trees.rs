//! The guide of trees: where the trees of a project are in a photo, as far as the model does not hide them. Who paints a layer
//! sees what they will hide of it, and what of the photo they replace.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::compose::HiddenPixels;
use super::guide::{self, HatchPattern};
use crate::document::Trees;
use crate::error::Result;
use crate::foliage::{Tree, Wood};
use crate::geometry::{PixelRect, Spans};
use crate::io::layered::{Depth, Raster};
use crate::recipe::open::Opened;
use crate::recipe::trees::mask::{ModelNearness, tree_pixels};
use crate::recipe::trees::{PlantParts, SiteTrees, site_trees};
use crate::recipe::views::up;
use crate::scene::{Model, Photo};
use crate::task::Task;

/// The stage that is reported for drawing the trees of one photo.
pub const STAGE_TREES: &str = "guide of trees";

/// The trees of a site that a guide shows.
#[derive(Debug, Clone, PartialEq)]
pub struct TreesInSite {
    trees: Trees,
    /// What is up in the world.
    up: DVec3,
    /// The model, which hides parts of them.
    model: Arc<Model>,
    /// The tolerance of inverse depths within which surfaces are one.
    tolerance: f32,
}

impl TreesInSite {
    /// Takes the trees, which may be other ones than those that the project was opened with; `None` where there are none.
    pub fn new(trees: &Trees, opened: &Opened) -> Option<Self> {
        let (up, model) = (up(&opened.site.photos), opened.site.model.clone());
        let tolerance = opened.project.options.tolerance;
        (!trees.placed.is_empty()).then(|| Self { trees: trees.clone(), up, model, tolerance })
    }

    /// Reads or grows the plants of the project in `folder`. Species that cannot be read are noted, and their trees left out.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`].
    pub fn grown(&self, folder: &Path, task: &Task) -> Result<Option<GuidedTrees<'_>>> {
        let made = site_trees(folder, &self.trees, self.up, PlantParts::Geometry, task)?;
        Ok(made.map(|SiteTrees { wood, problems }| {
            problems.into_iter().for_each(|problem| task.note(problem));
            GuidedTrees { wood, model: &self.model, tolerance: self.tolerance }
        }))
    }
}

/// Trees with their plants, and the model that hides parts of them.
#[derive(Debug, Clone)]
pub struct GuidedTrees<'a> {
    wood: Arc<Wood>,
    model: &'a Model,
    tolerance: f32,
}

impl GuidedTrees<'_> {
    /// Draws the guide for a photo; `None` where it shows none of the trees.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`], and [`crate::Error::Request`] for a plant of too many polygons.
    pub fn guide(&self, photo: &Photo, depth: Depth, task: &Task) -> Result<Option<TreeGuide>> {
        let distance = |tree: &Tree| photo.pose.center_in_world().distance(self.wood.ball(tree).middle);
        let mut trees: Vec<&Tree> = self.wood.trees.iter().collect();
        // Near trees are drawn over farther ones.
        trees.sort_by(|a, b| distance(b).total_cmp(&distance(a)).then(a.number.cmp(&b.number)));
        let model = ModelNearness::new(self.model, photo, self.tolerance);
        // Its progress is that of the trees.
        let quiet = Task::silent().with_stop_flag(task.stop_flag());
        let mut parts = Vec::new();
        for (tree, done) in trees.iter().zip(0..) {
            task.step(STAGE_TREES, done, trees.len() as u64)?;
            let shown = tree_pixels((&self.wood, tree), photo, &model, 0, &quiet)?;
            if !shown.is_empty() {
                parts.push((tree.number as usize, shown));
            }
        }
        let Some(rect) = parts.iter().map(|(_, shown)| shown.bounds()).reduce(|a, b| a.union(&b)) else {
            return Ok(None);
        };
        let pattern = HatchPattern::for_photo(photo.camera.width, photo.camera.height);
        let pixels = |shown: &Spans| HiddenPixels::from_fn(shown.bounds(), |(x, y)| shown.holds(x, y));
        let parts = parts.iter().map(|(number, shown)| (*number, pixels(shown)));
        Ok(Some(TreeGuide { rect, pixels: Arc::new(guide::draw(parts, rect, pattern, depth)) }))
    }
}

/// The guide of trees of one photo.
#[derive(Debug, Clone)]
pub struct TreeGuide {
    /// Its rectangle, in photo pixels.
    pub rect: PixelRect,
    /// Its pixels.
    pub pixels: Arc<Raster>,
}

impl TreeGuide {
    /// Returns the hash of its pixels and their position.
    pub fn hash(&self) -> String {
        self.pixels.hash_at(self.rect.x, self.rect.y)
    }
}
