//! Checks that the scenes are as documented.

use super::*;
use crate::scene::FaceId;

fn every_kind() -> Vec<Scene> {
    let mut scenes = closed_form::all();
    scenes.extend((0..20).map(|seed| random::soup(seed, 12)));
    scenes.extend((0..20).map(|seed| random::boxes(seed, 5)));
    scenes.extend([large::street(200), large::town(400)]);
    scenes
}

fn each_face(mut look: impl FnMut(&Scene, FaceId)) {
    for scene in every_kind() {
        scene.model.face_ids().for_each(|face| look(&scene, face));
    }
}

fn area_vector(scene: &Scene, [a, b, c]: [u32; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(|v| scene.model.vertices[v as usize]);
    0.5 * (b - a).cross(c - a)
}

#[test]
fn triangles_fill_their_outline_and_are_wound_like_it() {
    each_face(|scene, id| {
        let face = scene.model.face(id);
        let areas = scene.model.face_triangles(id).iter().map(|&t| area_vector(scene, t));
        let areas: Vec<DVec3> = areas.collect();
        let ring: Vec<DVec3> = scene.model.ring_points(id).collect();
        let outline: DVec3 =
            (2..ring.len()).map(|i| 0.5 * (ring[i - 1] - ring[0]).cross(ring[i] - ring[0])).sum();
        let filled: DVec3 = areas.iter().sum();
        let name = || format!("{} of {}", scene.model.face_name(id), scene.name);
        assert!((filled - outline).length() <= 1e-6 * outline.length(), "{}", name());
        assert!(areas.iter().all(|area| area.dot(face.plane.normal) > 0.0), "{}", name());
    });
}

#[test]
fn corners_of_planar_faces_lie_in_their_plane() {
    each_face(|scene, id| {
        let face = scene.model.face(id);
        let off = scene.model.ring_points(id).map(|p| face.plane.signed_distance(p).abs());
        let farthest = off.fold(0.0, f64::max);
        assert_eq!(face.planar, farthest < 1e-6, "{} of {}", scene.model.face_name(id), scene.name);
    });
}

#[test]
fn objects_and_faces_name_each_other() {
    for scene in every_kind() {
        let model = &scene.model;
        assert_eq!(model.objects.iter().map(|o| o.faces.len()).sum::<usize>(), model.faces.len());
        for id in model.face_ids() {
            let face = model.face(id);
            assert_eq!(model.object(face.object).faces[face.index.index()], id, "{}", scene.name);
        }
    }
}

#[test]
fn poses_are_rigid_and_look_where_they_should() {
    for scene in every_kind() {
        let rotation = scene.pose.rotation;
        assert!((rotation * rotation.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-12), "{}", scene.name);
        assert!((rotation.determinant() - 1.0).abs() < 1e-12, "{}", scene.name);
    }
    let pose = look_at(DVec3::new(3.0, 1.0, 2.0), DVec3::new(3.0, 5.0, 2.0));
    assert!(pose.camera_from_world(DVec3::new(3.0, 5.0, 2.0)).abs_diff_eq(DVec3::Z * 4.0, 1e-12));
    assert!(pose.camera_from_world(DVec3::new(4.0, 5.0, 3.0)).abs_diff_eq(DVec3::new(1.0, -1.0, 4.0), 1e-12));
}

#[test]
fn a_seed_gives_one_scene() {
    assert_eq!(random::soup(7, 30), random::soup(7, 30));
    assert_ne!(random::soup(7, 30).model, random::soup(8, 30).model);
    assert_eq!(random::boxes(7, 3), random::boxes(7, 3));
}

#[test]
fn dice_throw_the_published_sequence() {
    // The first outputs of SplitMix64 for seed 1234567, as in its reference implementation.
    let mut rng = Rng::new(1_234_567);
    let thrown = [rng.bits(), rng.bits(), rng.bits()];
    assert_eq!(thrown, [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]);
}

#[test]
fn large_scenes_have_about_as_many_faces_as_were_asked_for() {
    assert_eq!(large::street(1000).model.faces.len(), 993);
    assert_eq!(large::town(100_000).model.faces.len(), 100_001);
}
