//! Tests of plants as a whole: graphs, generated plants and brute force.

mod drawn;
mod graphs;
mod grown;

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};

use super::{Corner, Draft, DraftUse, Material, Plant, Primitive, Shape, assemble};

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

/// A draft of primitives that uses others.
pub fn draft(name: &str, primitives: Vec<Primitive>, uses: &[(usize, DAffine3)]) -> Draft {
    let uses = uses.iter().map(|&(child, parent_from_child)| DraftUse { child, parent_from_child }).collect();
    Draft { name: name.into(), primitives, uses }
}

/// A plant of one square.
pub fn plant_of(material: Material) -> Plant {
    assemble(vec![draft("square", vec![square(material)], &[])], 0, DVec3::Z, 1.0).unwrap()
}
