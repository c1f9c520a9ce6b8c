//! The model as meshes: polygons as they were modelled, with their holes.

use std::collections::BTreeSet;

use rustc_hash::FxHashMap;

use super::surfaces::Surfaces;
use crate::handover::origin::Placement;
use quadratura_base::scene::{FaceId, Model, Object};
use quadratura_handover::blender::scene::{SceneMaterial, SceneObject};
use quadratura_stacks::far_backdrops::FarBackdrops;

/// Returns the objects that do not turn, their materials, each once, and the number of faces without area, which are in no mesh.
pub fn objects(
    surfaces: &Surfaces,
    far: &FarBackdrops,
    placement: &Placement,
) -> (Vec<SceneObject>, Vec<SceneMaterial>, usize) {
    let model = &surfaces.site.model;
    let (mut materials, mut degenerate) = (Materials::default(), 0);
    let mut objects = Vec::new();
    for object in model.objects.iter().filter(|object| object.impostor.is_none()) {
        let mut mesh = Mesh::default();
        for &face in &object.faces {
            if model.face(face).triangles.is_empty() {
                degenerate += 1;
                continue;
            }
            mesh.add(model, face);
            let photos = surfaces.photos_of(face);
            mesh.best.push(surfaces.best_of(&photos).map_or(-1, |photo| photo as i64));
            mesh.materials.push(materials.number_of(surfaces.material(face, &photos)));
        }
        if !mesh.faces.is_empty() {
            objects.push(mesh.object(object, far.contains(&object.name), model, placement));
        }
    }
    (objects, materials.list, degenerate)
}

/// Materials, each once.
#[derive(Default)]
struct Materials {
    list: Vec<SceneMaterial>,
    /// By their text.
    numbers: FxHashMap<String, usize>,
}

impl Materials {
    fn number_of(&mut self, material: SceneMaterial) -> usize {
        let next = self.list.len();
        let number = *self.numbers.entry(format!("{material:?}")).or_insert(next);
        if number == next {
            self.list.push(material);
        }
        number
    }
}

/// The mesh of an object.
#[derive(Default)]
struct Mesh {
    /// The model's vertex of each vertex.
    vertices: Vec<u32>,
    numbers: FxHashMap<u32, u32>,
    faces: Vec<Vec<u32>>,
    /// The vertices of each face in the model, sorted: Blender takes two faces with the same ones for one.
    seen: BTreeSet<Vec<u32>>,
    indices: Vec<u32>,
    materials: Vec<usize>,
    best: Vec<i64>,
}

impl Mesh {
    /// Adds a face. Where its outline visits a vertex twice, along a bridge to a hole, the second visit gets a vertex of its own in
    /// the same place; Blender forbids the same one.
    fn add(&mut self, model: &Model, face: FaceId) {
        let ring = model.ring(face);
        let mut sorted = ring.to_vec();
        sorted.sort_unstable();
        let is_new = self.seen.insert(sorted);
        let mut visited = BTreeSet::new();
        let mut outline = Vec::with_capacity(ring.len());
        for &vertex in ring {
            let shared = is_new && visited.insert(vertex);
            let next = self.vertices.len() as u32;
            let number = if shared { *self.numbers.entry(vertex).or_insert(next) } else { next };
            if number == next {
                self.vertices.push(vertex);
            }
            outline.push(number);
        }
        self.faces.push(outline);
        self.indices.push(model.face(face).index.0);
    }

    fn object(self, object: &Object, hidden: bool, model: &Model, placement: &Placement) -> SceneObject {
        let position = |&vertex: &u32| placement.point(model.vertices[vertex as usize]).to_array();
        SceneObject {
            name: object.name.clone(),
            hidden,
            vertices: self.vertices.iter().map(position).collect(),
            faces: self.faces,
            indices: self.indices,
            materials: self.materials,
            best: self.best,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use quadratura_base::scene::synthetic::Modeller;

    #[test]
    fn a_second_visit_of_a_vertex_and_a_second_face_of_the_same_ones_get_their_own() {
        let mut m = Modeller::new();
        m.object("wall").quad(DVec3::ZERO, DVec3::X, DVec3::Z);
        let mut model = (*m.finish()).clone();
        let mut mesh = Mesh::default();
        mesh.add(&model, FaceId(0));
        mesh.add(&model, FaceId(0));
        assert_eq!(
            mesh.faces,
            [[0, 1, 2, 3], [4, 5, 6, 7]],
            "Blender would remove the second of two equal faces"
        );
        // An outline that runs along a bridge.
        model.ring_vertices = vec![0, 1, 2, 1, 3];
        model.faces[0].ring = 0..5;
        let mut mesh = Mesh::default();
        mesh.add(&model, FaceId(0));
        assert_eq!((&mesh.faces[0][..], &mesh.vertices[..]), (&[0, 1, 2, 3, 4][..], &[0, 1, 2, 1, 3][..]));
    }
}
