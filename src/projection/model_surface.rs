//! Ray casting against the model, exact in f64.

use std::collections::BTreeSet;

use glam::DVec3;

use super::Sources;
use super::sides::{BackSides, Side};
use quadratura_base::geometry::bvh::Bvh;
use quadratura_base::scene::impostor::{Facing, Impostor};
use quadratura_base::scene::{FaceId, Model};
use quadratura_view::hidden::{Culling, HiddenFaces};

/// The model's triangles in a bounding volume hierarchy, each with its face.
#[derive(Debug)]
pub struct ModelSurface {
    tree: Bvh,
    face_of: Vec<FaceId>,
    /// The back sides of faces; none where it is not known which photos texture them.
    sides: BackSides,
    /// The impostors, each with the face that stands for it. A ray meets the rectangle that faces its origin.
    impostors: Vec<(FaceId, Impostor)>,
}

/// The intersection of a ray with the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayHit {
    /// The ray parameter: the point is `origin + t * direction`.
    pub t: f64,
    /// The face that is hit.
    pub face: FaceId,
    /// The index of the triangle within the face.
    pub triangle: u32,
}

impl ModelSurface {
    /// Builds the hierarchy of a model in world coordinates.
    pub fn from_model(model: &Model) -> Self {
        let mut triangles = Vec::with_capacity(model.triangles.len());
        let mut face_of = Vec::with_capacity(model.triangles.len());
        let mut impostors = Vec::new();
        for face in model.face_ids() {
            if let Some(impostor) = model.impostor(face) {
                impostors.extend(model.stands_for_impostor(face).then_some((face, *impostor)));
                continue;
            }
            for corners in model.face_triangles(face) {
                triangles.push(corners.map(|vertex| model.vertices[vertex as usize]));
                face_of.push(face);
            }
        }
        Self { tree: Bvh::new(triangles), face_of, sides: BackSides::default(), impostors }
    }

    /// Adds the back sides of faces, from the photos that texture them.
    pub fn with_backs(self, model: &Model, sources: &Sources) -> Self {
        Self { sides: BackSides::new(model, sources), ..self }
    }

    /// Returns the back sides of faces.
    pub fn sides(&self) -> &BackSides {
        &self.sides
    }

    /// Finds the first face that the ray `origin + t direction`, t > 0, hits, from either side.
    pub fn nearest(&self, origin: DVec3, direction: DVec3) -> Option<RayHit> {
        let of_tree = self.tree.first_hit(origin, direction, f64::INFINITY);
        let of_tree = of_tree.map(|(t, triangle)| self.hit(t, triangle));
        of_tree.into_iter().chain(self.on_impostors(origin, direction)).reduce(nearer)
    }

    /// Returns where a ray meets impostors.
    fn on_impostors(&self, origin: DVec3, direction: DVec3) -> impl Iterator<Item = RayHit> {
        // The direction to the right matters on the axis alone, where there is no right one.
        let camera = Facing { eye: origin, right: DVec3::ZERO };
        let met = move |(face, impostor): &(FaceId, Impostor)| {
            Some(RayHit { t: impostor.met(&camera, direction)?, face: *face, triangle: 0 })
        };
        self.impostors.iter().filter_map(met)
    }

    /// Finds the first visible face that the ray hits, of those that are not culled.
    pub fn first_visible(&self, origin: DVec3, direction: DVec3, culling: Culling<'_>) -> Option<RayHit> {
        let first = self.nearest(origin, direction)?;
        if !self.is_culled(&first, direction, culling) {
            return Some(first);
        }
        let mut found: Option<(f64, u32)> = None;
        self.tree.each_hit(origin, direction, f64::INFINITY, |t, triangle| {
            let nearer = found.is_none_or(|(other, _)| t < other);
            if nearer && !self.is_culled(&self.hit(t, triangle), direction, culling) {
                found = Some((t, triangle));
            }
        });
        let found = found.map(|(t, triangle)| self.hit(t, triangle));
        let seen = |hit: &RayHit| !culling.hidden.contains(hit.face);
        found.into_iter().chain(self.on_impostors(origin, direction).filter(seen)).reduce(nearer)
    }

    /// Finds the face that owns the visible point along a ray (see [`Self::first_visible`]): of the faces within
    /// the share `tolerance` of the nearest depth, the last one in the model file.
    pub fn owner(
        &self,
        origin: DVec3,
        direction: DVec3,
        tolerance: f64,
        culling: Culling<'_>,
    ) -> Option<RayHit> {
        let nearest = self.first_visible(origin, direction, culling)?.t;
        let mut last: Option<(u32, f64)> = None;
        self.tree.each_hit(origin, direction, nearest * (1.0 + tolerance), |t, triangle| {
            let is_seen = || !self.is_culled(&self.hit(t, triangle), direction, culling);
            if last.is_none_or(|(other, _)| triangle > other) && is_seen() {
                last = Some((triangle, t));
            }
        });
        // Triangles are in the order of faces.
        let last = last.map(|(triangle, t)| self.hit(t, triangle));
        let within =
            |hit: &RayHit| hit.t <= nearest * (1.0 + tolerance) && !culling.hidden.contains(hit.face);
        let all = last.into_iter().chain(self.on_impostors(origin, direction).filter(within));
        all.max_by_key(|hit| hit.face)
    }

    /// Finds where a ray meets some of the faces, except those that are culled: each face once, from back to front; of hits
    /// at the same depth the last face in the model file comes last.
    pub fn through(
        &self,
        origin: DVec3,
        direction: DVec3,
        faces: &BTreeSet<FaceId>,
        culling: Culling<'_>,
    ) -> Vec<RayHit> {
        let is_meant = |hit: &RayHit| faces.contains(&hit.face) && !self.is_culled(hit, direction, culling);
        let mut hits: Vec<RayHit> =
            self.on_impostors(origin, direction).filter(|hit| faces.contains(&hit.face)).collect();
        let turns = |face: &FaceId| self.impostors.iter().any(|(impostor, _)| impostor == face);
        if !faces.iter().all(turns) {
            self.tree.each_hit(origin, direction, f64::INFINITY, |t, triangle| {
                hits.push(self.hit(t, triangle));
            });
        }
        hits.retain(is_meant);
        hits.sort_by(|a, b| b.t.total_cmp(&a.t).then(a.face.cmp(&b.face)));
        hits.dedup_by_key(|hit| hit.face);
        hits
    }

    /// Finds the first face between two points that blocks the way from one to the other: one that is not hidden, hit
    /// on the side that photos show.
    pub fn blocks(&self, from: DVec3, to: DVec3, hidden: &HiddenFaces) -> Option<RayHit> {
        let culling = Culling { backs: false, hidden };
        self.first_visible(from, to - from, culling).filter(|hit| hit.t <= 1.0)
    }

    fn is_culled(&self, hit: &RayHit, direction: DVec3, culling: Culling<'_>) -> bool {
        culling.hidden.contains(hit.face) || (!culling.backs && self.is_back(hit, direction))
    }

    /// Returns true when a ray in this direction hits a back side. Triangles are wound like their faces.
    fn is_back(&self, hit: &RayHit, direction: DVec3) -> bool {
        if self.impostors.iter().any(|(face, _)| *face == hit.face) {
            return false;
        }
        let first = self.face_of.partition_point(|other| *other < hit.face);
        let [a, b, c] = self.tree.triangles()[first + hit.triangle as usize];
        let along = (b - a).cross(c - a).dot(direction);
        self.sides.is_back(hit.face, if along > 0.0 { Side::Back } else { Side::Front })
    }

    fn hit(&self, t: f64, triangle: u32) -> RayHit {
        let face = self.face_of[triangle as usize];
        // Triangles were gathered face by face, so those of a face are consecutive.
        let first = self.face_of.partition_point(|other| *other < face);
        RayHit { t, face, triangle: triangle - first as u32 }
    }
}

/// Returns the nearer of two hits; the first of equal ones.
fn nearer(a: RayHit, b: RayHit) -> RayHit {
    if b.t < a.t { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::{Modeller, closed_form};

    #[test]
    fn a_ray_meets_the_nearer_of_two_quads() {
        let scene = closed_form::two_quads();
        let surface = ModelSurface::from_model(&scene.model);
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
        let surface = ModelSurface::from_model(&model);
        let owner = |x: f64, hidden: &HiddenFaces| {
            let culling = Culling { backs: true, hidden };
            surface.owner(DVec3::ZERO, DVec3::new(x, 0.01, 1.0), 1e-4, culling).unwrap().face
        };
        let none = HiddenFaces::default();
        assert_eq!(model.face_name(owner(0.1, &none)), "window[0]");
        assert_eq!(model.face_name(owner(0.3, &none)), "wall[0]");
        let window: HiddenFaces = [owner(0.1, &none)].into_iter().collect();
        assert_eq!(model.face_name(owner(0.1, &window)), "wall[0]", "a hidden face owns nothing");
        let both: HiddenFaces = window.iter().chain([owner(0.3, &none)]).collect();
        assert_eq!(model.face_name(owner(0.3, &both)), "behind[0]");
    }

    #[test]
    fn the_way_is_blocked_by_a_face_on_its_shown_side_and_by_no_other() {
        let mut m = Modeller::new();
        m.object("wall").screen(5.0, [-2.0, -2.0, 2.0, 2.0]);
        let model = m.finish();
        let surface = ModelSurface::from_model(&model);
        let (here, near, beyond) = (DVec3::ZERO, DVec3::Z * 4.0, DVec3::Z * 6.0);
        let none = HiddenFaces::default();
        assert!(surface.blocks(here, near, &none).is_none(), "the wall is farther");
        assert!(surface.blocks(here, beyond, &none).is_some());
        assert!(surface.blocks(here, beyond, &model.face_ids().collect()).is_none(), "a hidden wall is none");
    }
}
