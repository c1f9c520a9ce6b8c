//! How high and how wide a plant is, measured at its corners.

use glam::{DAffine3, DMat3, DVec3};

use super::mesh::Mesh;
use super::plant::{Plant, Use};

/// The size of a plant above its foot, in its own frame and unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stature {
    /// The point on which it stands.
    pub foot: DVec3,
    /// Its height above the foot.
    pub height: f64,
    /// Its width: the larger one of its two extents along the level axes of [`level_axes`].
    pub width: f64,
}

/// The share of a plant's height up to which the origin of its frame may lie above its lowest point and be its foot: roots
/// and the lowest part of a trunk are below the ground.
const ROOTS: f64 = 0.25;

/// Returns two level directions that make a right-handed frame with what is up: x and y of a plant whose up is z.
pub fn level_axes(up: DVec3) -> (DVec3, DVec3) {
    let x = (DVec3::X - DVec3::X.dot(up) * up).try_normalize().unwrap_or(DVec3::Y);
    (x, up.cross(x))
}

impl Stature {
    /// Measures a plant along what is up and two level axes. Its foot is the origin of its frame where that is within the
    /// plant and near its lower end, as modellers place it; else the middle of the lower end.
    pub fn of(plant: &Plant) -> Self {
        if plant.whole().bounds.space.is_empty() {
            return Self { foot: DVec3::ZERO, height: 0.0, width: 0.0 };
        }
        let meshes: Vec<Vec<Mesh>> = plant.objects.iter().map(Mesh::of).collect();
        let (x, y) = level_axes(plant.up);
        let upright_from_plant = DMat3::from_cols(x, y, plant.up).transpose();
        let farthest =
            |direction| FarthestCorner { plant, meshes: &meshes, direction, found: f64::NEG_INFINITY }.find();
        let high = DVec3::from_array([x, y, plant.up].map(farthest));
        let low = DVec3::from_array([x, y, plant.up].map(|axis| -farthest(-axis)));
        let size = high - low;
        let is_foot =
            low.cmple(DVec3::ZERO).all() && high.cmpge(DVec3::ZERO).all() && -low.z <= ROOTS * size.z;
        let foot = if is_foot { DVec3::ZERO } else { DVec3::new(0.5, 0.5, 0.0) * size + low };
        Self {
            foot: upright_from_plant.transpose() * foot,
            height: high.z - foot.z,
            width: size.x.max(size.y),
        }
    }
}

/// A search for the corner of all instances that is farthest in a direction. Instances whose box cannot hold it are skipped, so
/// that few of them are visited, however many there are.
struct FarthestCorner<'a> {
    plant: &'a Plant,
    meshes: &'a [Vec<Mesh>],
    direction: DVec3,
    found: f64,
}

impl FarthestCorner<'_> {
    fn find(mut self) -> f64 {
        self.visit(self.plant.root, &DAffine3::IDENTITY);
        self.found
    }

    /// Returns what no corner of an instance is beyond.
    fn bound(&self, object: usize, plant_from_object: &DAffine3) -> f64 {
        let space = self.plant.objects[object].bounds.space;
        if space.is_empty() {
            return f64::NEG_INFINITY;
        }
        let (middle, half) = (0.5 * (space.low + space.high), 0.5 * (space.high - space.low));
        let across = (plant_from_object.matrix3.transpose() * self.direction).abs();
        plant_from_object.transform_point3(middle).dot(self.direction) + half.dot(across)
    }

    fn visit(&mut self, object: usize, plant_from_object: &DAffine3) {
        for corner in self.meshes[object].iter().flat_map(|mesh| &mesh.corners) {
            let reached = plant_from_object.transform_point3(corner.position).dot(self.direction);
            self.found = self.found.max(reached);
        }
        let child = |of: &Use| {
            let map = *plant_from_object * of.parent_from_child;
            (self.bound(of.child, &map), of.child, map)
        };
        let mut children: Vec<(f64, usize, DAffine3)> =
            self.plant.objects[object].uses.iter().map(child).collect();
        // Those that may reach farthest first, after which most others cannot reach farther.
        children.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (bound, child, map) in children {
            if bound <= self.found {
                break;
            }
            self.visit(child, &map);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::boxed;
    use crate::{Species, grow};

    #[test]
    fn the_foot_is_the_origin_near_the_lower_end_and_else_the_middle_of_the_lower_end() {
        let of = |low: [f64; 3], high: [f64; 3], up| Stature::of(&boxed(low.into(), high.into(), up));
        let rooted = of([-1.0, -2.0, -0.5], [2.0, 2.0, 6.0], DVec3::Z);
        assert_eq!(rooted, Stature { foot: DVec3::ZERO, height: 6.0, width: 4.0 });
        let apart = of([10.0, 10.0, 1.0], [12.0, 14.0, 6.0], DVec3::Z);
        assert_eq!(apart, Stature { foot: DVec3::new(11.0, 12.0, 1.0), height: 5.0, width: 4.0 });
        let of_gltf = of([-1.0, -0.2, -1.0], [1.0, 7.0, 1.0], DVec3::Y);
        assert_eq!(of_gltf, Stature { foot: DVec3::ZERO, height: 7.0, width: 2.0 });
    }

    #[test]
    fn the_farthest_corner_is_that_of_all_instances() {
        let species: Species = serde_json::from_str(include_str!("../../examples/oak.json")).unwrap();
        let plant = grow(&species).unwrap();
        let meshes: Vec<Vec<Mesh>> = plant.objects.iter().map(Mesh::of).collect();
        // Every corner of every instance.
        fn all(plant: &Plant, meshes: &[Vec<Mesh>], object: usize, map: &DAffine3, d: DVec3) -> f64 {
            let corners = meshes[object].iter().flat_map(|mesh| &mesh.corners);
            let own = corners.map(|corner| map.transform_point3(corner.position).dot(d));
            let uses = plant.objects[object].uses.iter();
            let of_uses = uses.map(|of| all(plant, meshes, of.child, &(*map * of.parent_from_child), d));
            own.chain(of_uses).fold(f64::NEG_INFINITY, f64::max)
        }
        for direction in [DVec3::Z, DVec3::NEG_X, DVec3::new(0.6, 0.8, 0.0)] {
            let search =
                FarthestCorner { plant: &plant, meshes: &meshes, direction, found: f64::NEG_INFINITY };
            assert_eq!(search.find(), all(&plant, &meshes, plant.root, &DAffine3::IDENTITY, direction));
        }
    }
}
