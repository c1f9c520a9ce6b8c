//! Plants that stand in a site: where each is, and the light on all.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};

use super::bounds::Ball;
use super::images::PlantImages;
use super::openness::Openness;
use super::plant::Plant;
use super::ratio::RatioImage;
use super::shade::OutdoorLight;
use super::stature::{Stature, level_axes};
use super::sunlit::Sunlit;

/// The trees of a site.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedTrees {
    /// The species.
    pub species: Vec<PlacedSpecies>,
    /// The trees.
    pub trees: Vec<Tree>,
    /// The light on all of them, in the world, in the photos' common exposure.
    pub light: OutdoorLight,
}

/// A species of the trees of a site.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedSpecies {
    /// The plant, with its paint.
    pub plant: Arc<Plant>,
    /// The plant without its paint; `None` where nothing is painted.
    pub unpainted: Option<Arc<Plant>>,
    /// Its images; `None` where all of it is drawn as polygons.
    pub images: Option<Arc<PlantImages>>,
    /// How open the crown is to sun, sky and ground; `None` where all light reaches all of it.
    pub openness: Option<Arc<Openness>>,
}

/// A plant in its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Tree {
    /// Its number among all trees of the site, drawn or not.
    pub number: u32,
    /// Its name.
    pub name: String,
    /// The index of its species.
    pub species: usize,
    /// The map from the plant's frame to the world.
    pub world_from_plant: DAffine3,
    /// The factor on its light, R, G, B.
    pub tint: Vec3,
    /// Whether its shadow darkens faces: no photo shows it there.
    pub casts: bool,
    /// What photos show of it over what is drawn of it.
    pub ratios: Arc<[RatioImage]>,
    /// The share of sunlight that reaches it past everything else; `None` where all does.
    pub sunlit: Option<Arc<Sunlit>>,
}

/// Where and how large a tree is to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placing {
    /// The foot, in the world.
    pub at: DVec3,
    /// What is up in the world, of length 1.
    pub up: DVec3,
    /// The height above the foot in world units; `None` for the plant's own.
    pub height: Option<f64>,
    /// The width of the crown in world units; `None` for that of a plant of this height.
    pub width: Option<f64>,
    /// The turn about what is up in degrees, against the clock as seen from above.
    pub turn: f64,
    /// The length of the plant's unit in world units.
    pub unit: f64,
}

impl Placing {
    /// Returns the map from a plant's frame to the world. The plant stands upright; its height scales all of it, and its width
    /// what is level. A plant without height or width keeps its own size.
    pub fn world_from_plant(&self, plant: &Plant) -> DAffine3 {
        let Stature { foot, height, width } = Stature::of(plant);
        let ratio = |wanted: Option<f64>, own: f64| wanted.filter(|_| own > 0.0).map(|wanted| wanted / own);
        let upwards = ratio(self.height, height).unwrap_or(self.unit);
        let across = ratio(self.width, width).unwrap_or(upwards);
        let (x, y) = level_axes(plant.up);
        let upright_from_plant = DMat3::from_cols(x, y, plant.up).transpose();
        let scale = DMat3::from_diagonal(DVec3::new(across, across, upwards));
        let (x, y) = level_axes(self.up);
        let world_from_upright = DMat3::from_cols(x, y, self.up);
        let turn = DMat3::from_quat(DQuat::from_rotation_z(self.turn.to_radians()));
        let linear = world_from_upright * turn * scale * upright_from_plant;
        DAffine3 { matrix3: linear, translation: self.at - linear * foot }
    }
}

impl PlacedTrees {
    /// Returns the same trees without their paint and without images, which show the paint, too.
    pub fn without_paint(&self) -> Self {
        let bare = |species: &PlacedSpecies| match &species.unpainted {
            Some(plant) => {
                PlacedSpecies { plant: plant.clone(), unpainted: None, images: None, ..species.clone() }
            }
            None => species.clone(),
        };
        Self { species: self.species.iter().map(bare).collect(), ..self.clone() }
    }

    /// Returns a ball around a tree, in the world.
    pub fn ball(&self, tree: &Tree) -> Ball {
        self.species[tree.species].plant.whole().bounds.ball.mapped(&tree.world_from_plant)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::boxed;

    fn placing(up: DVec3) -> Placing {
        Placing { at: DVec3::new(5.0, -7.0, 2.0), up, height: None, width: None, turn: 0.0, unit: 1.0 }
    }

    #[test]
    fn a_tree_stands_on_its_foot_as_high_and_as_wide_as_is_said_whatever_is_up() {
        for (plant_up, world_up) in
            [(DVec3::Z, DVec3::Z), (DVec3::Y, DVec3::Z), (DVec3::Z, -DVec3::Z), (DVec3::Y, DVec3::X)]
        {
            let plant = boxed(DVec3::splat(-0.5), DVec3::splat(3.0), plant_up);
            let place = Placing { height: Some(6.0), width: Some(7.0), turn: 30.0, ..placing(world_up) };
            let map = place.world_from_plant(&plant);
            assert!(map.transform_point3(DVec3::ZERO).abs_diff_eq(place.at, 1e-12));
            let top = map.transform_vector3(3.0 * plant_up);
            assert!(top.abs_diff_eq(6.0 * world_up, 1e-12), "{top}");
            let (across, _) = level_axes(plant_up);
            let across = map.transform_vector3(3.5 * across);
            assert!((across.length() - 7.0).abs() < 1e-12 && across.dot(world_up).abs() < 1e-12);
            assert!(map.matrix3.determinant() > 0.0, "not mirrored");
        }
    }

    #[test]
    fn a_turn_goes_against_the_clock_as_seen_from_above_and_nothing_said_keeps_the_size() {
        let plant = boxed(DVec3::splat(-0.5), DVec3::splat(3.0), DVec3::Z);
        let map = Placing { turn: 90.0, unit: 2.0, ..placing(DVec3::Z) }.world_from_plant(&plant);
        assert!(map.transform_vector3(DVec3::X).abs_diff_eq(2.0 * DVec3::Y, 1e-12));
        assert!(map.transform_vector3(DVec3::Z).abs_diff_eq(2.0 * DVec3::Z, 1e-12));
    }
}
