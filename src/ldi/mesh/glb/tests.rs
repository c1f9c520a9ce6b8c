//! GLB files: read back by a library for them, and never written over what others changed.

use glam::{DMat3, DVec3};

use super::{GlbContent, glb, is_unchanged, place_of_glb, write_glb};
use crate::segments::{Atlas, Segments, TexturedPart, Vertex};
use quadratura_base::geometry::{Pinhole, Pose};

const CAMERA: Pinhole = Pinhole { width: 16, height: 8, fx: 10.0, fy: 10.0, cx: 8.0, cy: 4.0 };

/// A square at depth 2 in an opaque atlas, and one infinitely far in another.
fn two_squares() -> Segments {
    let vertices = |inverse_depth: f32| {
        [[0, 0], [8, 0], [8, 8], [0, 8]].map(|[x, y]| Vertex { x, y, inverse_depth }).to_vec()
    };
    let part = |number: usize, inverse_depth| TexturedPart {
        segment: number as u32,
        atlas: number,
        origin: [-2, -2],
        at: [0, 0],
        size: [16, 16],
        vertices: vertices(inverse_depth),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let atlas = |opaque| Atlas {
        first: true,
        opaque,
        width: 16,
        height: 16,
        rgb: vec![90; 3 * 256],
        opacity: (0..256u32).map(|i| if i % 16 < 12 { 255 } else { 0 }).collect(),
    };
    Segments {
        count: 2,
        parts: vec![part(0, 0.5), part(1, 0.0)],
        atlases: vec![atlas(true), atlas(false)],
        reach: 0.3,
        parallax: 0.5,
    }
}

fn mesh<'a>(segments: &'a Segments, pose: &'a Pose) -> GlbContent<'a> {
    GlbContent { name: "left", camera: &CAMERA, pose, segments, quality: 90 }
}

#[test]
fn a_file_is_read_back_with_its_meshes_pictures_and_camera() {
    let pose = Pose { rotation: DMat3::IDENTITY, translation: DVec3::new(1.0, 2.0, 3.0) };
    let segments = two_squares();
    let bytes = glb(&mesh(&segments, &pose));
    let file = gltf::Gltf::from_slice(&bytes).unwrap();
    let binary = file.blob.clone().unwrap();
    let primitives: Vec<_> = file.meshes().next().unwrap().primitives().collect();
    assert_eq!(primitives.len(), 2);
    let positions = |i: usize| {
        let reader = primitives[i].reader(|_| Some(&binary));
        reader.read_positions().unwrap().map(DVec3::from_array_f32).collect::<Vec<_>>()
    };
    // The frame's upper left corner at depth 2: (0 - 8) / 10 * 2 to the left, 4 / 10 * 2 up, 2 ahead along -z.
    assert!((positions(0)[0] - DVec3::new(-1.6, 0.8, -2.0)).length() < 1e-6, "{:?}", positions(0));
    let sky = mesh(&segments, &pose).sky();
    assert!(positions(1).iter().all(|position| (position.length() - sky).abs() < 1e-5 && sky > 2.0));
    let reader = primitives[0].reader(|_| Some(&binary));
    let texels: Vec<_> = reader.read_tex_coords(0).unwrap().into_f32().collect();
    assert_eq!((texels[0], texels[2]), ([0.125, 0.125], [0.625, 0.625]));
    // Counter-clockwise from the camera: the normal points to it, along +z.
    let corners: Vec<DVec3> =
        reader.read_indices().unwrap().into_u32().map(|i| positions(0)[i as usize]).collect();
    assert!((corners[1] - corners[0]).cross(corners[2] - corners[0]).z > 0.0);
    let modes: Vec<_> = file.materials().map(|material| material.alpha_mode()).collect();
    assert_eq!(modes, [gltf::material::AlphaMode::Opaque, gltf::material::AlphaMode::Mask]);
    for image in file.images() {
        let gltf::image::Source::View { view, .. } = image.source() else { panic!("it is in the file") };
        let bytes = &binary[view.offset()..view.offset() + view.length()];
        assert_eq!(image::load_from_memory(bytes).unwrap().width(), 16);
    }
    let camera = file.cameras().next().unwrap();
    let gltf::camera::Projection::Perspective(camera) = camera.projection() else {
        panic!("the reference camera is a perspective one")
    };
    assert!((f64::from(camera.yfov()) - 2.0 * 0.4f64.atan()).abs() < 1e-6);
}

trait FromF32 {
    fn from_array_f32(values: [f32; 3]) -> DVec3;
}

impl FromF32 for DVec3 {
    fn from_array_f32(values: [f32; 3]) -> DVec3 {
        DVec3::from_array(values.map(f64::from))
    }
}

#[test]
fn a_file_that_was_changed_stays_and_an_unchanged_one_is_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("left.glb");
    let pose = Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO };
    let segments = two_squares();
    write_glb(&file, &mesh(&segments, &pose)).unwrap();
    assert_eq!(place_of_glb(&file), (file.clone(), vec![]));
    let mut bytes = std::fs::read(&file).unwrap();
    assert!(is_unchanged(bytes.clone()));
    let last = bytes.len() - 9;
    bytes[last] ^= 1;
    std::fs::write(&file, bytes).unwrap();
    assert_eq!(place_of_glb(&file), (folder.path().join("left-2.glb"), vec![file]));
}
