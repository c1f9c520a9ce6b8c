//! Tests of plants as a whole: graphs, generated plants and brute force.

mod drawn;
mod flakes;
mod graphs;
mod grown;
mod layered;
mod shaded;

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};

use super::{Corner, Draft, DraftUse, Material, Plant, Primitive, Shape, TriangleList, assemble};

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
