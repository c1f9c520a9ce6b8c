//! A picture in linear light is the same picture with more precision, and its depths are those of the model.

use glam::DVec3;
use quadratura::task::Task;
use quadratura::testing::projection::relief::Relief;
use quadratura::testing::projection::{Renders, shown_face};
use quadratura::testing::view::{Quality, Shot};

use crate::bench::{Bench, apart};

/// A view beside a photo's camera, small.
fn view(bench: &Bench) -> Shot {
    let mut shot = bench.own(0);
    shot.pose.translation += DVec3::new(0.4, -0.2, 0.3);
    let scale = 240.0 / f64::from(shot.camera.width);
    (shot.camera.fx, shot.camera.fy) = (scale * shot.camera.fx, scale * shot.camera.fy);
    (shot.camera.cx, shot.camera.cy) = (scale * shot.camera.cx, scale * shot.camera.cy);
    (shot.camera.width, shot.camera.height) = (240, 160);
    shot
}

#[test]
fn a_picture_in_linear_light_is_the_picture_of_8_bits_and_finer() {
    let Some(bench) = Bench::piazza(&["01", "02"]) else { return };
    let mut renderer = bench.renderer(&Relief::default());
    for quality in [Quality::Preview, Quality::Final] {
        let shot = Shot { quality, ..view(&bench) };
        let picture = renderer.picture(&shot, &Task::silent()).unwrap();
        let linear = renderer.linear_picture(&shot, &Task::silent()).unwrap();
        assert_eq!((linear.width, linear.height), (picture.width, picture.height));
        let same = linear.picture();
        let pixels = picture.pixels().iter().zip(same.pixels());
        // Samples of 8 bits are rounded before they are joined; where little is textured, that is divided by alpha.
        let far =
            pixels.filter(|(a, b)| a[3] > 200 && (apart(*a, *b) > 2 || a[3].abs_diff(b[3]) > 2)).count();
        assert!(far * 200 < picture.pixels().len(), "{quality:?}: {far} pixels differ by more than 2");
        let values: std::collections::BTreeSet<u32> =
            linear.rgba.iter().filter(|pixel| pixel[3] > 0.99).map(|pixel| pixel[1].to_bits()).collect();
        assert!(values.len() > 400, "{quality:?}: {} different greens", values.len());
        // The renderer draws the view of 8 bits as before.
        assert_eq!(renderer.picture(&shot, &Task::silent()).unwrap(), picture);
    }
}

#[test]
fn depths_are_those_of_the_planes_that_are_seen_and_infinite_where_nothing_is() {
    let Some(bench) = Bench::piazza(&["01", "02"]) else { return };
    let mut renderer = bench.renderer(&Relief::default());
    let shot = view(&bench);
    let faces = renderer.seen_faces(&shot, &Task::silent()).unwrap();
    let depths = renderer.depths(&shot, &Task::silent()).unwrap().expect("the device has depths");
    let rows = shot.pose.rotation.transpose();
    let [right, down, forward] = [rows.x_axis, rows.y_axis, rows.z_axis];
    let (camera, model) = (&shot.camera, &bench.site.model);
    let (mut nothing, mut seen) = (0, 0);
    for (px, (face, depth)) in faces.iter().zip(&depths).enumerate() {
        let Some(face) = shown_face(*face) else {
            assert_eq!(*depth, f32::INFINITY);
            nothing += 1;
            continue;
        };
        let (x, y) = ((px % 240) as f64 + 0.5, (px / 240) as f64 + 0.5);
        let ray = forward + right * ((x - camera.cx) / camera.fx) + down * ((y - camera.cy) / camera.fy);
        let plane = &model.face(face).plane;
        let expected = plane.normal.dot(plane.point - shot.viewpoint()) / plane.normal.dot(ray);
        let error = (f64::from(*depth) - expected).abs() / expected;
        // Of faces that are equally near, another one may be named.
        assert!(error < 2e-3, "pixel {px}: {depth} instead of {expected}");
        seen += 1;
    }
    assert!(nothing > 1000 && seen > 10_000, "{nothing} and {seen} pixels");
}
