//! The guide of trees: where the trees of a project are in a photo, as far as the model does not hide them. Someone
//! who paints a layer sees what they will hide of it, and what of the photo they replace.

use std::path::Path;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::compose::HiddenPixels;
use super::guide::{self, HatchPattern};
use quadratura_base::error::Result;
use quadratura_base::geometry::{PixelRect, Spans};
use quadratura_base::scene::up;
use quadratura_base::scene::{Model, Photo, Site};
use quadratura_base::task::Task;
use quadratura_document::{Project, Trees};
use quadratura_foliage::{Ball, PlacedTrees, Tree, balls};
use quadratura_layered_files::{Depth, Raster};
use quadratura_trees::mask::ModelNearness;
use quadratura_trees::{PlantParts, SiteTrees, site_trees};

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
    pub fn new(trees: &Trees, project: &Project, site: &Site) -> Option<Self> {
        let (up, model) = (up(&site.photos), site.model.clone());
        let tolerance = project.options.tolerance;
        (!trees.placed.is_empty()).then(|| Self { trees: trees.clone(), up, model, tolerance })
    }

    /// Reads or grows the plants of the project in `folder`. Species that cannot be read are noted, and their trees left out.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Cancelled`].
    pub fn grown(&self, folder: &Path, task: &Task) -> Result<Option<GuidedTrees<'_>>> {
        let made = site_trees(folder, &self.trees, self.up, PlantParts::Geometry, task)?;
        Ok(made.map(|SiteTrees { placed, problems }| {
            problems.into_iter().for_each(|problem| task.note(problem));
            let balls = placed.species.par_iter().map(|species| balls(&species.plant)).collect();
            GuidedTrees { placed, balls, model: &self.model, tolerance: self.tolerance }
        }))
    }
}

/// Trees with their plants, and the model that hides parts of them.
#[derive(Debug, Clone)]
pub struct GuidedTrees<'a> {
    placed: Arc<PlacedTrees>,
    /// The balls that cover the plants, by species.
    balls: Vec<Vec<Ball>>,
    model: &'a Model,
    tolerance: f32,
}

impl GuidedTrees<'_> {
    /// Draws the guide for a photo; `None` where it shows none of the trees.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Cancelled`].
    pub fn guide(&self, photo: &Photo, depth: Depth, task: &Task) -> Result<Option<TreeGuide>> {
        let distance = |tree: &Tree| photo.pose.center_in_world().distance(self.placed.ball(tree).middle);
        let in_frame = |tree: &&Tree| !rect_of(&self.placed.ball(tree), photo).is_empty();
        let mut trees: Vec<&Tree> = self.placed.trees.iter().filter(in_frame).collect();
        if trees.is_empty() {
            return Ok(None);
        }
        // Near trees are drawn over farther ones.
        trees.sort_by(|a, b| distance(b).total_cmp(&distance(a)).then(a.number.cmp(&b.number)));
        let model = ModelNearness::new(self.model, photo, self.tolerance);
        let shown = |tree: &&Tree| -> Result<(usize, Spans)> {
            task.check_cancelled()?;
            Ok((tree.number as usize, self.shown(tree, photo, &model)))
        };
        let mut parts: Vec<(usize, Spans)> = trees.par_iter().map(shown).collect::<Result<_>>()?;
        parts.retain(|(_, shown)| !shown.is_empty());
        let Some(rect) = parts.iter().map(|(_, shown)| shown.bounds()).reduce(|a, b| a.union(&b)) else {
            return Ok(None);
        };
        let pattern = HatchPattern::for_photo(photo.camera.width, photo.camera.height);
        let pixels = |shown: &Spans| HiddenPixels::from_fn(shown.bounds(), |(x, y)| shown.holds(x, y));
        let parts = parts.iter().map(|(number, shown)| (*number, pixels(shown)));
        Ok(Some(TreeGuide { rect, pixels: Arc::new(guide::draw(parts, rect, pattern, depth)) }))
    }

    /// Returns the pixels at which a photo shows the balls of a tree before the model.
    fn shown(&self, tree: &Tree, photo: &Photo, model: &ModelNearness) -> Spans {
        let rect = rect_of(&self.placed.ball(tree), photo);
        let mut shown = HiddenPixels::filled(rect, false);
        let nearness = model.inverse_depths();
        for ball in &self.balls[tree.species] {
            let ball = ball.mapped(&tree.world_from_plant);
            let Some((middle, radius_px, inverse_depth)) = disc_of(&ball, photo) else { continue };
            // At least the pixel in which its middle lies.
            let radius_px = radius_px.max(0.71);
            let around = rect_around(middle, radius_px).intersection(&rect);
            for (x, y) in around.pixels() {
                let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let index = y as usize * photo.camera.width as usize + x as usize;
                let is_before = inverse_depth as f32 > nearness[index];
                if is_before && centre.distance_squared(middle) <= radius_px * radius_px {
                    shown.put(x, y, true);
                }
            }
        }
        Spans::of_pixels(rect, |x, y| shown.holds(x, y))
    }
}

/// Returns where a ball lies in a photo: its middle and its radius in pixels, and its inverse depth along the camera's axis; `None`
/// where it reaches behind the camera.
fn disc_of(ball: &Ball, photo: &Photo) -> Option<(DVec2, f64, f64)> {
    let in_camera = photo.pose.camera_from_world(ball.middle);
    let middle = photo.camera.image_from_camera(in_camera).filter(|_| in_camera.z > ball.radius)?;
    Some((middle, photo.camera.fx.max(photo.camera.fy) * ball.radius / in_camera.z, in_camera.z.recip()))
}

/// Returns the pixels of a photo around a ball: all of them where it reaches behind the camera but not only.
fn rect_of(ball: &Ball, photo: &Photo) -> PixelRect {
    let whole = photo.camera.rect();
    let z = photo.pose.camera_from_world(ball.middle).z;
    match disc_of(ball, photo) {
        // The outline of a ball that is near, seen from the side, is up to so much farther from its middle.
        Some((middle, radius_px, _)) => {
            let side = 2.0 * radius_px / (1.0 - (ball.radius / z).powi(2)).max(0.01);
            rect_around(middle, side).intersection(&whole)
        }
        None if z > -ball.radius => whole,
        None => PixelRect { w: 0, h: 0, ..whole },
    }
}

/// Returns the pixels of a square around a point; sides beyond any photo are cut off.
fn rect_around(middle: DVec2, half_px: f64) -> PixelRect {
    let held = |value: f64| value.clamp(-1e6, 1e6).floor() as i32;
    let (x, y) = (held(middle.x - half_px), held(middle.y - half_px));
    let [w, h] = [held(middle.x + half_px) - x, held(middle.y + half_px) - y].map(|side| side as u32 + 1);
    PixelRect { x, y, w, h }
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
