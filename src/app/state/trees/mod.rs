//! The trees of the project in the window: selection by name, eyes, the tool that places them, and what species cost.

pub mod figures;
pub mod hand;
pub mod images;
pub mod light;
mod queries;
pub mod request;

use std::collections::BTreeSet;
use std::sync::Arc;

use self::figures::KnownFigures;
use self::hand::TreeHand;
use self::images::MadeImages;
use self::light::KnownLight;
use quadratura_document::Project;
use quadratura_document::trees::{PlacedTree, Trees};
use quadratura_trees::light::{LightEstimate, is_needed};
use quadratura_trees::list::SpeciesFigures;

/// The trees in the window.
#[derive(Default)]
pub struct TreesState {
    /// The name of the selected tree: other trees may come before it, and its index changes.
    selected: Option<String>,
    /// The names of trees whose eye is closed.
    pub hidden: BTreeSet<String>,
    /// What the painter of the 3D view shows.
    pub sent: Option<ShownTrees>,
    /// What the next painter will show, while it is being made.
    pub prepared: Option<ShownTrees>,
    /// The tool that places and drags trees.
    pub hand: TreeHand,
    /// What species cost, and how large their plants are.
    pub figures: KnownFigures,
    /// Which species have images.
    pub images: MadeImages,
    /// How often files of plants have changed on disk.
    pub plants_version: u64,
    /// The light that is estimated from the photos.
    pub light: KnownLight,
}

impl TreesState {
    /// Returns what the plant of a species costs and how large it is, where that is known.
    pub fn figures_of(&self, trees: &Trees, species: &str) -> Option<&SpeciesFigures> {
        self.figures.of(trees.species.get(species)?)?.as_ref().ok()
    }

    /// Returns the height and the width of one of these trees in world units; `None` until its plant is known.
    pub fn size_of(&self, trees: &Trees, tree: &PlacedTree) -> Option<[f64; 2]> {
        let figures = self.figures_of(trees, &tree.species);
        let height = tree.height.or(figures.map(|figures| figures.height))?;
        let slender = figures.map_or(0.7, |figures| figures.width / figures.height);
        Some([height, tree.width.unwrap_or(slender * height)])
    }

    /// Forgets what is known of plants, because files of them have changed.
    pub fn files_changed(&mut self) {
        self.plants_version += 1;
        self.figures.forget();
        self.light.forget();
        self.images.forget();
    }
}

/// The trees that the 3D view shows: those of a project, without hidden ones.
#[derive(Debug, Clone)]
pub struct ShownTrees {
    /// The project.
    pub project: Arc<Project>,
    /// The names of trees that are hidden.
    pub hidden: BTreeSet<String>,
    /// The estimated light, where it is known.
    pub estimate: Option<Arc<LightEstimate>>,
    /// For how many species images were made.
    pub images: usize,
    /// How often files of plants had changed on disk.
    pub plants_version: u64,
}

impl ShownTrees {
    /// Returns whether a picture of others looks the same.
    pub fn looks_like(&self, other: &Self) -> bool {
        let same = Arc::ptr_eq(&self.project, &other.project) || self.project.trees == other.project.trees;
        let same_light = match (&self.estimate, &other.estimate) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        same && self.hidden == other.hidden
            && self.images == other.images
            && self.plants_version == other.plants_version
            && (same_light || !(is_needed(&self.project) || is_needed(&other.project)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_document::trees::{Grown, PlantSource, TreeSpecies};

    #[test]
    fn trees_are_shown_again_when_files_of_plants_have_changed() {
        let mut trees = TreesState::default();
        let shown = |trees: &TreesState| ShownTrees {
            project: Arc::new(Project::default()),
            hidden: BTreeSet::new(),
            estimate: trees.light.estimate(),
            images: trees.images.count(),
            plants_version: trees.plants_version,
        };
        trees.figures.add(vec![(maple(), Err("unknown".into()))]);
        let before = shown(&trees);
        assert!(before.looks_like(&shown(&trees)) && trees.figures.of(&maple()).is_some());
        trees.files_changed();
        assert!(!before.looks_like(&shown(&trees)) && trees.figures.of(&maple()).is_none());
    }

    fn maple() -> TreeSpecies {
        TreeSpecies { from: PlantSource::Maple(Grown::default()), up: None, unit: None }
    }
}
