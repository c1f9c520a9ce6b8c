//! The castle's two model files say the same.

use std::path::Path;

use crate::common::castle;
use glam::DVec3;
use quadratura::task::Task;
use quadratura::testing::import::models::read_model;
use quadratura::testing::scene::{FaceId, Model};

fn read(path: &Path) -> Model {
    let (model, notes) = read_model(path, &Task::silent()).unwrap();
    assert!(notes.is_empty(), "{notes:?}");
    model
}

/// The ring, beginning at its point with the least coordinates.
fn from_least(model: &Model, id: FaceId) -> Vec<DVec3> {
    let mut ring: Vec<DVec3> = model.ring_points(id).collect();
    // The glTF file rounds to 32 bits.
    let key = |p: &DVec3| p.to_array().map(|x| (x * 1e3).round() as i64);
    let least = (0..ring.len()).min_by_key(|&i| key(&ring[i])).unwrap();
    ring.rotate_left(least);
    ring
}

#[test]
fn obj_and_gltf_give_the_same_objects_and_faces() {
    let Some(folder) = castle() else { return };
    let (obj, gltf) = (read(&folder.join("castle.obj")), read(&folder.join("castle.gltf")));
    assert_eq!((obj.faces.len(), obj.objects.len()), (600, 78));
    assert_eq!(obj.objects, gltf.objects);
    for id in obj.face_ids() {
        let (a, b) = (from_least(&obj, id), from_least(&gltf, id));
        assert_eq!(a.len(), b.len(), "{}", obj.face_name(id));
        assert!(a.iter().zip(&b).all(|(p, q)| p.distance(*q) < 1e-5), "{}", obj.face_name(id));
        assert!(obj.face(id).planar && gltf.face(id).planar);
        assert!(obj.face(id).plane.normal.dot(gltf.face(id).plane.normal) > 0.999_999);
        assert_eq!(obj.face_triangles(id).len(), obj.ring(id).len() - 2);
    }
}
