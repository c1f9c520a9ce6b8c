//! A plant as balls, coarse enough that hundreds of trees are found in a photo at once: for guides, not for pictures.

use glam::{DAffine3, DVec3, IVec3};
use rustc_hash::FxHashMap;

use super::bounds::Ball;
use super::mesh::Mesh;
use super::plant::Plant;

/// The side of the cells in which pieces of a plant become one ball, as a share of the radius of the whole plant.
const CELL: f64 = 1.0 / 32.0;
/// A plant is taken apart into at most so many pieces; these are larger where it would have more.
const MOST_PIECES: usize = 4_000_000;

/// Returns balls in the plant's frame that are about where it is: of sub-objects that are small enough, and of pieces of the
/// triangles of larger ones, one for each cell of a grid.
pub fn balls(plant: &Plant) -> Vec<Ball> {
    let whole = plant.whole().bounds.ball;
    if !(whole.radius.is_finite() && whole.radius > 0.0) {
        return Vec::new();
    }
    let mut cell = CELL * whole.radius;
    loop {
        let mut grid =
            BallGrid { plant, cell, meshes: FxHashMap::default(), cells: FxHashMap::default(), pieces: 0 };
        grid.visit(plant.root, &DAffine3::IDENTITY);
        if grid.pieces < MOST_PIECES || cell > whole.radius {
            let mut cells: Vec<([i32; 3], Ball)> = grid.cells.into_iter().collect();
            cells.sort_by_key(|(place, _)| *place);
            return cells.into_iter().map(|(_, ball)| ball).collect();
        }
        cell *= 2.0;
    }
}

struct BallGrid<'a> {
    plant: &'a Plant,
    cell: f64,
    /// The meshes of the sub-objects that were met.
    meshes: FxHashMap<usize, Vec<Mesh>>,
    /// The largest piece in each cell.
    cells: FxHashMap<[i32; 3], Ball>,
    pieces: usize,
}

impl BallGrid<'_> {
    fn visit(&mut self, object: usize, plant_from_object: &DAffine3) {
        let of_plant = &self.plant.objects[object];
        let ball = of_plant.bounds.ball.mapped(plant_from_object);
        // There is nothing in an empty sub-object.
        if !(ball.radius.is_finite() && ball.radius >= 0.0) || self.pieces >= MOST_PIECES {
            return;
        }
        if 2.0 * ball.radius <= self.cell {
            self.add(ball);
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

    /// Covers a triangle, which is halved along its longest side until pieces are no larger than a cell.
    fn cover(&mut self, corners: [DVec3; 3]) {
        let middle = corners.iter().sum::<DVec3>() / 3.0;
        let radius = corners.iter().map(|corner| corner.distance(middle)).fold(0.0, f64::max);
        if self.pieces >= MOST_PIECES || !radius.is_finite() {
            return;
        }
        if 2.0 * radius <= self.cell {
            self.add(Ball { middle, radius });
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

    /// Adds a piece, which is no larger than a cell. Others in its cell are about where it is.
    fn add(&mut self, piece: Ball) {
        self.pieces += 1;
        let IVec3 { x, y, z } = (piece.middle / self.cell).floor().as_ivec3();
        // At least as large as gaps between cells of a surface.
        let ball = Ball { radius: piece.radius.max(0.5 * self.cell), ..piece };
        let known = self.cells.entry([x, y, z]).or_insert(ball);
        if ball.radius > known.radius {
            *known = ball;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{boxed, bushy};

    #[test]
    fn balls_are_where_a_plant_is_and_small_and_few() {
        for plant in [boxed(DVec3::ZERO, DVec3::new(2.0, 3.0, 4.0), DVec3::Z), bushy()] {
            let cell = CELL * plant.whole().bounds.ball.radius;
            let found = balls(&plant);
            assert!(found.len() > 100 && found.len() < 60_000, "{}", found.len());
            assert!(found.iter().all(|ball| 2.0 * ball.radius <= cell * (1.0 + 1e-9)));
            let mut corners = Vec::new();
            let mut visit = vec![(plant.root, DAffine3::IDENTITY)];
            while let Some((object, map)) = visit.pop() {
                let own = Mesh::of(&plant.objects[object]);
                let own = own.iter().flat_map(|mesh| &mesh.corners);
                corners.extend(own.map(|corner| map.transform_point3(corner.position)));
                let uses = plant.objects[object].uses.iter();
                visit.extend(uses.map(|child| (child.child, map * child.parent_from_child)));
            }
            // A corner is at most half a cell from the middle of its piece, which is in the cell of a ball's middle. All corners of
            // a small plant, some of a large one.
            let most = cell * (0.5 + 3f64.sqrt());
            for corner in corners.iter().step_by(1 + corners.len() / 500) {
                let is_near = |ball: &Ball| ball.middle.distance(*corner) <= most;
                assert!(found.iter().any(is_near), "{corner} of {} corners", corners.len());
            }
        }
    }
}
