//! Tests of plants as a whole: graphs, generated plants and brute force.

mod drawn;
mod flakes;
mod graphs;
mod grown;
mod layered;
mod shaded;

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::{Corner, Draft, DraftUse, Material, Plant, Primitive, Shape, TriangleList, assemble};
use crate::scene::synthetic::Rng;

/// A square of side 2 around the origin, across z.
pub fn square(material: Material) -> Primitive {
    let corner = |(x, y): (f64, f64)| Corner {
        position: DVec3::new(x, y, 0.0),
        normal: DVec3::ZERO,
        texture: DVec2::new(0.5 + 0.5 * x, 0.5 + 0.5 * y),
    };
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(corner);
    Primitive { shape: Shape::Polygon(corners.into()), material: Arc::new(material) }
}

/// A plant of one triangle that reaches from one corner of a box to the other.
pub fn boxed(low: DVec3, high: DVec3, up: DVec3) -> Plant {
    let corner = |position| Corner { position, normal: DVec3::Z, texture: DVec2::ZERO };
    let corners = [low, high, DVec3::new(low.x, high.y, low.z)].map(corner).to_vec();
    let shape = Shape::Triangles(TriangleList { corners, triangles: vec![[0, 1, 2]] });
    let primitives = vec![Primitive { shape, material: Arc::new(Material::default()) }];
    assemble(vec![draft("box", primitives, &[])], 0, up, 1.0).unwrap()
}

/// A draft of primitives that uses others.
pub fn draft(name: &str, primitives: Vec<Primitive>, uses: &[(usize, DAffine3)]) -> Draft {
    let uses = uses.iter().map(|&(child, parent_from_child)| DraftUse { child, parent_from_child }).collect();
    Draft { name: name.into(), primitives, uses }
}

/// A plant of one square.
pub fn plant_of(material: Material) -> Plant {
    assemble(vec![draft("square", vec![square(material)], &[])], 0, DVec3::Z, 1.0).unwrap()
}

/// A plant of so many leaves in a ball of radius 1 that images of it save something.
pub fn bushy() -> Plant {
    let leaf = Material { leaf: true, ..Material::default() };
    let mut rng = Rng::new(3);
    let mut uses = Vec::new();
    while uses.len() < 12_000 {
        let at = DVec3::from_array([0.0; 3].map(|_: f64| rng.between(-1.0, 1.0)));
        if at.length() < 1.0 {
            let turn =
                DMat3::from_rotation_z(rng.between(0.0, 6.0)) * DMat3::from_rotation_x(rng.between(0.0, 6.0));
            uses.push((0, DAffine3::from_mat3_translation(0.05 * turn, at)));
        }
    }
    let drafts = vec![draft("leaf", vec![square(leaf)], &[]), draft("bush", Vec::new(), &uses)];
    assemble(drafts, 1, DVec3::Z, 1.0).unwrap()
}
