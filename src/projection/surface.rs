//! The model as rays meet it: which face is nearest along a ray, exactly, in f64.

use glam::DVec3;

use crate::geometry::bvh::Bvh;
use crate::scene::{FaceId, Model};

/// The model's triangles in a tree, each with its face.
#[derive(Debug)]
pub struct Surface {
    tree: Bvh,
    face_of: Vec<FaceId>,
}

/// Where a ray meets the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The point is `origin + t * direction`.
    pub t: f64,
    /// The face that is met.
    pub face: FaceId,
    /// Which of the face's triangles, from 0.
    pub triangle: u32,
}

impl Surface {
    /// Of a model in world coordinates.
    pub fn of(model: &Model) -> Self {
        let mut triangles = Vec::with_capacity(model.triangles.len());
        let mut face_of = Vec::with_capacity(model.triangles.len());
        for face in model.face_ids() {
            for corners in model.face_triangles(face) {
                triangles.push(corners.map(|vertex| model.vertices[vertex as usize]));
                face_of.push(face);
            }
        }
        Self { tree: Bvh::new(triangles), face_of }
    }

    /// The first face that the ray `origin + t direction`, t > 0, meets, from either side.
    pub fn nearest(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let (t, triangle) = self.tree.first_hit(origin, direction, f64::INFINITY)?;
        Some(self.hit(t, triangle))
    }

    fn hit(&self, t: f64, triangle: u32) -> Hit {
        let face = self.face_of[triangle as usize];
        // Triangles were gathered face by face.
        let first = self.face_of.partition_point(|other| *other < face);
        Hit { t, face, triangle: triangle - first as u32 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::synthetic::closed_form;

    #[test]
    fn a_ray_meets_the_nearer_of_two_quads() {
        let scene = closed_form::two_quads();
        let surface = Surface::of(&scene.model);
        let eye = scene.pose.center_in_world();
        let hit = surface.nearest(eye, DVec3::Z).unwrap();
        assert_eq!(scene.model.face_name(hit.face), "near[0]");
        let behind = surface.nearest(eye + DVec3::Z * (hit.t + 1e-9), DVec3::Z).unwrap();
        assert_eq!(scene.model.face_name(behind.face), "far[0]");
        assert_eq!(surface.nearest(eye, DVec3::NEG_Z), None);
    }
}
