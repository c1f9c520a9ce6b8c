//! The trees of a project, ready to be drawn.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::images::{species_images, species_openness};
use super::paint::{SpeciesPlants, paint_state, species_plants};
use quadratura_base::error::{Error, Message, Result};
use quadratura_base::task::Task;
use quadratura_document::trees::{LightStrength, PlacedTree, PlantSource, TreeLight, TreeSpecies, Trees};
use quadratura_foliage::files::{built_in_plant, read_plant};
use quadratura_foliage::{OutdoorLight, PlacedSpecies, PlacedTrees, Placing, Plant, Tree};
use quadratura_io::project::resolved;

/// The trees of a project.
#[derive(Debug, Clone, PartialEq)]
pub struct SiteTrees {
    /// What is drawn.
    pub placed: Arc<PlacedTrees>,
    /// Why trees are missing: species that cannot be read.
    pub problems: Vec<Message>,
}

/// Reads or grows the species of the trees that are placed, and places these; `None` where there are none. `up` is what is up
/// in the world. A species that cannot be read is a problem and its trees are left out. Light that is to be estimated is that of
/// a clear day.
///
/// # Errors
/// [`Error::Cancelled`].
pub fn site_trees(
    folder: &Path,
    trees: &Trees,
    up: DVec3,
    parts: PlantParts,
    task: &Task,
) -> Result<Option<SiteTrees>> {
    site_trees_with(folder, trees, &mut KnownPlants::default(), up, parts, task)
}

/// What is wanted of plants; each has what the one before has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum PlantParts {
    /// Nothing: trees are not drawn.
    Nothing,
    /// Their geometry.
    Geometry,
    /// How open their crowns are, for light: from the project's cache, or found now and kept there.
    Openness,
    /// The images that are in the project's cache; trees without images are drawn as polygons.
    CachedImages,
    /// Images, which are made and kept in the project's cache where it has none.
    #[default]
    Images,
}

/// Plants that were read or grown before, so that a change of trees reads none of them again.
#[derive(Debug, Clone, Default)]
pub struct KnownPlants(Vec<KnownPlant>);

/// The plant of a species with its paint.
#[derive(Debug, Clone)]
struct KnownPlant {
    name: String,
    species: TreeSpecies,
    /// The state of its paint.
    paint: Vec<String>,
    known: PlacedSpecies,
}

impl KnownPlants {
    /// Returns the species of a name, whose plant is read or grown the first time, and when its paint has changed.
    fn of(&mut self, folder: &Path, name: &str, species: &TreeSpecies, task: &Task) -> Result<PlacedSpecies> {
        let paint = paint_state(folder, name);
        let is_same = |of: &&KnownPlant| of.name == name && of.species == *species && of.paint == paint;
        if let Some(of) = self.0.iter().find(is_same) {
            return Ok(of.known.clone());
        }
        let SpeciesPlants { plant, unpainted } = species_plants(folder, name, species, task)?;
        let (plant, unpainted) = (Arc::new(plant), unpainted.map(Arc::new));
        let known = PlacedSpecies { plant, unpainted, images: None, openness: None };
        // What a species was before is of no use any more.
        self.0.retain(|of| of.name != name);
        let (name, species, of) = (name.to_owned(), species.clone(), known.clone());
        self.0.push(KnownPlant { name, species, paint, known: of });
        Ok(known)
    }

    /// Adds what is wanted to the plants of species whose trees stand somewhere. What cannot be read or made is noted, and trees are
    /// drawn without it.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    fn want(&mut self, folder: &Path, trees: &Trees, parts: PlantParts, task: &Task) -> Result<()> {
        let is_placed = |of: &KnownPlant| {
            trees.species.get(&of.name) == Some(&of.species)
                && trees.placed.iter().any(|tree| tree.species == of.name)
        };
        for KnownPlant { known, .. } in self.0.iter_mut().filter(|of| is_placed(of)) {
            if parts >= PlantParts::Openness && known.openness.is_none() {
                known.openness = found(species_openness(folder, &known.plant, task), task)?.map(Arc::new);
            }
            if parts >= PlantParts::CachedImages && known.images.is_none() {
                let images = species_images(folder, &known.plant, parts, task);
                known.images = images?.map(|(images, _)| Arc::new(images));
            }
        }
        Ok(())
    }
}

/// Returns what was found; what went wrong is noted, unless the work was cancelled.
fn found<T>(found: Result<T>, task: &Task) -> Result<Option<T>> {
    match found {
        Err(Error::Cancelled) => Err(Error::Cancelled),
        Err(error) => {
            task.note(error.message());
            Ok(None)
        }
        Ok(found) => Ok(Some(found)),
    }
}

/// [`site_trees`] with plants that are known already; those that were not are known afterwards.
///
/// # Errors
/// [`Error::Cancelled`].
pub fn site_trees_with(
    folder: &Path,
    trees: &Trees,
    plants: &mut KnownPlants,
    up: DVec3,
    parts: PlantParts,
    task: &Task,
) -> Result<Option<SiteTrees>> {
    if trees.placed.is_empty() {
        return Ok(None);
    }
    let placed: BTreeSet<&String> = trees.placed.iter().map(|tree| &tree.species).collect();
    for (name, species) in trees.species.iter().filter(|(name, _)| placed.contains(name)) {
        // What is wrong with a plant is a problem below, and what is wrong with its paint a note.
        if let Err(Error::Cancelled) = plants.of(folder, name, species, task) {
            return Err(Error::Cancelled);
        }
    }
    plants.want(folder, trees, parts, task)?;
    let mut known = BTreeMap::new();
    let (mut species, mut placed, mut problems) = (Vec::new(), Vec::new(), Vec::new());
    for (number, tree) in trees.placed.iter().enumerate() {
        if !known.contains_key(&tree.species) {
            let index = match plant_of_species(folder, trees, &tree.species, plants, task) {
                Ok(known) => {
                    species.push(known);
                    Some(species.len() - 1)
                }
                Err(Error::Cancelled) => return Err(Error::Cancelled),
                Err(error) => {
                    let what = format!("trees of the species {:?} are not shown: ", tree.species);
                    problems.push(Message::from(what).and(error.message()));
                    None
                }
            };
            known.insert(&tree.species, index);
        }
        let Some(index) = known[&tree.species] else { continue };
        let plant = &species[index].plant;
        let unit = trees.species[&tree.species].unit.unwrap_or(plant.unit);
        placed.push(Tree {
            number: number as u32,
            name: tree.name.clone(),
            species: index,
            world_from_plant: placing(tree, up, unit).world_from_plant(plant),
            tint: Vec3::from_array(tree.tint.map(|stops| stops.exp2() as f32)),
            casts: tree.casts,
            ratios: Arc::default(),
            sunlit: None,
        });
    }
    let placed = Arc::new(PlacedTrees { species, trees: placed, light: light(&trees.light, up) });
    Ok(Some(SiteTrees { placed, problems }))
}

fn plant_of_species(
    folder: &Path,
    trees: &Trees,
    name: &str,
    plants: &mut KnownPlants,
    task: &Task,
) -> Result<PlacedSpecies> {
    let species = trees.species.get(name).ok_or_else(|| {
        let found = format!("a tree is of the species {name:?}, which the project does not have");
        Error::input(folder, "trees", found, "add the species, or remove the tree")
    })?;
    plants.of(folder, name, species, task)
}

/// Reads or grows the plant of a species, without its paint.
///
/// # Errors
/// Those of [`read_plant`].
pub fn plant_of(folder: &Path, species: &TreeSpecies, task: &Task) -> Result<Plant> {
    let mut plant = match &species.from {
        PlantSource::File(file) => read_plant(&resolved(folder, file), None, task)?,
        PlantSource::Maple(grown) => built_in_plant("maple", grown.seed)?,
        PlantSource::Oak(grown) => built_in_plant("oak", grown.seed)?,
    };
    if let Some(up) = species.up {
        plant.up = DVec3::from_array(up.direction());
    }
    Ok(plant)
}

fn placing(tree: &PlacedTree, up: DVec3, unit: f64) -> Placing {
    let PlacedTree { at, height, width, turn, .. } = tree;
    Placing { at: DVec3::from_array(*at), up, height: *height, width: *width, turn: *turn, unit }
}

/// Returns the light on the trees of a site: what is given, and a clear day for the rest.
fn light(said: &TreeLight, up: DVec3) -> OutdoorLight {
    let mut light = OutdoorLight::day(up);
    if let Some(sun) = said.sun {
        light.towards_sun = DVec3::from_array(sun).normalize();
    }
    if let Some(strength) = said.strength.given() {
        shine(&mut light, strength);
    }
    light
}

/// Makes a light as bright as is said.
pub fn shine(light: &mut OutdoorLight, LightStrength { sun, sky, ground }: &LightStrength) {
    let linear = |light: &[f64; 3]| DVec3::from_array(*light).as_vec3();
    (light.sun, light.sky, light.ground) = (linear(sun), linear(sky), linear(ground));
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_document::trees::Grown;

    fn trees() -> Trees {
        let species = |from| TreeSpecies { from, up: None, unit: None };
        let tree = |name: &str, species: &str, x: f64| PlacedTree {
            name: name.into(),
            species: species.into(),
            at: [x, 0.0, 0.0],
            height: Some(7.0),
            width: None,
            turn: 0.0,
            tint: [1.0, 0.0, -1.0],
            replaces: Default::default(),
            casts: name == "c",
        };
        Trees {
            species: [
                ("maple".to_owned(), species(PlantSource::Maple(Grown::default()))),
                ("lost".to_owned(), species(PlantSource::File("no-such.glb".into()))),
            ]
            .into(),
            placed: vec![tree("a", "maple", 1.0), tree("b", "lost", 2.0), tree("c", "maple", 3.0)],
            light: TreeLight { sun: Some([0.0, 0.0, 4.0]), ..TreeLight::default() },
        }
    }

    #[test]
    fn trees_of_a_species_that_cannot_be_read_are_a_problem_and_the_others_stand() {
        let SiteTrees { placed, problems } =
            site_trees(Path::new("."), &trees(), DVec3::Z, PlantParts::Geometry, &Task::silent())
                .unwrap()
                .unwrap();
        let names: Vec<&str> = placed.trees.iter().map(|tree| &tree.name[..]).collect();
        assert_eq!((names, placed.species.len(), problems.len()), (vec!["a", "c"], 1, 1));
        assert_eq!(placed.trees[1].number, 2, "numbers are those of the project");
        assert!(problems[0].to_string().contains("lost"), "{}", problems[0]);
        assert_eq!(placed.light.towards_sun, DVec3::Z);
        assert_eq!(placed.trees[0].tint, Vec3::new(2.0, 1.0, 0.5));
        assert_eq!(placed.trees.iter().map(|tree| tree.casts).collect::<Vec<_>>(), [false, true]);
        // As high as is said, on its foot.
        let ball = placed.ball(&placed.trees[1]);
        assert!((ball.middle - DVec3::new(3.0, 0.0, 3.5)).length() < 2.0, "{ball:?}");
    }

    #[test]
    fn a_plant_that_is_known_is_not_grown_again() {
        let (trees, mut known) = (trees(), KnownPlants::default());
        let mut made = || {
            let made = site_trees_with(
                Path::new("."),
                &trees,
                &mut known,
                DVec3::Z,
                PlantParts::Geometry,
                &Task::silent(),
            );
            made.unwrap().unwrap().placed
        };
        let (first, second) = (made(), made());
        assert!(Arc::ptr_eq(&first.species[0].plant, &second.species[0].plant));
    }

    #[test]
    fn a_project_without_trees_has_none() {
        assert_eq!(
            site_trees(Path::new("."), &Trees::default(), DVec3::Z, PlantParts::Geometry, &Task::silent())
                .unwrap(),
            None
        );
    }
}
