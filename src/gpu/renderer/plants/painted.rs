//! Paint on the polygons of a plant: found at their corners, and between them mixed by the device.

use quadratura_foliage::{Change, Mesh, PaintAt};

/// A mesh with the paint on it.
pub struct Painted {
    /// The mesh without the triangles that were erased.
    pub mesh: Mesh,
    /// The change of colour at each corner.
    pub changes: Vec<Change>,
}

impl Painted {
    /// Finds the paint on the corners of a mesh. Of triangles that are erased in part, as many of each hundred are left out.
    pub fn new(mut mesh: Mesh, paint: &[PaintAt]) -> Self {
        if paint.is_empty() {
            let changes = vec![Change::NONE; mesh.corners.len()];
            return Self { mesh, changes };
        }
        let is_leaf = mesh.material.leaf;
        let at = |point| {
            let change = |of: &PaintAt| of.field.at(of.field_from_object.transform_point3(point), is_leaf);
            paint.iter().map(change).fold(Change::NONE, |all, change| all.then(&change))
        };
        let mut changes: Vec<Change> = mesh.corners.iter().map(|corner| at(corner.position)).collect();
        let corners = &mesh.corners;
        let mut number = 0u32;
        mesh.triangles.retain(|triangle| {
            number += 1;
            let [a, b, c] = triangle.map(|corner| corners[corner as usize].position);
            let middle = at((a + b + c) / 3.0);
            // A leaf is as large as the texels of paint: what is found in its middle is on all of it.
            for corner in triangle.iter().filter(|_| is_leaf && middle.colour != Change::NONE.colour) {
                let of = &mut changes[*corner as usize];
                if of.colour == Change::NONE.colour {
                    of.colour = middle.colour;
                }
            }
            middle.alpha >= 1.0 || middle.alpha > share(number)
        });
        Self { mesh, changes }
    }
}

/// Returns a share, at least 0 and below 1, that belongs to a number: those of numbers in a row are spread evenly.
fn share(number: u32) -> f32 {
    // The fractional part of multiples of the golden ratio.
    (number.wrapping_mul(0x9E37_79B9) >> 8) as f32 / (1u32 << 24) as f32
}
