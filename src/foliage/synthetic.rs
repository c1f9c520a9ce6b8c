//! Small plants that tests of several rooms draw.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec2, DVec3};

use crate::{Corner, Draft, DraftUse, Material, Plant, Primitive, Shape, TriangleList, assemble};
use quadratura_base::scene::synthetic::Rng;

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
    assemble(vec![draft("box", primitives, &[])], 0, up, 1.0).expect("the graph has no flaw")
}

/// A draft of primitives that uses others.
pub fn draft(name: &str, primitives: Vec<Primitive>, uses: &[(usize, DAffine3)]) -> Draft {
    let uses = uses.iter().map(|&(child, parent_from_child)| DraftUse { child, parent_from_child }).collect();
    Draft { name: name.into(), primitives, uses }
}

/// A plant of one square.
pub fn plant_of(material: Material) -> Plant {
    assemble(vec![draft("square", vec![square(material)], &[])], 0, DVec3::Z, 1.0)
        .expect("the graph has no flaw")
}

/// A plant of 60 bushels of a thousand leaves each in a ball of radius 1, so that images of it save something.
pub fn bushy() -> Plant {
    let leaf = Material { leaf: true, ..Material::default() };
    let mut rng = Rng::new(3);
    let mut in_ball = |count: usize, size: f64| {
        let mut uses = Vec::new();
        while uses.len() < count {
            let at = DVec3::from_array([0.0; 3].map(|_: f64| rng.between(-1.0, 1.0)));
            if at.length() < 1.0 {
                let turn = DMat3::from_rotation_z(rng.between(0.0, 6.0));
                let linear = size * turn * DMat3::from_rotation_x(rng.between(0.0, 6.0));
                uses.push((0, DAffine3::from_mat3_translation(linear, at)));
            }
        }
        uses
    };
    let bushel = in_ball(1000, 0.03);
    let bush: Vec<_> = in_ball(60, 0.06).into_iter().map(|(_, map)| (1, map)).collect();
    let drafts = vec![
        draft("leaf", vec![square(leaf)], &[]),
        draft("bushel", Vec::new(), &bushel),
        draft("bush", Vec::new(), &bush),
    ];
    assemble(drafts, 2, DVec3::Z, 1.0).expect("the graph has no flaw")
}
