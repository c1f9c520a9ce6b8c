//! The model: named objects of planar polygon faces, as they were modelled.

use std::fmt;
use std::ops::Range;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::alike;
use super::impostor::Impostor;
use crate::geometry::{Plane, Similarity};

/// The index of a face: faces are numbered through all objects in file order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
pub struct FaceId(pub u32);

/// The index of a face within its object, in file order. Files and users name a face by its object and this index, so it
/// is written as a plain number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct FaceIndex(pub u32);

impl FaceIndex {
    /// Returns the index of the face at a position in [`Object::faces`].
    pub fn new(position: usize) -> Self {
        Self(position as u32)
    }

    /// Returns the position in [`Object::faces`].
    pub fn index(self) -> usize {
        self.0 as usize
    }

    /// Returns the indices of an object's `count` faces.
    pub fn all(count: usize) -> impl ExactSizeIterator<Item = Self> + DoubleEndedIterator + Clone {
        (0..count as u32).map(Self)
    }
}

impl fmt::Display for FaceIndex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// The index of an object in [`Model::objects`], in order of first appearance in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ObjectId(pub u32);

impl ObjectId {
    /// Returns the id of the object at a position in [`Model::objects`].
    pub fn new(position: usize) -> Self {
        Self(position as u32)
    }

    /// Returns the position in [`Model::objects`].
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A named object. Names are unique within a model.
#[derive(Debug, Clone, PartialEq)]
pub struct Object {
    /// The unique name.
    pub name: String,
    /// The object's faces; the position in this list is the face's index within the object.
    pub faces: Vec<FaceId>,
    /// Whether the object is a billboard, a flat stand-in for foliage and the like that is visible from both sides.
    pub billboard: bool,
    /// The rectangle that takes the place of its faces, where the object turns towards cameras.
    pub impostor: Option<Impostor>,
    /// Whether one may see through its faces in places: impostors, and objects that were declared so.
    pub see_through: bool,
    /// Whether the first face has been replaced by that rectangle ([`Model::turn_towards`]).
    pub turned: bool,
}

impl Object {
    /// Returns the face with this index within the object.
    pub fn face(&self, index: FaceIndex) -> Option<FaceId> {
        self.faces.get(index.index()).copied()
    }

    /// Returns whether photos show at its faces also what is behind them, and so something else from each viewpoint.
    pub fn shows_what_is_behind(&self) -> bool {
        self.billboard || self.see_through
    }
}

/// A polygon face. Its ranges refer to the [`Model`]'s flat arrays.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    /// The object that the face belongs to.
    pub object: ObjectId,
    /// The index within the object, as in the model file.
    pub index: FaceIndex,
    /// The outline as a range in [`Model::ring_vertices`]: one ring with holes bridged by doubled edges,
    /// counter-clockwise seen from the visible side.
    pub ring: Range<u32>,
    /// The triangles as a range in [`Model::triangles`], wound like the outline; empty for a face without area.
    pub triangles: Range<u32>,
    /// The least-squares plane of the outline (Newell's normal).
    pub plane: Plane,
    /// Whether all vertices lie in the plane, within the reader's limit; otherwise the face is treated by its
    /// triangles.
    pub planar: bool,
}

/// A coarse polygon model. It is immutable once read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Model {
    /// The vertex positions: in the file's frame after reading, in the world in a [`super::Site`].
    pub vertices: Vec<DVec3>,
    /// The outlines of all faces, as indices into `vertices`.
    pub ring_vertices: Vec<u32>,
    /// The triangles of all faces, as indices into `vertices`.
    pub triangles: Vec<[u32; 3]>,
    /// All faces in file order, indexed by [`FaceId`].
    pub faces: Vec<Face>,
    /// All objects in order of first appearance, indexed by [`ObjectId`].
    pub objects: Vec<Object>,
}

impl Model {
    /// Returns the face with this id.
    pub fn face(&self, id: FaceId) -> &Face {
        &self.faces[id.0 as usize]
    }

    /// Returns the object with this id.
    pub fn object(&self, id: ObjectId) -> &Object {
        &self.objects[id.0 as usize]
    }

    /// Returns the object with this name.
    pub fn object_named(&self, name: &str) -> Option<ObjectId> {
        self.objects.iter().position(|object| object.name == name).map(ObjectId::new)
    }

    /// Returns the object with this name, or else the only one whose name means the same in another spelling ([`alike`]).
    pub fn object_like(&self, name: &str) -> Option<ObjectId> {
        alike::find(name, self.objects.iter().map(|object| &object.name)).one().map(ObjectId::new)
    }

    /// Returns the face that files and users call `object[index]`.
    pub fn face_named(&self, object: &str, index: FaceIndex) -> Option<FaceId> {
        self.object(self.object_named(object)?).face(index)
    }

    /// Returns all face ids in file order.
    pub fn face_ids(&self) -> impl ExactSizeIterator<Item = FaceId> + use<> {
        (0..self.faces.len() as u32).map(FaceId)
    }

    /// Returns the outline of a face, as indices into `vertices`.
    pub fn ring(&self, id: FaceId) -> &[u32] {
        let range = &self.face(id).ring;
        &self.ring_vertices[range.start as usize..range.end as usize]
    }

    /// Returns the outline of a face, as points.
    pub fn ring_points(&self, id: FaceId) -> impl ExactSizeIterator<Item = DVec3> + '_ {
        self.ring(id).iter().map(|&v| self.vertices[v as usize])
    }

    /// Returns the triangles of a face, as indices into `vertices`.
    pub fn face_triangles(&self, id: FaceId) -> &[[u32; 3]] {
        let range = &self.face(id).triangles;
        &self.triangles[range.start as usize..range.end as usize]
    }

    /// Returns whether one may see through a face in places.
    pub fn sees_through(&self, id: FaceId) -> bool {
        self.object(self.face(id).object).see_through
    }

    /// Returns the see-through surfaces: the faces through which one may see in places, each impostor's first face for all of
    /// its object.
    pub fn see_through_surfaces(&self) -> impl Iterator<Item = FaceId> {
        self.face_ids().filter(|face| self.sees_through(*face) && !self.is_replaced(*face))
    }

    /// Returns whether one may see through some face in places.
    pub fn has_see_through(&self) -> bool {
        self.objects.iter().any(|object| object.see_through)
    }

    /// Returns the same model in which one sees through these objects, and through no others.
    pub fn with_see_through(mut self, sees_through: impl Fn(&Object) -> bool) -> Self {
        for object in &mut self.objects {
            object.see_through = sees_through(object);
        }
        self
    }

    /// Returns the same model in which the faces that one sees through have no area. Faces keep their ids.
    pub fn without_see_through(&self) -> Self {
        let mut model = self.clone();
        for face in self.face_ids().filter(|face| self.sees_through(*face)) {
            let face = &mut model.faces[face.0 as usize];
            face.triangles = face.triangles.start..face.triangles.start;
        }
        model
    }

    /// Returns `object[index]`, the name of a face in messages.
    pub fn face_name(&self, id: FaceId) -> String {
        let face = self.face(id);
        format!("{}[{}]", self.object(face.object).name, face.index)
    }

    /// Returns the model without some of its objects. The others keep their order and their faces are renumbered.
    /// All vertices stay, whether a face still uses them or not.
    pub fn without(&self, leave_out: impl Fn(&Object) -> bool) -> Self {
        let mut model = Self { vertices: self.vertices.clone(), ..Self::default() };
        let mut numbered = vec![None; self.objects.len()];
        for (object, number) in
            self.objects.iter().zip(&mut numbered).filter(|(object, _)| !leave_out(object))
        {
            *number = Some(ObjectId(model.objects.len() as u32));
            model.objects.push(Object { faces: Vec::new(), ..object.clone() });
        }
        for id in self.face_ids() {
            let face = self.face(id);
            let Some(object) = numbered[face.object.0 as usize] else { continue };
            let (ring, triangles) = (model.ring_vertices.len() as u32, model.triangles.len() as u32);
            model.ring_vertices.extend(self.ring(id));
            model.triangles.extend(self.face_triangles(id));
            let ring = ring..model.ring_vertices.len() as u32;
            let triangles = triangles..model.triangles.len() as u32;
            model.objects[object.0 as usize].faces.push(FaceId(model.faces.len() as u32));
            model.faces.push(Face { object, ring, triangles, ..face.clone() });
        }
        model
    }

    /// Returns the model in another frame, planes included.
    pub fn transformed(&self, similarity: &Similarity) -> Self {
        let mut model = self.clone();
        for v in &mut model.vertices {
            *v = similarity.apply(*v);
        }
        for face in &mut model.faces {
            face.plane = Plane {
                normal: similarity.rotation * face.plane.normal,
                point: similarity.apply(face.plane.point),
            };
        }
        model
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::synthetic::closed_form;

    #[test]
    fn a_model_without_an_object_is_the_others_as_they_were() {
        let model = closed_form::two_quads().model;
        assert!(model.objects.len() >= 2);
        assert_eq!(model.without(|_| false), *model);
        for left_out in &model.objects {
            let rest = model.without(|object| object.name == left_out.name);
            assert!(rest.objects.iter().all(|object| object.name != left_out.name));
            let faces = |model: &Model| {
                let of_face = |id: FaceId| {
                    let corners: Vec<DVec3> = model.ring_points(id).collect();
                    let triangles = model.face_triangles(id).to_vec();
                    (model.face_name(id), model.face(id).index, corners, triangles)
                };
                model.face_ids().map(of_face).collect::<Vec<_>>()
            };
            let others = faces(&model).into_iter().filter(|face| {
                face.0.rsplit_once('[').expect("a face's name has an index").0 != left_out.name
            });
            assert_eq!(faces(&rest), others.collect::<Vec<_>>());
            let listed: Vec<FaceId> = rest.objects.iter().flat_map(|object| object.faces.clone()).collect();
            assert!(
                listed.iter().all(|id| rest.objects[rest.face(*id).object.0 as usize].faces.contains(id))
            );
        }
    }
}
