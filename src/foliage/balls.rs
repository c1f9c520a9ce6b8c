//! A plant as balls, coarse enough that hundreds of trees are found in a photo at once: for guides, not for pictures.

use glam::{DAffine3, DVec3};
use rustc_hash::FxHashMap;

use super::bounds::Ball;
use super::mesh::Mesh;
use super::plant::Plant;

/// The radius of the largest balls, as a share of that of the whole plant.
const LARGEST: f64 = 1.0 / 48.0;
/// A plant has at most so many balls; they are larger where it would have more.
const MOST_BALLS: usize = 1 << 18;

/// Returns balls in the plant's frame that together cover it: sub-objects that are small enough, and pieces of the triangles of
/// larger ones.
pub fn balls(plant: &Plant) -> Vec<Ball> {
    let whole = plant.whole().bounds.ball;
    if !(whole.radius.is_finite() && whole.radius > 0.0) {
        return Vec::new();
    }
    let mut largest = LARGEST * whole.radius;
    loop {
        let mut cover = Cover { plant, largest, meshes: FxHashMap::default(), balls: Vec::new() };
        cover.visit(plant.root, &DAffine3::IDENTITY);
        if cover.balls.len() < MOST_BALLS {
            return cover.balls;
        }
        largest *= 2.0;
    }
}

struct Cover<'a> {
    plant: &'a Plant,
    largest: f64,
    /// The meshes of the sub-objects that were met.
    meshes: FxHashMap<usize, Vec<Mesh>>,
    balls: Vec<Ball>,
}

impl Cover<'_> {
    fn visit(&mut self, object: usize, plant_from_object: &DAffine3) {
        let of_plant = &self.plant.objects[object];
        let ball = of_plant.bounds.ball.mapped(plant_from_object);
        // There is nothing in an empty sub-object.
        if !(ball.radius.is_finite() && ball.radius >= 0.0) || self.balls.len() >= MOST_BALLS {
            return;
        }
        if ball.radius <= self.largest {
            self.balls.push(ball);
            return;
        }
        let meshes = self.meshes.remove(&object).unwrap_or_else(|| Mesh::of(of_plant));
        for mesh in &meshes {
            for triangle in &mesh.triangles {
                let corner = |at: u32| plant_from_object.transform_point3(mesh.corners[at as usize].position);
                self.cover(triangle.map(corner));
            }
        }
        self.meshes.insert(object, meshes);
        for child in &of_plant.uses {
            self.visit(child.child, &(*plant_from_object * child.parent_from_child));
        }
    }

    /// Covers a triangle, which is halved along its longest side until a ball is small enough.
    fn cover(&mut self, corners: [DVec3; 3]) {
        let middle = corners.iter().sum::<DVec3>() / 3.0;
        let radius = corners.iter().map(|corner| corner.distance(middle)).fold(0.0, f64::max);
        if self.balls.len() >= MOST_BALLS || !radius.is_finite() {
            return;
        }
        if radius <= self.largest {
            self.balls.push(Ball { middle, radius });
            return;
        }
        let [a, b, c] = corners;
        let sides = [(a, b, c), (b, c, a), (c, a, b)];
        let length = |(from, to, _): &(DVec3, DVec3, DVec3)| from.distance_squared(*to);
        let longest = sides.into_iter().max_by(|one, other| length(one).total_cmp(&length(other)));
        let (from, to, apex) = longest.expect("a triangle has three sides");
        let half = 0.5 * (from + to);
        self.cover([from, half, apex]);
        self.cover([half, to, apex]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foliage::tests::{boxed, bushy};

    #[test]
    fn balls_cover_a_plant_and_are_small_and_few() {
        for plant in [boxed(DVec3::ZERO, DVec3::new(2.0, 3.0, 4.0), DVec3::Z), bushy()] {
            let whole = plant.whole().bounds.ball;
            let found = balls(&plant);
            assert!(found.len() > 100 && found.len() < MOST_BALLS, "{}", found.len());
            assert!(found.iter().all(|ball| ball.radius <= LARGEST * whole.radius));
            let meshes: Vec<Vec<Mesh>> = plant.objects.iter().map(Mesh::of).collect();
            let mut corners = Vec::new();
            let mut visit = vec![(plant.root, DAffine3::IDENTITY)];
            while let Some((object, map)) = visit.pop() {
                let own = meshes[object].iter().flat_map(|mesh| &mesh.corners);
                corners.extend(own.map(|corner| map.transform_point3(corner.position)));
                let uses = plant.objects[object].uses.iter();
                visit.extend(uses.map(|child| (child.child, map * child.parent_from_child)));
            }
            // All corners of a small plant, some of a large one.
            for corner in corners.iter().step_by(1 + corners.len() / 500) {
                let is_in = |ball: &Ball| ball.middle.distance(*corner) <= ball.radius + 1e-9;
                assert!(found.iter().any(is_in), "{corner} of {} corners", corners.len());
            }
        }
    }
}
