//! Tests of the cloud of points.

use glam::{DMat3, DVec3};

use super::*;
use crate::{DepthPixel, LdiKind, LdiReport, LdiSurface, Splat};
use quadratura_base::geometry::{Pinhole, Pose};

/// A point as another program reads it.
#[derive(Debug, Clone, PartialEq)]
struct Point {
    at: DVec3,
    colour: [u8; 4],
    normal: [f32; 3],
    layer: u16,
    surface: u16,
}

fn points(bytes: &[u8]) -> (String, Vec<Point>) {
    let end = b"end_header\n";
    let start = bytes.windows(end.len()).position(|window| window == end).unwrap() + end.len();
    let (header, body) = bytes.split_at(start);
    assert_eq!(body.len() % POINT, 0);
    let f64_at = |point: &[u8], at: usize| f64::from_le_bytes(point[at..at + 8].try_into().unwrap());
    let f32_at = |point: &[u8], at: usize| f32::from_le_bytes(point[at..at + 4].try_into().unwrap());
    let u16_at = |point: &[u8], at: usize| u16::from_le_bytes(point[at..at + 2].try_into().unwrap());
    let point = |point: &[u8]| Point {
        at: DVec3::new(f64_at(point, 0), f64_at(point, 8), f64_at(point, 16)),
        colour: point[24..28].try_into().unwrap(),
        normal: [f32_at(point, 28), f32_at(point, 32), f32_at(point, 36)],
        layer: u16_at(point, 40),
        surface: u16_at(point, 42),
    };
    (String::from_utf8(header.to_vec()).unwrap(), body.chunks(POINT).map(point).collect())
}

/// Returns an image of a wall at depth 4 before an unknown surface at depth 8 and the sky, far from the world's origin.
fn wall() -> Ldi {
    let camera = Pinhole { width: 3, height: 2, fx: 2.0, fy: 2.0, cx: 1.5, cy: 1.0 };
    let pixel = |inverse_depth, surface| DepthPixel {
        inverse_depth,
        colour: [1, 2, 3, 255],
        surface,
        splat: Splat(0),
    };
    let rows = [
        vec![(1, pixel(0.25, 1)), (1, pixel(0.125, 0)), (1, pixel(0.0, 2))],
        vec![(0, pixel(0.0, 2)), (2, pixel(0.25, 1))],
    ];
    let rotation = DMat3::from_rotation_y(0.3) * DMat3::from_rotation_x(-1.2);
    let centre = DVec3::new(500_000.25, 5_000_000.5, 100.0);
    let surface = |nu, object: &str| LdiSurface { nu, object: object.to_owned(), face: None };
    Ldi {
        kind: LdiKind::Depth,
        inputs: String::new(),
        camera,
        pose: Pose { rotation, translation: -(rotation * centre) },
        photo_rect: None,
        gain: [0.0; 3],
        surfaces: vec![surface(DVec3::new(0.0, 0.0, 0.25), "wall"), surface(DVec3::ZERO, "sky")],
        sources: vec!["a\nelement vertex 9".to_owned()],
        levels: vec![ResolutionLevel::of_rows(camera, rows)],
        report: LdiReport::default(),
    }
}

#[test]
fn points_are_where_their_depth_pixels_are_and_the_sky_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let ldi = wall();
    let written = write_ply(&folder.path().join("new/wall.ply"), &ldi).unwrap();
    let bytes = std::fs::read(&written.file).unwrap();
    assert_eq!((written.points, written.at_infinity, written.bytes), (3, 2, bytes.len() as u64));
    let (header, points) = points(&bytes);
    assert!(
        header.contains("\nelement vertex 3\n") && header.contains("\ncomment 2 depth pixels"),
        "{header}"
    );
    assert!(header.contains("\ncomment source a element vertex 9\n"), "a name is no header: {header}");
    let expected = [(1.5, 0.5, 4.0, 0, 1), (1.5, 0.5, 8.0, 1, 0), (2.5, 1.5, 4.0, 0, 1)];
    assert_eq!(points.len(), expected.len());
    for (point, (x, y, depth, layer, surface)) in points.iter().zip(expected) {
        let in_camera = ldi.pose.camera_from_world(point.at);
        let image = ldi.camera.image_from_camera(in_camera).unwrap();
        // Of 5,000,000 units the last bit of 64 is 1e-9.
        assert!(image.distance(DVec2::new(x, y)) < 1e-7 && (in_camera.z - depth).abs() < 1e-7, "{point:?}");
        assert_eq!((point.colour, point.layer, point.surface), ([1, 2, 3, 255], layer, surface));
        let normal = DVec3::from_array(point.normal.map(f64::from));
        let expected = if surface == 0 { DVec3::ZERO } else { ldi.pose.rotation.transpose() * -DVec3::Z };
        // The bits of 32.
        assert!(normal.distance(expected) < 1e-6, "{point:?}");
    }
}

#[test]
fn an_unchanged_file_is_replaced_and_all_others_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("wall.ply");
    let ldi = wall();
    let first = write_ply(&file, &ldi).unwrap();
    let bytes = std::fs::read(&file).unwrap();
    assert_eq!(write_ply(&file, &ldi).unwrap(), first);
    assert_eq!(std::fs::read(&file).unwrap(), bytes, "the same content gives the same bytes");
    for at in [0, 60, bytes.len() - 1] {
        let mut changed = bytes.clone();
        changed[at] ^= 1;
        std::fs::write(&file, &changed).unwrap();
        let second = write_ply(&file, &ldi).unwrap();
        assert_eq!((second.file, second.spared), (folder.path().join("wall-2.ply"), vec![file.clone()]));
        assert_eq!(std::fs::read(&file).unwrap(), changed);
    }
}
