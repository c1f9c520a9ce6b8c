//! The model as rays meet it: which face is nearest along a ray, exactly, in f64.

use glam::DVec3;

use super::Sources;
use super::sides::{Side, Sides};
use crate::geometry::bvh::Bvh;
use crate::scene::{FaceId, Model};

/// The model's triangles in a tree, each with its face.
#[derive(Debug)]
pub struct Surface {
    tree: Bvh,
    face_of: Vec<FaceId>,
    /// Where nothing is known of what serves faces, no side is a back.
    sides: Sides,
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
        Self { tree: Bvh::new(triangles), face_of, sides: Sides::default() }
    }

    /// The same, which knows backs of faces from what serves them.
    pub fn with_backs(self, model: &Model, sources: &Sources) -> Self {
        Self { sides: Sides::of(model, sources), ..self }
    }

    /// Which sides of faces are backs.
    pub fn sides(&self) -> &Sides {
        &self.sides
    }

    /// The first face that the ray `origin + t direction`, t > 0, meets, from either side.
    pub fn nearest(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let (t, triangle) = self.tree.first_hit(origin, direction, f64::INFINITY)?;
        Some(self.hit(t, triangle))
    }

    /// The first face that the ray meets and that is seen: with `backs` any, else not one whose back is met.
    pub fn first_seen(&self, origin: DVec3, direction: DVec3, backs: bool) -> Option<Hit> {
        let first = self.nearest(origin, direction)?;
        if backs || !self.is_back(&first, direction) {
            return Some(first);
        }
        let mut found: Option<(f64, u32)> = None;
        self.tree.each_hit(origin, direction, f64::INFINITY, |t, triangle| {
            let nearer = found.is_none_or(|(other, _)| t < other);
            if nearer && !self.is_back(&self.hit(t, triangle), direction) {
                found = Some((t, triangle));
            }
        });
        found.map(|(t, triangle)| self.hit(t, triangle))
    }

    /// The face that owns what is seen along a ray, as [`Self::first_seen`] has it: of those within the share
    /// `tolerance` of the nearest depth, the last in the model file.
    pub fn owner(&self, origin: DVec3, direction: DVec3, tolerance: f64, backs: bool) -> Option<Hit> {
        let nearest = self.first_seen(origin, direction, backs)?.t;
        let mut last: Option<(u32, f64)> = None;
        self.tree.each_hit(origin, direction, nearest * (1.0 + tolerance), |t, triangle| {
            let is_seen = || backs || !self.is_back(&self.hit(t, triangle), direction);
            if last.is_none_or(|(other, _)| triangle > other) && is_seen() {
                last = Some((triangle, t));
            }
        });
        // Triangles lie in the order of faces.
        last.map(|(triangle, t)| self.hit(t, triangle))
    }

    /// Whether a ray in this direction meets a back there. Triangles are wound as their faces are.
    fn is_back(&self, hit: &Hit, direction: DVec3) -> bool {
        let first = self.face_of.partition_point(|other| *other < hit.face);
        let [a, b, c] = self.tree.triangles()[first + hit.triangle as usize];
        let along = (b - a).cross(c - a).dot(direction);
        self.sides.is_back(hit.face, if along > 0.0 { Side::Back } else { Side::Front })
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
    use crate::scene::synthetic::{Modeller, closed_form};

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

    #[test]
    fn of_faces_in_one_plane_the_last_owns_what_is_seen() {
        let mut m = Modeller::new();
        m.object("wall").screen(5.0, [-2.0, -2.0, 2.0, 2.0]);
        m.object("window").screen(5.0002, [-1.0, -1.0, 1.0, 1.0]);
        m.object("behind").screen(5.01, [-2.0, -2.0, 2.0, 2.0]);
        let model = m.finish();
        let surface = Surface::of(&model);
        let owner = |x: f64| surface.owner(DVec3::ZERO, DVec3::new(x, 0.01, 1.0), 1e-4, true).unwrap().face;
        assert_eq!(model.face_name(owner(0.1)), "window[0]");
        assert_eq!(model.face_name(owner(0.3)), "wall[0]");
    }
}
