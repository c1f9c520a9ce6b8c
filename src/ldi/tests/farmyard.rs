//! The published scene: three of ten cameras, 320 x 320 pixels, become one layered depth image of at most ten layers.

use std::collections::BTreeMap;

use glam::DVec3;

use super::of_model;
use crate::combine::{Combining, CommonCamera, SourceImage, combine};
use crate::merge::Merging;
use crate::{Ldi, LdiKind};
use quadratura_base::scene::synthetic::farmyard;
use quadratura_base::task::Task;

/// Returns the depth images of cameras this far apart, in degrees.
fn depth_images(count: u32, degrees: f64) -> Vec<Ldi> {
    let model = farmyard::model();
    let colour = |face: usize, point: DVec3| {
        let waves = (point * 3.0).element_sum().sin() * 60.0 + 120.0;
        [waves as u8, (face * 47 % 256) as u8, (face * 91 % 256) as u8, 255]
    };
    farmyard::cameras(count, degrees.to_radians())
        .into_iter()
        .map(|(camera, pose)| of_model(&model, camera, pose, colour).depth_image())
        .collect()
}

/// Combines each three neighbours into the camera of the middle one; returns the mean depth complexity, the largest number
/// of layers and the samples dropped.
fn combined(images: &[Ldi], combining: &Combining) -> (f64, u32, u64) {
    let made: Vec<Ldi> = images
        .windows(3)
        .map(|three| {
            let [left, own, right] = three else { unreachable!("windows of three") };
            let frame = CommonCamera::new(own.camera, own.pose, own.gain, 0.0, true);
            let source = |ldi, is_own| SourceImage { ldi, is_own };
            let sources = [source(own, true), source(left, false), source(right, false)];
            let task = Task::silent();
            combine(LdiKind::Photos, &frame, &sources, combining, BTreeMap::new(), &task).unwrap()
        })
        .collect();
    let mean = made.iter().map(|ldi| ldi.report.depth_complexity).sum::<f64>() / made.len() as f64;
    let layers = made.iter().map(|ldi| ldi.report.layers).max().unwrap();
    (mean, layers, made.iter().map(|ldi| ldi.report.dropped).sum())
}

#[test]
fn depth_complexity_grows_with_the_angle_between_cameras() {
    let published = Combining { published: true, ..Combining::default() };
    let mut curve = Vec::new();
    // The whole curve, up to 90 degrees, is in `docs/method.md`.
    for degrees in [1.0, 10.0, 25.0] {
        let images = depth_images(10, degrees);
        let (as_published, layers, dropped) = combined(&images, &published);
        let (ours, our_layers, our_dropped) = combined(&images, &Combining::default());
        eprintln!(
            "{degrees} degrees: published {as_published:.3} ({layers} layers, {dropped} dropped), \
             here {ours:.3} ({our_layers}, {our_dropped})"
        );
        assert!(layers <= 10 && our_layers <= 10);
        curve.push((as_published, ours));
    }
    assert!(curve.is_sorted_by(|a, b| a.0 < b.0 && a.1 < b.1), "{curve:?}");
    // The paper has 1.24 on average, of a scene with more details and for angles that it does not say: `docs/method.md`.
    assert!(
        curve.iter().all(|(published, ours)| (1.0..1.24).contains(published) && (1.0..1.24).contains(ours))
    );
}

#[test]
fn slopes_keep_ground_that_is_seen_along_it_in_few_layers() {
    let images = depth_images(3, 10.0);
    let with = |slopes: bool| {
        let merging = Merging { slopes, epsilon: 0.001, ..Merging::default() };
        combined(&images, &Combining { merging, published: false })
    };
    let ((complexity, ..), (without, ..)) = (with(true), with(false));
    assert!(complexity < without, "{complexity} {without}");
}
