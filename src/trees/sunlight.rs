//! What keeps the sun from the trees of a site: the model, and other trees.

use std::sync::{Arc, Mutex, PoisonError};

use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use quadratura_base::error::Result;
use quadratura_base::scene::Model;
use quadratura_base::scene::builder::says_backdrop;
use quadratura_base::task::Task;
use quadratura_files::hash::hash_bytes;
use quadratura_foliage::directions::{Serving, serving};
use quadratura_foliage::{Openness, PlacedTrees, Sunlit, Tree};
use quadratura_projection::model_surface::ModelSurface;

/// The faces of a model that keep the sun away: not those of backdrops, nor what one sees through. What was found of trees is kept
/// for the next time, when most of them are where they were.
#[derive(Debug)]
pub struct SunBlockers {
    surface: ModelSurface,
    known: Mutex<FxHashMap<String, CachedSunlight>>,
}

impl SunBlockers {
    /// Prepares the faces of a model.
    pub fn new(model: &Model) -> Self {
        let solid = model
            .without(|object| says_backdrop(&object.name) || object.shows_what_is_behind())
            .without_see_through();
        Self { surface: ModelSurface::from_model(&solid), known: Mutex::default() }
    }

    /// Finds the share of sunlight that reaches the trees, past the model and past each other. A sun below the horizon is in nobody's
    /// way.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Cancelled`].
    pub fn shade(&self, placed: &mut PlacedTrees, task: &Task) -> Result<()> {
        self.shade_by(placed, &|_| true, task)
    }

    /// [`Self::shade`] where only some trees shade others.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Cancelled`].
    pub fn shade_by(
        &self,
        placed: &mut PlacedTrees,
        shades: &(dyn Fn(&Tree) -> bool + Sync),
        task: &Task,
    ) -> Result<()> {
        let towards_sun = placed.light.towards_sun;
        if towards_sun.dot(placed.light.up) <= 0.0 {
            placed.trees.iter_mut().for_each(|tree| tree.sunlit = None);
            return Ok(());
        }
        let crowns: Vec<Option<Crown>> = placed.trees.iter().map(|tree| Crown::new(placed, tree)).collect();
        let known = std::mem::take(&mut *self.known.lock().unwrap_or_else(PoisonError::into_inner));
        let sunlit = |(number, crown): (usize, &Option<Crown>)| {
            task.check_cancelled()?;
            let Some(crown) = crown else { return Ok(None) };
            let others = crowns.iter().zip(&placed.trees).enumerate();
            let others = others.filter(|(other, (_, tree))| *other != number && shades(tree));
            let others = others.filter_map(|(_, (other, _))| other.as_ref());
            let others: Vec<&Crown> = others.filter(|other| other.may_shade(crown, towards_sun)).collect();
            let key = key(crown, &others, towards_sun);
            let found = || self.sunlit(crown, &others, towards_sun);
            let sunlit = known.get(&key).map_or_else(found, |known| known.sunlit.clone());
            Ok(Some((key, CachedSunlight { sunlit, _openness: crown.openness.clone() })))
        };
        let found: Result<Vec<_>> = crowns.par_iter().enumerate().map(sunlit).collect();
        let found = found?;
        for (tree, found) in placed.trees.iter_mut().zip(&found) {
            tree.sunlit = found.as_ref().and_then(|(_, found)| found.sunlit.clone());
        }
        *self.known.lock().unwrap_or_else(PoisonError::into_inner) = found.into_iter().flatten().collect();
        Ok(())
    }

    /// Finds the share of sunlight that reaches a crown past the model and past others.
    fn sunlit(&self, crown: &Crown, others: &[&Crown], towards_sun: DVec3) -> Option<Arc<Sunlit>> {
        // The ground below a foot, and a wall that a branch goes into, hide nothing of it.
        let start = crown.radius / 8.0;
        let share = |point: DVec3| {
            let point = crown.world_from_plant.transform_point3(point);
            if self.surface.nearest(point + start * towards_sun, towards_sun).is_some() {
                return 0.0;
            }
            others.iter().map(|other| other.lets_through(point)).product()
        };
        Sunlit::new(crown.openness.space(), share).map(Arc::new)
    }
}

/// What was found of a tree. Its openness is kept with it, so that no other one gets its address, by which it is known.
#[derive(Debug, Clone)]
struct CachedSunlight {
    sunlit: Option<Arc<Sunlit>>,
    _openness: Arc<Openness>,
}

/// Returns a hash of all that decides about the light on a crown.
fn key(crown: &Crown, others: &[&Crown], towards_sun: DVec3) -> String {
    let mut bytes: Vec<u8> = towards_sun.to_array().into_iter().flat_map(f64::to_le_bytes).collect();
    for crown in std::iter::once(crown).chain(others.iter().copied()) {
        // A species that is read again has another openness.
        bytes.extend((Arc::as_ptr(&crown.openness) as usize).to_le_bytes());
        bytes.extend(crown.world_from_plant.to_cols_array().into_iter().flat_map(f64::to_le_bytes));
    }
    hash_bytes(&bytes)
}

/// The crown of a tree in the world.
struct Crown {
    openness: Arc<Openness>,
    /// The direction to the sun in the plant's frame, of any length, and the directions of the openness around it.
    towards_sun: DVec3,
    serving: Vec<Serving>,
    world_from_plant: DAffine3,
    plant_from_world: DAffine3,
    middle: DVec3,
    radius: f64,
}

impl Crown {
    /// Returns the crown of a tree; `None` where its openness is not known.
    fn new(placed: &PlacedTrees, tree: &Tree) -> Option<Self> {
        let openness = placed.species[tree.species].openness.clone()?;
        let ball = placed.ball(tree);
        let (world_from_plant, plant_from_world) = (tree.world_from_plant, tree.world_from_plant.inverse());
        let towards_sun = plant_from_world.transform_vector3(placed.light.towards_sun);
        Some(Self {
            openness,
            towards_sun,
            serving: serving(towards_sun),
            world_from_plant,
            plant_from_world,
            middle: ball.middle,
            radius: ball.radius,
        })
    }

    /// Returns whether a part of it may be between a part of another one and the sun.
    fn may_shade(&self, other: &Self, towards_sun: DVec3) -> bool {
        let apart = self.middle - other.middle;
        let along = apart.dot(towards_sun);
        let reach = self.radius + other.radius;
        along > -reach && (apart - along * towards_sun).length_squared() < reach * reach
    }

    /// Returns the share of sunlight that it lets through to a point of the world: what is open towards the sun where the ray comes
    /// into the space of its openness.
    fn lets_through(&self, point: DVec3) -> f32 {
        let point = self.plant_from_world.transform_point3(point);
        let space = self.openness.space();
        // A ray along a side has infinite quotients, and none on the side itself, which counts as outside.
        let (low, high) = ((space.low - point) / self.towards_sun, (space.high - point) / self.towards_sun);
        let enters = low.min(high).to_array().into_iter().fold(0.0, f64::max);
        let leaves = low.max(high).to_array().into_iter().fold(f64::INFINITY, f64::min);
        match enters < leaves {
            true => self.openness.towards_served(point + enters * self.towards_sun, &self.serving),
            false => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use quadratura_base::scene::synthetic::Modeller;
    use quadratura_foliage::directions::DIRECTIONS;
    use quadratura_foliage::synthetic::boxed;
    use quadratura_foliage::{OutdoorLight, PlacedSpecies};

    /// A species of 2 x 2 x 4 of which a share of all light comes in from outside.
    fn species(open: u8) -> PlacedSpecies {
        let plant = Arc::new(boxed(DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 4.0), DVec3::Z));
        let low = DVec3::new(-1.0, -1.0, 0.0);
        let openness =
            Openness::of(low, 2.0, [1, 1, 2], vec![[127, 0, 0, 0]; 2], vec![[open; DIRECTIONS]; 2]);
        PlacedSpecies { plant, unpainted: None, images: None, openness: Some(Arc::new(openness.unwrap())) }
    }

    fn tree(at: DVec3, species: usize) -> Tree {
        Tree {
            number: 0,
            name: "tree".into(),
            species,
            world_from_plant: DAffine3::from_translation(at),
            tint: Vec3::ONE,
            casts: true,
            ratios: Arc::default(),
            sunlit: None,
        }
    }

    /// The sun is in the direction of +x, 45 degrees high.
    fn placed(trees: Vec<Tree>) -> PlacedTrees {
        let towards_sun = DVec3::new(1.0, 0.0, 1.0).normalize();
        let light = OutdoorLight { towards_sun, ..OutdoorLight::day(DVec3::Z) };
        PlacedTrees { species: vec![species(51), species(255)], trees, light }
    }

    fn at(tree: &Tree, point: DVec3) -> f32 {
        tree.sunlit.as_ref().map_or(1.0, |sunlit| sunlit.at(point))
    }

    #[test]
    fn a_wall_shades_a_tree_up_to_where_the_sun_comes_over_it_and_backdrops_billboards_and_the_ground_do_not()
    {
        let mut model = Modeller::new();
        model.object("ground").quad(DVec3::new(-50.0, -50.0, 0.1), 100.0 * DVec3::X, 100.0 * DVec3::Y);
        for (name, x) in [("sky.backdrop", 30.0), ("tree.billboard", 3.0)] {
            model.object(name).quad(DVec3::new(x, 40.0, 0.0), -80.0 * DVec3::Y, 80.0 * DVec3::Z);
        }
        let mut lit = placed(vec![tree(DVec3::ZERO, 0)]);
        let model = Arc::unwrap_or_clone(model.finish());
        SunBlockers::new(&model.with_see_through(|object| object.name.contains("billboard")))
            .shade(&mut lit, &Task::silent())
            .unwrap();
        assert_eq!(lit.trees[0].sunlit, None);
        let mut model = Modeller::new();
        model.object("wall").quad(DVec3::new(4.0, 40.0, 0.0), -80.0 * DVec3::Y, 6.0 * DVec3::Z);
        let mut shaded = placed(vec![tree(DVec3::ZERO, 0)]);
        SunBlockers::new(&model.finish()).shade(&mut shaded, &Task::silent()).unwrap();
        let tree = &shaded.trees[0];
        // At x the sun comes over the wall from a height of 2 + x on; cells are 0.25 and 0.5 wide.
        for (x, z, expected) in [(0.0, 1.2, 0.0), (0.0, 2.8, 1.0), (-0.9, 1.7, 1.0), (0.9, 2.4, 0.0)] {
            let found = at(tree, DVec3::new(x, 0.0, z));
            assert!((found - expected).abs() < 1e-6, "{found} at {x}, {z}");
        }
    }

    #[test]
    fn trees_shade_each_other_by_what_their_crowns_let_through() {
        // The second and the third one towards the sun, the fourth one away from it; the third is bare.
        let along = |distance: f64| tree(DVec3::new(distance, 0.0, distance - 2.0), 0);
        let bare = Tree { species: 1, ..along(8.0) };
        let mut placed =
            placed(vec![along(2.0), along(6.0), bare, along(-4.0), tree(DVec3::new(2.0, 9.0, 0.0), 0)]);
        let blockers = SunBlockers::new(&Model::default());
        blockers.shade(&mut placed, &Task::silent()).unwrap();
        let middle = DVec3::new(0.0, 0.0, 2.0);
        let found: Vec<f32> = placed.trees.iter().map(|tree| at(tree, middle)).collect();
        // A fifth comes through each.
        let expected = [0.2, 1.0, 1.0, 0.04, 1.0];
        let off = found.iter().zip(expected).map(|(found, expected)| (found - expected).abs());
        // Shares are bytes: openness 51 of 255, and what is kept of the product.
        assert!(off.fold(0.0, f32::max) <= 0.5 / 255.0 + 1e-6, "{found:?}");
        // What was found is the same the next time, and one that is moved away shades nothing any more.
        let before = placed.clone();
        blockers.shade(&mut placed, &Task::silent()).unwrap();
        let same = |(a, b): (&Tree, &Tree)| match (&a.sunlit, &b.sunlit) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        assert!(before.trees.iter().zip(&placed.trees).all(same));
        placed.trees[1].world_from_plant.translation.y += 50.0;
        blockers.shade(&mut placed, &Task::silent()).unwrap();
        assert_eq!(at(&placed.trees[0], middle), 1.0);
        // Trees that shade none, such as planned ones where the light of photos is found.
        blockers.shade_by(&mut placed, &|_| false, &Task::silent()).unwrap();
        assert!(placed.trees.iter().all(|tree| tree.sunlit.is_none()));
    }
}
