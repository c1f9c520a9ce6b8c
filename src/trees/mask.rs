//! Where photos show the real trees: each tree is drawn into each photo, without what the model hides of it.

use std::sync::Arc;

use quadratura_base::error::Result;
use quadratura_base::geometry::Spans;
use quadratura_base::scene::impostor::Facing;
use quadratura_base::scene::{Model, Photo, Site};
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_document::masks::{MaskOrigin, MaskedTree};
use quadratura_document::trees::PlacedTree;
use quadratura_files::hash::hash_bytes;
use quadratura_foliage::{PlacedTrees, Tree, View, silhouette};
use quadratura_layers::ProjectedModel;
use quadratura_layers::software::owners;
use quadratura_sites::masks::MaskEdit;

/// How near the model is at the pixels of a photo.
pub struct ModelNearness {
    /// Inverse depths along the camera's axis, in 1/world unit, row by row; 0 where nothing solid is.
    inverse_depths: Vec<f32>,
}

impl ModelNearness {
    /// Finds how near the solid surfaces of a model are in a photo; impostors turn towards it. Surfaces within `tolerance` of
    /// the nearest one count as one.
    pub fn new(model: &Model, photo: &Photo, tolerance: f32) -> Self {
        let model = Arc::new(model.without_see_through()).facing(&Facing::of_pose(&photo.pose));
        let view = ProjectedModel::new(&model, &photo.camera, &photo.pose);
        let width = photo.camera.width as usize;
        let nearness = |(pixel, owner): (usize, &u32)| match owner.checked_sub(1) {
            Some(item) => {
                let (x, y) = (pixel % width, pixel / width);
                view.items[item as usize].inverse_depth.at(x as u32, y as u32)
            }
            None => 0.0,
        };
        Self { inverse_depths: owners(&view, tolerance).iter().enumerate().map(nearness).collect() }
    }

    /// Returns the inverse depths along the camera's axis, row by row; 0 where nothing solid is.
    pub fn inverse_depths(&self) -> &[f32] {
        &self.inverse_depths
    }
}

/// Returns the pixels at which a photo shows a tree, as far as nothing solid hides it, grown by `margin` pixels (rows and
/// columns).
///
/// # Errors
/// Those of [`silhouette`].
pub fn tree_pixels(
    placed: &PlacedTrees,
    tree: &Tree,
    photo: &Photo,
    model: &ModelNearness,
    margin: u32,
    task: &Task,
) -> Result<Spans> {
    let plant = &placed.species[tree.species].plant;
    let view = View::of_tree(photo.camera, &photo.pose, &tree.world_from_plant, &plant.whole().bounds.ball);
    let covered = silhouette(plant, &view, &model.inverse_depths, task)?;
    let (whole, width) = (photo.camera.rect(), photo.camera.width as usize);
    let shown = Spans::of_pixels(whole, |x, y| covered[y as usize * width + x as usize]);
    Ok(shown.grown(margin as i32).intersection(&Spans::of_pixels(whole, |_, _| true)))
}

/// Returns the masks of trees of some names in photos: where each shows what stands in the tree's place, with a margin in photo
/// pixels.
///
/// # Errors
/// Those of [`silhouette`].
pub fn tree_masks(
    project: &Project,
    site: &Site,
    photos: &[&Photo],
    placed: &PlacedTrees,
    names: &[String],
    margin: u32,
    task: &Task,
) -> Result<Vec<MaskEdit>> {
    let tolerance = project.options.tolerance;
    let mut edits = Vec::new();
    for (photo, done) in photos.iter().zip(0..) {
        task.step("mask trees", done, photos.len() as u64)?;
        let model = ModelNearness::new(&site.model, photo, tolerance);
        for tree in placed.trees.iter().filter(|tree| names.contains(&tree.name)) {
            // Its progress is that of the photos.
            let quiet = Task::silent().with_stop_flag(task.stop_flag());
            let masked = tree_pixels(placed, tree, photo, &model, margin, &quiet)?;
            let placed = project.trees.placed.iter().find(|placed| placed.name == tree.name);
            let placing = placed.map(|placed| placing(project, placed));
            let from = MaskOrigin::Tree(MaskedTree { name: tree.name.clone(), margin, placing });
            edits.push(MaskEdit::Put { photo: photo.name.clone(), from, masked });
        }
    }
    Ok(edits)
}

/// In how many photos a tree is masked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TreeInMasks {
    /// The number of photos.
    pub photos: usize,
    /// Whether any of these masks was made before the tree was moved, or changed in size or species.
    pub outdated: bool,
}

/// Returns in how many photos a tree of a project is masked.
pub fn masks_of(project: &Project, tree: &PlacedTree) -> TreeInMasks {
    let now = placing(project, tree);
    let mut found = TreeInMasks::default();
    for (_, masks) in project.masks.photos() {
        let its = masks.iter().filter_map(|mask| match &mask.from {
            MaskOrigin::Tree(masked) if masked.name == tree.name => Some(masked),
            _ => None,
        });
        let mut its = its.peekable();
        found.photos += usize::from(its.peek().is_some());
        found.outdated |= its.any(|masked| masked.placing.as_ref().is_some_and(|then| *then != now));
    }
    found
}

/// Returns a hash of what decides which pixels of photos show a tree: the definition of its species, place, size and turn.
fn placing(project: &Project, tree: &PlacedTree) -> String {
    let PlacedTree { species, at, height, width, turn, .. } = tree;
    let of_tree = (project.trees.species.get(species), species, at, height, width, turn.rem_euclid(360.0));
    hash_bytes(&serde_json::to_vec(&of_tree).expect("plain data is JSON"))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use glam::DVec3;

    use super::*;
    use crate::edit::{TreeChange, placed};
    use crate::{PlantParts, site_trees};
    use quadratura_base::scene::synthetic::{Modeller, Scene, Truth, centred, look_at};
    use quadratura_document::trees::Trees;

    /// A tree 6 high before the camera, half of it behind a wall.
    fn scene() -> (Scene, PlacedTrees) {
        let mut model = Modeller::new();
        model.object("wall").quad(DVec3::new(-9.0, -4.0, -1.0), 9.0 * DVec3::X, 20.0 * DVec3::Z);
        let scene = Scene {
            name: "tree".into(),
            model: model.finish(),
            camera: centred(120, 90, 90.0),
            pose: look_at(DVec3::new(0.0, -12.0, 3.0), DVec3::new(0.0, 0.0, 3.0)),
            truth: Truth::Unknown,
        };
        let change = TreeChange { at: Some([0.0; 3]), height: Some(6.0), ..TreeChange::default() };
        let (trees, _) = placed(&Trees::default(), "maple", None, &change).unwrap();
        let trees = site_trees(Path::new("."), &trees, DVec3::Z, PlantParts::Geometry, &Task::silent())
            .unwrap()
            .unwrap();
        (scene, (*trees.placed).clone())
    }

    #[test]
    fn what_a_photo_shows_of_a_tree_is_masked_with_its_margin_and_what_is_hidden_is_not() {
        let (scene, placed) = scene();
        let photo = scene.photo();
        let of = |model: &Model, margin| {
            let nearness = ModelNearness::new(model, &photo, 1e-4);
            tree_pixels(&placed, &placed.trees[0], &photo, &nearness, margin, &Task::silent()).unwrap()
        };
        let (alone, beside) = (of(&Model::default(), 0), of(&scene.model, 0));
        // As high as 6 of 12 units are in the picture, give or take the nearer part of the crown.
        let rows: Vec<i32> = (0..90).filter(|&y| (0..120).any(|x| alone.holds(x, y))).collect();
        assert!((43..=60).contains(&rows.len()), "{} rows", rows.len());
        assert!(beside.minus(&alone).is_empty());
        let (left, right) = ((0..90), (0..90));
        let left =
            left.flat_map(|y| (0..60).map(move |x| (x, y))).filter(|&(x, y)| beside.holds(x, y)).count();
        let right = right
            .flat_map(|y| (60..120).map(move |x| (x, y)))
            .filter(|&(x, y)| beside.holds(x, y) != alone.holds(x, y))
            .count();
        assert_eq!([left, right], [0, 0], "the wall hides the left half and nothing else");
        let wide = of(&scene.model, 3);
        assert!(beside.minus(&wide).is_empty() && wide.count() > beside.count());
    }
}
