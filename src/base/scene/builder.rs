//! Building a model from outlines, and the defects that are found in them.

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::model::{Face, FaceId, FaceIndex, Model, Object, ObjectId};
use crate::error::Result;
use crate::geometry::Plane;
use crate::geometry::polygon::{self, OutlineFlaw, Triangulation};
use crate::task::Task;

/// A defect of a face. None is fatal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FaceFlaw {
    /// The outline has a defect: it cannot be triangulated, or only with additional points.
    Outline(OutlineFlaw),
    /// The outline repeats a position in consecutive corners.
    RepeatedPoint,
    /// The face is not planar: a corner lies off its plane, and the face is treated by its triangles.
    NotPlanar,
}

/// A builder that collects vertices, objects and outlines in file order.
#[derive(Debug, Default)]
pub struct ModelBuilder {
    model: Model,
    by_name: FxHashMap<String, ObjectId>,
}

/// The number of corners whose faces are triangulated between two checks for cancellation.
const CORNERS_A_STEP: u32 = 1 << 18;

impl ModelBuilder {
    /// Starts an empty model.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a vertex and returns its index.
    pub fn vertex(&mut self, position: DVec3) -> u32 {
        self.model.vertices.push(position);
        self.model.vertices.len() as u32 - 1
    }

    /// Returns the vertices added so far.
    pub fn vertices(&self) -> &[DVec3] {
        &self.model.vertices
    }

    /// Returns the number of corners of all outlines added so far.
    pub fn corner_count(&self) -> usize {
        self.model.ring_vertices.len()
    }

    /// Returns the object of this name, which is added if it is new. An object that has the reserved name of the
    /// surroundings gets another one, `[surroundings] (object)`.
    pub fn object(&mut self, name: &str) -> ObjectId {
        let name = not_reserved(name);
        if let Some(&known) = self.by_name.get(name) {
            return known;
        }
        let id = ObjectId(self.model.objects.len() as u32);
        self.model.objects.push(Object {
            name: name.to_owned(),
            faces: Vec::new(),
            billboard: says_billboard(name),
            impostor: None,
            see_through: false,
            turned: false,
        });
        self.by_name.insert(name.to_owned(), id);
        id
    }

    /// Gives the objects other names, all different, in the order of their ids.
    pub fn name_objects(&mut self, names: Vec<String>) {
        self.by_name = names.iter().cloned().zip((0..).map(ObjectId)).collect();
        for (object, name) in self.model.objects.iter_mut().zip(names) {
            object.billboard |= says_billboard(&name);
            object.name = name;
        }
    }

    /// Returns true when an object has this name.
    pub fn has_object(&self, name: &str) -> bool {
        self.by_name.contains_key(name)
    }

    /// Marks an object as a billboard, which is visible from both sides.
    pub fn mark_billboard(&mut self, object: ObjectId) {
        self.model.objects[object.0 as usize].billboard = true;
    }

    /// Adds a face by its outline, counter-clockwise seen from the visible side, with bridged holes.
    ///
    /// # Panics
    /// Panics when a vertex does not exist.
    pub fn face(&mut self, object: ObjectId, ring: &[u32]) {
        assert!(ring.iter().all(|&v| (v as usize) < self.model.vertices.len()), "this vertex does not exist");
        let id = FaceId(self.model.faces.len() as u32);
        let start = self.model.ring_vertices.len() as u32;
        self.model.ring_vertices.extend_from_slice(ring);
        let faces = &mut self.model.objects[object.0 as usize].faces;
        self.model.faces.push(Face {
            object,
            index: FaceIndex::new(faces.len()),
            ring: start..start + ring.len() as u32,
            triangles: 0..0,
            plane: NO_PLANE,
            planar: true,
        });
        faces.push(id);
    }

    /// Computes planes and triangles. Returns the model and the defects of its faces, in face order.
    ///
    /// # Errors
    /// Returns [`crate::Error::Cancelled`] on request.
    pub fn finish(mut self, task: &Task) -> Result<(Model, Vec<(FaceId, FaceFlaw)>)> {
        let mut flaws = Vec::new();
        let total = self.model.faces.len();
        let mut start = 0;
        while start < total {
            task.step("triangulate the faces", start as u64, total as u64)?;
            let end = self.end_of_step(start);
            let ids = start as u32..end as u32;
            let filled: Vec<ComputedFace> =
                ids.clone().into_par_iter().map(|i| fill(&self.model, FaceId(i))).collect();
            for (id, face) in ids.map(FaceId).zip(filled) {
                flaws.extend(face.flaws().map(|flaw| (id, flaw)));
                self.store(id, face);
            }
            start = end;
        }
        task.step("triangulate the faces", total as u64, total as u64)?;
        Ok((self.model, flaws))
    }

    /// Returns the end of the faces from `start` on that have [`CORNERS_A_STEP`] corners together, at least one
    /// face.
    fn end_of_step(&self, start: usize) -> usize {
        let faces = &self.model.faces;
        let most = faces[start].ring.start.saturating_add(CORNERS_A_STEP);
        start + faces[start..].partition_point(|face| face.ring.end <= most).max(1)
    }

    fn store(&mut self, id: FaceId, filled: ComputedFace) {
        let model = &mut self.model;
        let ring = model.face(id).ring.clone();
        let first_crossing = model.vertices.len() as u32;
        let vertex = |i: u32| match ring.start.checked_add(i).filter(|at| *at < ring.end) {
            Some(at) => model.ring_vertices[at as usize],
            None => first_crossing + i - ring.len() as u32,
        };
        let start = model.triangles.len() as u32;
        model.triangles.extend(filled.triangulation.triangles.iter().map(|corners| corners.map(vertex)));
        model.vertices.extend(&filled.triangulation.crossings);
        let end = model.triangles.len() as u32;
        let face = &mut model.faces[id.0 as usize];
        (face.triangles, face.plane, face.planar) = (start..end, filled.plane, filled.planar);
    }
}

/// Returns true when a name marks its object as a backdrop, such as a sky behind everything else: it contains "backdrop"
/// in upper or lower case.
pub fn says_backdrop(name: &str) -> bool {
    name.to_lowercase().contains("backdrop")
}

/// Returns true when a name marks its object as a billboard: it contains "billboard" in upper or lower case.
pub fn says_billboard(name: &str) -> bool {
    name.to_lowercase().contains("billboard")
}

/// The reserved name of what photos show where no face of the model is: sky, hills, far houses. Stacks list it like an
/// object that has no faces.
pub const SURROUNDINGS: &str = "[surroundings]";

/// The name of an object of the model that is called as the surroundings are.
const RENAMED: &str = "[surroundings] (object)";

/// Returns a name for an object of the model.
pub fn not_reserved(name: &str) -> &str {
    if name == SURROUNDINGS { RENAMED } else { name }
}

/// The plane of faces without area; it does not matter, because they have no triangles.
const NO_PLANE: Plane = Plane { normal: DVec3::Z, point: DVec3::ZERO };

/// The computed plane and triangulation of one face.
struct ComputedFace {
    plane: Plane,
    planar: bool,
    repeated: bool,
    triangulation: Triangulation,
}

impl ComputedFace {
    fn flaws(&self) -> impl Iterator<Item = FaceFlaw> + use<> {
        let outline = self.triangulation.flaw.map(FaceFlaw::Outline);
        let repeated = self.repeated.then_some(FaceFlaw::RepeatedPoint);
        let bent = (!self.planar).then_some(FaceFlaw::NotPlanar);
        outline.into_iter().chain(repeated).chain(bent)
    }
}

/// Computes a face's plane and triangles.
fn fill(model: &Model, id: FaceId) -> ComputedFace {
    let ring: Vec<DVec3> = model.ring_points(id).collect();
    let repeated = ring.iter().zip(ring.iter().cycle().skip(1)).any(|(a, b)| a == b);
    let fitted = polygon::fit_plane(&ring);
    let plane = fitted.unwrap_or(Plane { point: ring.first().copied().unwrap_or_default(), ..NO_PLANE });
    ComputedFace {
        plane,
        planar: fitted.is_none() || polygon::is_planar(&ring, &plane),
        repeated,
        triangulation: match fitted {
            Some(plane) => polygon::triangulate(&ring, &plane),
            None => Triangulation { flaw: Some(OutlineFlaw::NoArea), ..Default::default() },
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn built(points: &[[f64; 3]], rings: &[&[u32]]) -> (Model, Vec<(FaceId, FaceFlaw)>) {
        let mut builder = ModelBuilder::new();
        points.iter().for_each(|&p| {
            builder.vertex(DVec3::from_array(p));
        });
        let object = builder.object("thing");
        rings.iter().for_each(|ring| builder.face(object, ring));
        builder.finish(&Task::silent()).unwrap()
    }

    const CORNERS: [[f64; 3]; 5] = [[0., 0., 0.], [2., 0., 0.], [2., 2., 0.], [0., 2., 0.], [1., 1., 1.]];

    #[test]
    fn an_object_that_is_called_like_the_surroundings_gets_another_name() {
        let mut builder = ModelBuilder::new();
        let [first, again] = [SURROUNDINGS; 2].map(|name| builder.object(name));
        assert_eq!(first, again);
        let (model, _) = builder.finish(&Task::silent()).unwrap();
        assert_eq!(model.object(first).name, RENAMED);
    }

    #[test]
    fn faces_keep_their_place_even_without_area() {
        let (model, flaws) = built(&CORNERS, &[&[0, 1, 1], &[0, 1, 2, 3], &[0, 1]]);
        assert_eq!(model.faces.iter().map(|f| f.triangles.len()).collect::<Vec<_>>(), [0, 2, 0]);
        assert_eq!(model.face_name(FaceId(1)), "thing[1]");
        let no_area = FaceFlaw::Outline(OutlineFlaw::NoArea);
        let expected = [(0, no_area), (0, FaceFlaw::RepeatedPoint), (2, no_area)];
        assert_eq!(flaws, expected.map(|(i, flaw)| (FaceId(i), flaw)));
    }

    #[test]
    fn crossings_become_vertices_of_the_model() {
        let (model, flaws) =
            built(&[[0., 0., 0.], [3., 3., 0.], [3., 0., 0.], [0., 2., 0.]], &[&[0, 1, 2, 3]]);
        assert_eq!(flaws, [(FaceId(0), FaceFlaw::Outline(OutlineFlaw::SelfCrossing))]);
        assert_eq!((model.vertices.len(), model.ring_vertices.len()), (5, 4));
        assert!(model.triangles.iter().flatten().any(|&v| v == 4));
    }

    #[test]
    fn a_bent_face_is_treated_by_its_triangles() {
        let (model, flaws) = built(&CORNERS, &[&[0, 1, 4, 3]]);
        assert_eq!(flaws, [(FaceId(0), FaceFlaw::NotPlanar)]);
        assert!(!model.faces[0].planar);
    }

    #[test]
    fn same_name_is_same_object_and_the_word_makes_a_billboard() {
        let mut builder = ModelBuilder::new();
        let tree = builder.object("Tree.Billboard");
        assert_eq!((builder.object("wall"), builder.object("Tree.Billboard")), (ObjectId(1), tree));
        let (model, _) = builder.finish(&Task::silent()).unwrap();
        assert_eq!(model.objects.iter().map(|o| o.billboard).collect::<Vec<_>>(), [true, false]);
    }
}
