//! What keeps the sun from the trees of a site: the model, and other trees.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use rayon::prelude::*;

use crate::foliage::{BoundingBox, Openness, Sunlit, Tree, Wood};
use crate::projection::surface::Surface;
use crate::scene::Model;
use crate::scene::builder::says_backdrop;

/// The faces of a model that keep the sun away: not those of backdrops, nor what one sees through.
#[derive(Debug)]
pub struct SunBlockers(Surface);

impl SunBlockers {
    /// Prepares the faces of a model.
    pub fn new(model: &Model) -> Self {
        let solid = model
            .without(|object| says_backdrop(&object.name) || object.shows_what_is_behind())
            .without_see_through();
        Self(Surface::from_model(&solid))
    }

    /// Finds what sun reaches the trees, past the model and past each other.
    pub fn shade(&self, wood: &mut Wood) {
        let crowns: Vec<Option<Crown>> = wood.trees.iter().map(|tree| Crown::new(wood, tree)).collect();
        let towards_sun = wood.light.towards_sun;
        let sunlit = |(number, crown): (usize, &Option<Crown>)| {
            let crown = crown.as_ref()?;
            let others: Vec<&Crown> = crowns
                .iter()
                .enumerate()
                .filter(|(other, _)| *other != number)
                .filter_map(|(_, other)| other.as_ref())
                .filter(|other| other.may_shade(crown, towards_sun))
                .collect();
            // The ground below a foot, and a wall that a branch goes into, hide nothing of it.
            let start = crown.radius / 8.0;
            Sunlit::new(crown.space, |point| {
                let point = crown.world_from_plant.transform_point3(point);
                if self.0.nearest(point + start * towards_sun, towards_sun).is_some() {
                    return 0.0;
                }
                others.iter().map(|other| other.lets_through(point, towards_sun)).product()
            })
            .map(Arc::new)
        };
        let found: Vec<Option<Arc<Sunlit>>> = crowns.par_iter().enumerate().map(sunlit).collect();
        for (tree, found) in wood.trees.iter_mut().zip(found) {
            tree.sunlit = found;
        }
    }
}

/// The crown of a tree in the world.
struct Crown {
    /// The space in which its openness is known, in the plant's frame.
    space: BoundingBox,
    openness: Arc<Openness>,
    world_from_plant: DAffine3,
    plant_from_world: DAffine3,
    middle: DVec3,
    radius: f64,
}

impl Crown {
    /// Returns the crown of a tree; `None` where its openness is not known.
    fn new(wood: &Wood, tree: &Tree) -> Option<Self> {
        let openness = wood.species[tree.species].openness.clone()?;
        let ball = wood.ball(tree);
        let world_from_plant = tree.world_from_plant;
        Some(Self {
            space: openness.space(),
            openness,
            world_from_plant,
            plant_from_world: world_from_plant.inverse(),
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

    /// Returns the share of the sun's light that it lets through to a point of the world: what is open there where the ray towards
    /// the sun comes into it.
    fn lets_through(&self, point: DVec3, towards_sun: DVec3) -> f32 {
        let point = self.plant_from_world.transform_point3(point);
        let direction = self.plant_from_world.transform_vector3(towards_sun);
        let (low, high) = ((self.space.low - point) / direction, (self.space.high - point) / direction);
        // Where the ray is parallel to a side, the quotients are infinite, or not a number on the side itself, which min and max leave out.
        let enters = low.min(high).to_array().into_iter().fold(0.0, f64::max);
        let leaves = low.max(high).to_array().into_iter().fold(f64::INFINITY, f64::min);
        match enters < leaves {
            true => self.openness.towards(point + enters * direction, direction),
            false => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::foliage::directions::DIRECTIONS;
    use crate::foliage::tests::boxed;
    use crate::foliage::{Light, WoodSpecies};
    use crate::scene::synthetic::Modeller;

    /// A species of 2 x 2 x 4 of which a share of all light comes in from outside.
    fn species(open: u8) -> WoodSpecies {
        let plant = Arc::new(boxed(DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 4.0), DVec3::Z));
        let low = DVec3::new(-1.0, -1.0, 0.0);
        let openness =
            Openness::of((low, 2.0, [1, 1, 2]), vec![[127, 0, 0, 0]; 2], vec![[open; DIRECTIONS]; 2]);
        WoodSpecies { plant, unpainted: None, images: None, openness: Some(Arc::new(openness.unwrap())) }
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
    fn wood(trees: Vec<Tree>) -> Wood {
        let towards_sun = DVec3::new(1.0, 0.0, 1.0).normalize();
        let light = Light { towards_sun, ..Light::day(DVec3::Z) };
        Wood { species: vec![species(51), species(255)], trees, light }
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
        let mut lit = wood(vec![tree(DVec3::ZERO, 0)]);
        let model = Arc::unwrap_or_clone(model.finish());
        SunBlockers::new(&model.with_see_through(|object| object.name.contains("billboard"))).shade(&mut lit);
        assert_eq!(lit.trees[0].sunlit, None);
        let mut model = Modeller::new();
        model.object("wall").quad(DVec3::new(4.0, 40.0, 0.0), -80.0 * DVec3::Y, 6.0 * DVec3::Z);
        let mut shaded = wood(vec![tree(DVec3::ZERO, 0)]);
        SunBlockers::new(&model.finish()).shade(&mut shaded);
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
        let mut wood =
            wood(vec![along(2.0), along(6.0), bare, along(-4.0), tree(DVec3::new(2.0, 9.0, 0.0), 0)]);
        SunBlockers::new(&Model::default()).shade(&mut wood);
        let middle = DVec3::new(0.0, 0.0, 2.0);
        let found: Vec<f32> = wood.trees.iter().map(|tree| at(tree, middle)).collect();
        // A fifth comes through each.
        let expected = [0.2, 1.0, 1.0, 0.04, 1.0];
        let off = found.iter().zip(expected).map(|(found, expected)| (found - expected).abs());
        assert!(off.fold(0.0, f32::max) < 0.005, "{found:?}");
    }
}
