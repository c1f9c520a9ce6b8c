//! Houses and columns of the blocks: the model, and for each face how it is painted.

use std::fmt::Write;
use std::sync::Arc;

use glam::{DVec3, dvec3};
use quadratura_base::geometry::bvh::Bvh;
use quadratura_base::scene::Model;
use quadratura_base::scene::synthetic::{Modeller, Rng};

use crate::colours::Material;
use crate::plan::{PITCH, Plan, STREET};

/// The depth of a house, from the street to the courtyard.
const DEPTH: f64 = 9.0;
/// The gap between two houses, so that no two walls lie in one plane.
const GAP: f64 = 0.15;
/// The height of a storey.
pub const STOREY: f64 = 3.0;
/// A column's side and height, and how far its middle is from the house.
const COLUMN: [f64; 3] = [0.5, 3.2, 1.6];

/// How a face is painted: its material in a frame in metres.
#[derive(Debug, Clone, Copy)]
pub struct Surface {
    /// What it is made of.
    pub material: Material,
    /// The point where both coordinates are 0.
    pub origin: DVec3,
    /// To the right, and up.
    pub axes: [DVec3; 2],
    /// The unit normal.
    pub normal: DVec3,
    /// The width in metres.
    pub width: f64,
    /// Decides about colours.
    pub seed: u64,
}

/// The town: its model, and what is needed to draw and to look it up.
pub struct Town {
    /// The model.
    pub model: Arc<Model>,
    /// How each of its faces is painted.
    pub surfaces: Vec<Surface>,
    /// Its triangles, for rays.
    pub rays: Bvh,
    /// The face of each triangle of `rays`.
    pub face_of: Vec<u32>,
}

/// Builds the town of a plan.
pub fn build(plan: &Plan, seed: u64) -> Town {
    let mut builder = Builder { modeller: Modeller::new(), surfaces: Vec::new() };
    builder.ground(plan);
    for &block in &plan.blocks {
        builder.block(block, seed);
    }
    let (model, surfaces) = (builder.modeller.finish(), builder.surfaces);
    let (mut triangles, mut face_of) = (Vec::new(), Vec::new());
    for (number, face) in model.faces.iter().enumerate() {
        for triangle in &model.triangles[face.triangles.start as usize..face.triangles.end as usize] {
            triangles.push(triangle.map(|vertex| model.vertices[vertex as usize]));
            face_of.push(number as u32);
        }
    }
    Town { model, surfaces, rays: Bvh::new(triangles), face_of }
}

impl Town {
    /// Returns the model as the text of a Wavefront OBJ file.
    pub fn obj(&self) -> String {
        let model = &self.model;
        let mut text = String::from("# A synthetic town, in metres, z up.\n");
        for vertex in &model.vertices {
            writeln!(text, "v {:.4} {:.4} {:.4}", vertex.x, vertex.y, vertex.z).expect("a string takes all");
        }
        for object in &model.objects {
            writeln!(text, "o {}", object.name).expect("a string takes all");
            for &face in &object.faces {
                let ring = &model.face(face).ring;
                let corners = &model.ring_vertices[ring.start as usize..ring.end as usize];
                let corners: Vec<String> = corners.iter().map(|corner| (corner + 1).to_string()).collect();
                writeln!(text, "f {}", corners.join(" ")).expect("a string takes all");
            }
        }
        text
    }
}

/// The model under construction.
struct Builder {
    modeller: Modeller,
    surfaces: Vec<Surface>,
}

/// A place for houses: a corner on the street, the direction along it, and the direction to the courtyard.
#[derive(Clone, Copy)]
struct Lot {
    corner: DVec3,
    along: DVec3,
    inwards: DVec3,
    width: f64,
}

impl Lot {
    fn at(self, along: f64, inwards: f64, z: f64) -> DVec3 {
        self.corner + self.along * along + self.inwards * inwards + DVec3::Z * z
    }
}

impl Builder {
    /// Adds a polygon whose first edge is its lower one, from left to right seen from outside.
    fn face(&mut self, corners: &[DVec3], material: Material, seed: u64) {
        self.modeller.polygon(corners);
        let right = corners[1] - corners[0];
        let normal = right.cross(corners[2] - corners[0]).normalize();
        let axes = [right.normalize(), normal.cross(right).normalize()];
        self.surfaces.push(Surface {
            material,
            origin: corners[0],
            axes,
            normal,
            width: right.length(),
            seed,
        });
    }

    /// Adds one polygon for the ground of the whole town.
    fn ground(&mut self, plan: &Plan) {
        let ends = |axis: usize| {
            let places = plan.blocks.iter().map(|block| block[axis]);
            let (least, most) = (places.clone().min().unwrap_or(0), places.max().unwrap_or(0));
            (f64::from(least) * PITCH - 20.0, f64::from(most + 1) * PITCH + 20.0)
        };
        let ((x0, x1), (y0, y1)) = (ends(0), ends(1));
        let corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(|[x, y]| dvec3(x, y, 0.0));
        self.modeller.object("ground");
        self.face(&corners, Material::Cobbles, 7);
    }

    /// Adds the houses around the courtyard of a block.
    fn block(&mut self, [column, row]: [i32; 2], seed: u64) {
        let mut rng =
            Rng::new(seed ^ ((column as u64) << 32) ^ (row as u32 as u64).wrapping_mul(0x9e37_79b9));
        let south_west =
            dvec3(f64::from(column), f64::from(row), 0.0) * PITCH + dvec3(0.5, 0.5, 0.0) * STREET;
        let side = PITCH - STREET;
        let turns = [DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y];
        let mut corner = south_west;
        for (turn, &along) in turns.iter().enumerate() {
            let inwards = turns[(turn + 1) % 4];
            // Rows to the south and to the north reach from corner to corner, the others lie between them.
            let (begins, length, count) =
                if turn % 2 == 0 { (0.0, side, 3) } else { (DEPTH, side - 2.0 * DEPTH, 2) };
            for house in 0..count {
                let width = length / f64::from(count);
                let start = corner + along * (begins + width * f64::from(house) + GAP);
                let lot = Lot { corner: start, along, inwards, width: width - 2.0 * GAP };
                let name = format!("{column}_{row}_{turn}{house}");
                self.house(lot, &name, turn % 2 == 0, &mut rng);
            }
            corner += along * side;
        }
    }

    fn house(&mut self, lot: Lot, name: &str, has_columns: bool, rng: &mut Rng) {
        let eaves = STOREY * f64::from(rng.whole(2, 4)) + rng.between(0.2, 0.9);
        let ridge = eaves + rng.between(1.5, 3.2);
        let seed = rng.bits();
        let (w, d) = (lot.width, DEPTH - 2.0 * GAP);
        self.modeller.object(format!("house_{name}"));
        let wall = Material::Facade;
        self.face(
            &[lot.at(0.0, 0.0, 0.0), lot.at(w, 0.0, 0.0), lot.at(w, 0.0, eaves), lot.at(0.0, 0.0, eaves)],
            wall,
            seed,
        );
        self.face(
            &[lot.at(w, d, 0.0), lot.at(0.0, d, 0.0), lot.at(0.0, d, eaves), lot.at(w, d, eaves)],
            wall,
            seed ^ 1,
        );
        let gable = |along: f64, from: f64, to: f64| {
            [
                lot.at(along, from, 0.0),
                lot.at(along, to, 0.0),
                lot.at(along, to, eaves),
                lot.at(along, 0.5 * d, ridge),
                lot.at(along, from, eaves),
            ]
        };
        self.face(&gable(w, 0.0, d), Material::Plaster, seed ^ 2);
        self.face(&gable(0.0, d, 0.0), Material::Plaster, seed ^ 3);
        self.modeller.object(format!("roof_{name}"));
        let roof = Material::Tiles;
        let top = |along: f64| lot.at(along, 0.5 * d, ridge);
        self.face(&[lot.at(0.0, 0.0, eaves), lot.at(w, 0.0, eaves), top(w), top(0.0)], roof, seed ^ 4);
        self.face(&[lot.at(w, d, eaves), lot.at(0.0, d, eaves), top(0.0), top(w)], roof, seed ^ 4);
        if has_columns {
            self.modeller.object(format!("columns_{name}"));
            for share in [0.25, 0.75] {
                self.column(lot, share * w, seed);
            }
        }
    }

    fn column(&mut self, lot: Lot, along: f64, seed: u64) {
        let [side, height, apart] = COLUMN;
        let (a0, a1, i0, i1) =
            (along - 0.5 * side, along + 0.5 * side, -apart - 0.5 * side, -apart + 0.5 * side);
        let feet = [[a0, i0], [a1, i0], [a1, i1], [a0, i1]];
        for corner in 0..4 {
            let ([from_a, from_i], [to_a, to_i]) = (feet[corner], feet[(corner + 1) % 4]);
            let corners = [
                lot.at(from_a, from_i, 0.0),
                lot.at(to_a, to_i, 0.0),
                lot.at(to_a, to_i, height),
                lot.at(from_a, from_i, height),
            ];
            self.face(&corners, Material::Stone, seed ^ corner as u64);
        }
        self.face(&feet.map(|[a, i]| lot.at(a, i, height)), Material::Stone, seed);
    }
}
