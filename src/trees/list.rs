//! The species and trees of a project, as they are listed.

use std::path::Path;

use glam::DVec3;
use serde::Serialize;

use super::images::has_images;
use super::mask::{TreeInMasks, masks_of};
use super::paint::{ListedPaint, listed_paint, species_plant};
use quadratura_base::error::Result;
use quadratura_base::geometry::polygon::extent;
use quadratura_base::scene::Model;
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_document::trees::{PlacedTree, PlantSource, TreeSpecies, Trees};
use quadratura_foliage::{Counts, Stature};
use quadratura_projection::model_surface::ModelSurface;

/// A species as it is listed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ListedSpecies {
    /// The name.
    pub species: String,
    /// Where the plant is from: a file, or `maple` or `oak`.
    pub from: String,
    /// The number of trees of it.
    pub trees: usize,
    /// The counts of the plant; `None` where it cannot be read.
    pub counts: Option<Counts>,
    /// The plant's own height in world units; `None` likewise.
    pub height: Option<f64>,
    /// Whether images of the plant are in the project's cache.
    pub has_images: bool,
    /// The paint of the species; `None` where it has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paint: Option<ListedPaint>,
    /// Why the plant cannot be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub problem: Option<String>,
}

/// A tree as it is listed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ListedTree {
    /// What the project says of it.
    #[serde(flatten)]
    pub tree: PlacedTree,
    /// The number of photos in which it is masked.
    pub masks: usize,
    /// Whether any of these masks was made before the tree was moved, or changed in size or species.
    pub masks_outdated: bool,
}

/// What a species costs and how large its plant is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeciesFigures {
    /// The counts of the plant.
    pub counts: Counts,
    /// Whether images of it are in the project's cache.
    pub has_images: bool,
    /// The plant's own height in world units.
    pub height: f64,
    /// The width of its crown at this height, in world units.
    pub width: f64,
}

/// Reads or grows the plant of the species of a name, and measures it.
///
/// # Errors
/// Those of [`species_plant`].
pub fn species_figures(
    folder: &Path,
    name: &str,
    species: &TreeSpecies,
    task: &Task,
) -> Result<SpeciesFigures> {
    let plant = species_plant(folder, name, species, task)?;
    let (unit, stature) = (species.unit.unwrap_or(plant.unit), Stature::of(&plant));
    let [height, width] = [stature.height, stature.width].map(|length| unit * length);
    let has_images = has_images(folder, &plant);
    Ok(SpeciesFigures { counts: plant.whole().counts, has_images, height, width })
}

/// Lists the species. A plant that cannot be read is listed with the reason.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub fn listed_species(folder: &Path, trees: &Trees, task: &Task) -> Result<Vec<ListedSpecies>> {
    // Where the book cannot be read, reading the plants notes it.
    let paint = listed_paint(folder).unwrap_or_default();
    let listed = |(name, species): (&String, &TreeSpecies)| {
        let figures = match species_figures(folder, name, species, task) {
            Err(quadratura_base::Error::Cancelled) => return Err(quadratura_base::Error::Cancelled),
            figures => figures,
        };
        Ok(ListedSpecies {
            species: name.clone(),
            from: match &species.from {
                PlantSource::File(file) => file.clone(),
                PlantSource::Maple(_) => "maple".into(),
                PlantSource::Oak(_) => "oak".into(),
            },
            trees: trees.placed.iter().filter(|tree| tree.species == *name).count(),
            counts: figures.as_ref().ok().map(|figures| figures.counts),
            height: figures.as_ref().ok().map(|figures| figures.height),
            has_images: figures.as_ref().is_ok_and(|figures| figures.has_images),
            paint: paint.get(name).copied(),
            problem: figures.err().map(|error| error.to_string()),
        })
    };
    trees.species.iter().map(listed).collect()
}

/// Lists the trees in the order of the project.
pub fn listed_trees(project: &Project) -> Vec<ListedTree> {
    let listed = |tree: &PlacedTree| {
        let TreeInMasks { photos: masks, outdated: masks_outdated } = masks_of(project, tree);
        ListedTree { tree: tree.clone(), masks, masks_outdated }
    };
    project.trees.placed.iter().map(listed).collect()
}

/// Returns why trees of species are not shown, in words.
pub fn species_problems(species: &[ListedSpecies]) -> Vec<String> {
    let problem = |of: &ListedSpecies| {
        let problem = of.problem.as_ref()?;
        Some(format!("trees of the species {:?} are not shown: {problem}", of.species))
    };
    species.iter().filter_map(problem).collect()
}

/// Returns the names of the trees whose masks are out of date.
pub fn outdated_masks(project: &Project) -> Vec<&str> {
    let is_outdated = |tree: &&PlacedTree| masks_of(project, tree).outdated;
    project.trees.placed.iter().filter(is_outdated).map(|tree| &tree.name[..]).collect()
}

/// The share of a tree's height by which its foot may be above or below the model without a remark.
const AFLOAT: f64 = 0.02;
/// How near the feet of two trees are that stand in one place, as a share of the lower one's height.
const SAME_PLACE: f64 = 0.01;
/// How many times as large as the model's diagonal a tree may be without a remark. Trees may tower over a model of one wall, but more than
/// that is a mistake of units.
const TOO_LARGE: f64 = 4.0;
/// The height that stands for that of trees whose height is not said, in world units.
const USUAL_HEIGHT: f64 = 8.0;

/// Returns what is doubtful about where trees stand, in words: feet above or below the model, trees far away from it, and trees in one place. `model`
/// is what they stand on, `up` what is up in the world.
pub fn doubts(trees: &Trees, model: &Model, up: DVec3) -> Vec<String> {
    let surface = ModelSurface::from_model(model);
    let size = extent(&model.vertices);
    let low = model.vertices.iter().copied().reduce(DVec3::min).unwrap_or_default();
    let high = model.vertices.iter().copied().reduce(DVec3::max).unwrap_or_default();
    let mut doubts = Vec::new();
    for (number, tree) in trees.placed.iter().enumerate() {
        let (at, height) = (DVec3::from_array(tree.at), tree.height.unwrap_or(USUAL_HEIGHT));
        let above = above_ground(&surface, at, up, height);
        if let Some(above) = above.filter(|above| above.abs() > AFLOAT * height) {
            let (far, side) = (above.abs(), if above > 0.0 { "above" } else { "below" });
            doubts.push(format!("the foot of the tree {:?} is {far:.2} {side} the model", tree.name));
        }
        let away = (at - at.clamp(low, high)).length();
        if above.is_none() && away > size && size > 0.0 {
            doubts.push(format!("the tree {:?} is {away:.0} away from the model", tree.name));
        }
        for (length, how) in [(tree.height, "high"), (tree.width, "wide")] {
            if let Some(length) = length.filter(|length| *length > TOO_LARGE * size && size > 0.0) {
                let times = length / size;
                doubts.push(format!(
                    "the tree {:?} is {length} {how}, {times:.0} times the size of the model; both are in units of the world",
                    tree.name
                ));
            }
        }
        let other = trees.placed[..number].iter().find(|other| {
            let least = height.min(other.height.unwrap_or(USUAL_HEIGHT));
            DVec3::from_array(other.at).distance(at) < SAME_PLACE * least
        });
        if let Some(other) = other {
            doubts.push(format!("the trees {:?} and {:?} stand in one place", other.name, tree.name));
        }
    }
    doubts
}

/// Returns how far a foot is above the nearest surface on the vertical line through it; `None` where there is none. A surface
/// above the tree's top is none: it is a roof, or what else is over ground that is not modelled.
fn above_ground(surface: &ModelSurface, at: DVec3, up: DVec3, height: f64) -> Option<f64> {
    // From a little beyond the foot, so that a surface right at it is met from both sides.
    let start = AFLOAT * height;
    let below = surface.nearest(at + start * up, -up).map(|hit| hit.t - start);
    let above =
        surface.nearest(at - start * up, up).map(|hit| start - hit.t).filter(|above| *above >= -height);
    [below, above].into_iter().flatten().min_by(|a, b| a.abs().total_cmp(&b.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edit::{TreeChange, placed};
    use quadratura_base::scene::synthetic::Modeller;

    #[test]
    fn feet_in_the_air_and_trees_in_one_place_are_told_and_others_are_not() {
        let mut model = Modeller::new();
        model.object("ground").quad(DVec3::new(-50.0, -50.0, 2.0), 100.0 * DVec3::X, 100.0 * DVec3::Y);
        let model = model.finish();
        let with = |trees: &Trees, at: [f64; 3]| {
            let change = TreeChange { at: Some(at), height: Some(6.0), ..TreeChange::default() };
            placed(trees, "oak", None, &change).unwrap().0
        };
        let told = |trees: &Trees| doubts(trees, &model, DVec3::Z);
        let trees = with(&Trees::default(), [0.0, 0.0, 2.05]);
        assert!(told(&trees).is_empty(), "within 2 % of its height");
        let trees = with(&with(&with(&trees, [5.0, 0.0, 3.0]), [9.0, 0.0, 1.0]), [9.0, 0.0, 1.01]);
        let doubts = told(&trees);
        assert_eq!(doubts.len(), 4, "{doubts:?}");
        assert!(doubts[0].contains("oak_2") && doubts[0].contains("1.00 above"), "{}", doubts[0]);
        assert!(doubts[1].contains("oak_3") && doubts[1].contains("1.00 below"), "{}", doubts[1]);
        assert!(doubts[3].contains("oak_3") && doubts[3].contains("oak_4"), "{}", doubts[3]);
        assert!(
            told(&with(&trees, [80.0, 0.0, 0.0])).len() == 4,
            "where the model has no ground, nothing is told"
        );
        // A foot in the air is told however high it is, a surface above the top is a roof, and what is beside the model is told from as
        // far away as the model is large.
        let tells = |at: [f64; 3]| told(&with(&Trees::default(), at)).join(" ");
        assert!(tells([0.0, 0.0, 300.0]).contains("298.00 above"), "{}", tells([0.0, 0.0, 300.0]));
        assert_eq!(tells([0.0, 0.0, -9.0]), "");
        let mut roofed = Modeller::new();
        roofed.object("ground").quad(DVec3::new(-50.0, -50.0, 2.0), 100.0 * DVec3::X, 100.0 * DVec3::Y);
        roofed.object("roof").quad(DVec3::new(-50.0, -50.0, 12.0), 100.0 * DVec3::X, 100.0 * DVec3::Y);
        let under_roof = super::doubts(&with(&Trees::default(), [0.0, 0.0, 5.5]), &roofed.finish(), DVec3::Z);
        assert!(under_roof.len() == 1 && under_roof[0].contains("3.50 above"), "{under_roof:?}");
        assert_eq!(tells([190.0, 0.0, 0.0]), "");
        assert!(
            tells([1000.0, 0.0, 0.0]).contains("950 away from the model"),
            "{}",
            tells([1000.0, 0.0, 0.0])
        );
        let mut high = with(&Trees::default(), [0.0, 0.0, 2.0]);
        high.placed[0].height = Some(1e9);
        assert!(told(&high)[0].contains("7071068 times the size of the model"), "{:?}", told(&high));
    }
}
