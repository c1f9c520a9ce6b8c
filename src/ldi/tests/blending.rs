//! Several layered depth images, blended in one picture.

use glam::DVec3;

use super::{of_model, step_aside};
use crate::{BlendSource, DepthPixelOrigin, Ldi, SplatKind, WarpOptions, warp, warp_blended};
use quadratura_base::geometry::Pose;
use quadratura_base::scene::synthetic::{Rng, random};
use quadratura_base::task::Task;
use quadratura_view::optics::{Optics, ViewLens};
use quadratura_view::{Picture, Shot};

fn plain(ldi: &Ldi) -> BlendSource<'_> {
    BlendSource { ldi, exposure: [0.0; 3], optics: Optics::default(), agreement: None }
}

fn blended(sources: &[BlendSource], shot: &Shot) -> Picture {
    let options = WarpOptions { level: Some(0), ..WarpOptions::default() };
    warp_blended(sources, shot, &ViewLens::default(), &options, &Task::silent()).unwrap().picture
}

/// Returns images of one scene from several cameras, the first one's pose, and what they look at.
fn images(seed: u64, count: u32) -> (Vec<Ldi>, DVec3) {
    // So fine that depths on the ground change little from pixel to pixel but at the horizon.
    let scene = random::boxes(seed, 6).resized(480);
    let eye = scene.pose.center_in_world();
    let middle = scene.model.vertices.iter().sum::<DVec3>() / scene.model.vertices.len() as f64;
    let mut rng = Rng::new(seed);
    let colour = |face: usize, point: DVec3| {
        let wave = |rate: f64| (127.0 + 90.0 * (rate * (point.x + 2.0 * point.y - point.z)).sin()) as u8;
        [wave(0.7), wave(0.3), (40 * face % 200) as u8, 255]
    };
    let mut pose = |i: u32| match i {
        0 => scene.pose,
        _ => step_aside(&mut rng, eye, middle, 2.0),
    };
    let images = (0..count).map(|i| of_model(&scene.model, scene.camera, pose(i), colour)).collect();
    (images, middle)
}

/// Returns the mean absolute difference of two pictures where both are opaque, and the share of such pixels.
fn difference(a: &Picture, b: &Picture) -> (f64, f64) {
    let opaque = |pixel: &[u8; 4]| pixel[3] >= 250;
    let both = a.pixels().iter().zip(b.pixels()).filter(|(a, b)| opaque(a) && opaque(b));
    let off: Vec<f64> =
        both.map(|(a, b)| (0..3).map(|c| f64::from(a[c].abs_diff(b[c]))).sum::<f64>() / 3.0).collect();
    (off.iter().sum::<f64>() / off.len().max(1) as f64, off.len() as f64 / a.pixels().len() as f64)
}

#[test]
fn one_image_alone_and_copies_of_it_are_what_its_warp_shows() {
    let (images, middle) = images(51, 1);
    let ldi = &images[0];
    let mut rng = Rng::new(51);
    for _ in 0..3 {
        let pose = step_aside(&mut rng, ldi.pose.center_in_world(), middle, 2.0);
        let shot = Shot { backs: false, ..Shot::new(ldi.camera, pose) };
        let options = WarpOptions { splat: SplatKind::Sums, level: Some(0), ..WarpOptions::default() };
        let alone = warp(ldi, &shot, &options, &Task::silent()).unwrap().picture;
        for copies in [1, 3] {
            let sources = vec![plain(ldi); copies];
            let found = blended(&sources, &shot);
            // Surfaces within 2 % of each other are one in a blend, and layers below a quarter of opacity add up in another
            // order: what is between two surfaces may differ.
            let (off, share) = difference(&found, &alone);
            assert!(off < 0.2 && share > 0.2, "{off} {share}");
        }
    }
}

#[test]
fn in_the_camera_of_one_image_the_blend_is_that_image() {
    let (images, _) = images(52, 4);
    let sources: Vec<BlendSource> = images.iter().map(plain).collect();
    let own = &images[1];
    let shot = Shot { backs: false, ..Shot::new(own.camera, own.pose) };
    let alone = blended(&sources[1..2], &shot);
    let (off, share) = difference(&blended(&sources, &shot), &alone);
    // The angle to its own camera is 0, so that others have a millionth of the weight; other images' splats reach beyond
    // outlines where this one cannot contradict them, because surfaces before it hide what is behind.
    assert!(off < 0.5 && share > 0.3, "{off} {share}");
}

#[test]
fn more_images_predict_a_new_view_better_and_show_more_of_it() {
    for seed in [53, 54] {
        let (images, _) = images(seed, 5);
        let (truth, others) = images.split_last().unwrap();
        let shot = Shot { backs: false, ..Shot::new(truth.camera, truth.pose) };
        let expected = blended(&[plain(truth)], &shot);
        let depth_images: Vec<Ldi> = others.iter().map(Ldi::depth_image).collect();
        let sources: Vec<BlendSource> = depth_images.iter().map(plain).collect();
        let (_, one) = difference(&blended(&sources[..1], &shot), &expected);
        let (off, all) = difference(&blended(&sources, &shot), &expected);
        assert!(all > one, "{one} {all}");
        assert!(off < 6.0, "{off}");
    }
}

#[test]
fn what_was_filled_in_counts_only_where_no_camera_saw_it() {
    let (mut images, middle) = images(55, 2);
    let red = [255, 0, 0, 255];
    for level in &mut images[1].levels {
        level.colours.fill(red);
        level.splats.iter_mut().for_each(|splat| *splat = crate::Splat::new(0, DepthPixelOrigin::Invented));
    }
    let mut rng = Rng::new(55);
    let pose: Pose = step_aside(&mut rng, images[0].pose.center_in_world(), middle, 1.0);
    let shot = Shot { backs: false, ..Shot::new(images[0].camera, pose) };
    let seen = blended(&[plain(&images[0])], &shot);
    let both = blended(&[plain(&images[0]), plain(&images[1])], &shot);
    let is_red = |pixel: &[u8; 4]| pixel[0] > 240 && pixel[1] < 15;
    let (mut kept, mut filled) = (0, 0);
    for (a, b) in seen.pixels().iter().zip(both.pixels()) {
        match a[3] {
            255 => kept += usize::from(!is_red(b)),
            0 => filled += usize::from(is_red(b)),
            _ => (),
        }
    }
    let opaque = seen.pixels().iter().filter(|pixel| pixel[3] == 255).count();
    // The splats of the other image reach a pixel beyond outlines.
    assert!(kept as f64 > 0.97 * opaque as f64, "{kept} of {opaque}");
    assert!(filled > 0);
}

#[test]
fn every_number_of_threads_gives_the_same_picture() {
    let (images, middle) = images(56, 3);
    let sources: Vec<BlendSource> = images.iter().map(plain).collect();
    let mut rng = Rng::new(56);
    let pose = step_aside(&mut rng, images[0].pose.center_in_world(), middle, 1.0);
    let shot = Shot { backs: false, ..Shot::new(images[0].camera, pose) };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| blended(&sources, &shot))
    };
    let one = with(1);
    assert!([2, 3, 16].into_iter().all(|threads| with(threads) == one));
}

#[test]
fn vignetting_and_exposure_of_images_do_not_show() {
    let (mut images, middle) = images(57, 1);
    let ldi = images.remove(0);
    let optics = Optics { falloff: [-0.4, 0.0], offset: 0.0 };
    let mut darker = ldi.clone();
    let level = &mut darker.levels[0];
    let half_diagonal = 0.25 * (f64::from(ldi.camera.width).powi(2) + f64::from(ldi.camera.height).powi(2));
    for y in 0..ldi.camera.height {
        for i in level.row(y) {
            let x = f64::from(level.columns[i]) + 0.5 - ldi.camera.cx;
            let r2 = (x.powi(2) + (f64::from(y) + 0.5 - ldi.camera.cy).powi(2)) / half_diagonal;
            let factor = optics.log_light(r2).exp() * 0.8;
            let bytes = quadratura_base::scene::light::bytes_of_light_times(factor);
            (0..3).for_each(|c| level.colours[i][c] = bytes[usize::from(level.colours[i][c])]);
        }
    }
    let mut rng = Rng::new(57);
    let pose = step_aside(&mut rng, ldi.pose.center_in_world(), middle, 1.0);
    let shot = Shot { backs: false, ..Shot::new(ldi.camera, pose) };
    let source = BlendSource { exposure: [(1.0f64 / 0.8).ln(); 3], optics, ..plain(&darker) };
    let (off, share) = difference(&blended(&[source], &shot), &blended(&[plain(&ldi)], &shot));
    // Stored values were rounded once more, and dark ones lie far apart.
    assert!(off < 1.0 && share > 0.3, "{off} {share}");
}
