//! Tests of the stage and its package.

use super::*;
use crate::textured::tests::model;
use glam::DMat3;
use quadratura_base::geometry::{Pinhole, Pose};

fn camera() -> HandoverCamera {
    let camera = Pinhole { width: 1440, height: 2160, fx: 1500.0, fy: 1600.0, cx: 708.0, cy: 1530.0 };
    let pose = Pose { rotation: DMat3::from_rotation_x(1.2), translation: DVec3::new(0.5, -2.0, 9.0) };
    HandoverCamera { name: "08 portrait.jpg".into(), file: "../photos/08 portrait.jpg".into(), camera, pose }
}

#[test]
fn a_stage_has_meshes_with_polygons_and_subsets_and_cameras() {
    let files = usd(model(), &[camera()], "a test");
    let names: Vec<_> = files.iter().map(|file| file.name.as_str()).collect();
    assert_eq!(names, ["site.usda", "site_1.jpg", "site_2.png", "site.usdz"]);
    let text = String::from_utf8(files[0].bytes.clone()).unwrap();
    for line in [
        "def Mesh \"house__old\"",
        "custom string quadratura:name = \"house, old\"",
        "int[] faceVertexCounts = [4, 3, 4]",
        "int[] faceVertexIndices = [0, 1, 2, 3, 3, 2, 4, 0, 1, 2, 3]",
        "int[] indices = [0, 2]",
        "def Camera \"_08_portrait_jpg\"",
        "float horizontalApertureOffset = 0.3",
        "double3 origin = (1000, 2000, 0)",
        "float inputs:opacityThreshold = 0.5",
    ] {
        assert!(text.contains(line), "{line} is missing in {text}");
    }
    assert_eq!(text.matches('{').count(), text.matches('}').count());
}

#[test]
fn every_file_of_a_package_is_stored_at_a_multiple_of_64_bytes_and_the_stage_is_first() {
    let files = usd(model(), &[camera()], "a test");
    let package = &files.last().unwrap().bytes;
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(package)).unwrap();
    assert_eq!(archive.by_index(0).unwrap().name().unwrap(), "site.usda");
    for (index, file) in files[..3].iter().enumerate() {
        let entry = archive.by_index(index).unwrap();
        let start = entry.data_start().unwrap() as usize;
        assert_eq!(
            (start % usize::from(package::ALIGNMENT), entry.compression()),
            (0, zip::CompressionMethod::Stored)
        );
        assert_eq!(&package[start..start + file.bytes.len()], &file.bytes[..]);
    }
}

#[test]
fn a_concave_face_is_written_as_triangles_of_one_face() {
    let mut house = model();
    let face = &mut house.objects[1].faces[0];
    face.corners[2].uv = face.corners[0].uv.lerp(face.corners[2].uv, 0.3);
    let text = String::from_utf8(usd(house, &[], "a test")[0].bytes.clone()).unwrap();
    assert!(
        text.contains("int[] faceVertexCounts = [3, 3]") && text.contains("int[] primvars:face = [0, 0]")
    );
}

#[test]
fn names_of_primitives_are_identifiers_and_unique() {
    let mut names = PrimitiveNames::default();
    let found = ["a b", "a.b", "3", "", "é"].map(|name| names.name(name));
    assert_eq!(found, ["a_b", "a_b_2", "_3", "_", "__2"]);
    assert_eq!(quoted("a \"b\"\\\n"), "\"a \\\"b\\\"\\\\\\n\"");
}
