//! Pictures made of layered depth images.

use glam::{DMat3, DVec3};

use super::super::warp::{Warped, warp};
use super::{of_model, step_aside, tower};
use crate::{Ldi, SplatKind, WarpOptions};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::synthetic::{Modeller, Rng, camera_is_world, centred, closed_form, random};
use quadratura_base::task::Task;
use quadratura_view::{Picture, Quality, Shot};

const SPLATS: [SplatKind; 3] = [SplatKind::Pixel, SplatKind::Over, SplatKind::Sums];

fn of_splat(splat: SplatKind) -> WarpOptions {
    WarpOptions { splat, level: Some(0), ..WarpOptions::default() }
}

fn picture(ldi: &Ldi, shot: &Shot, options: &WarpOptions) -> Warped {
    warp(ldi, shot, options, &Task::silent()).unwrap()
}

/// A colour that changes from point to point.
fn patterned(face: usize, point: DVec3) -> [u8; 4] {
    let wave = |rate: f64| (127.0 + 100.0 * (rate * (point.x + 2.0 * point.y - point.z)).sin()) as u8;
    [wave(9.0), wave(4.0), (40 * face % 256) as u8, 255]
}

fn scene_of(seed: u64) -> (Ldi, DVec3, DVec3) {
    let scene = random::boxes(seed, 6).resized(200);
    let eye = scene.pose.center_in_world();
    let middle = scene.model.vertices.iter().sum::<DVec3>() / scene.model.vertices.len() as f64;
    (of_model(&scene.model, scene.camera, scene.pose, patterned), eye, middle)
}

#[test]
fn in_its_own_camera_single_pixels_give_the_first_layer_and_sums_are_within_1() {
    for seed in 0..4 {
        let (ldi, ..) = scene_of(seed);
        let level = &ldi.levels[0];
        let shot = Shot::new(ldi.camera, ldi.pose);
        for (splat, most) in [(SplatKind::Pixel, 0), (SplatKind::Sums, 1)] {
            let found = picture(&ldi, &shot, &of_splat(splat)).picture;
            for (i, pixel) in found.pixels().iter().enumerate() {
                let (x, y) = (i as u32 % ldi.camera.width, i as u32 / ldi.camera.width);
                let expected = level.at(x, y).next().map_or([0; 4], |first| level.colours[first]);
                let off = pixel.iter().zip(expected).map(|(a, b)| a.abs_diff(b)).max();
                // Where nothing is, a weight of a thousandth may be: its colour does not count.
                let off = if expected[3] == 0 { Some(pixel[3]) } else { off };
                assert!(off <= Some(most), "{pixel:?} instead of {expected:?} at {x}, {y} by {splat:?}");
            }
        }
    }
}

#[test]
fn of_two_surfaces_at_nearly_the_same_depth_the_nearer_one_is_shown_as_far_as_it_is_opaque() {
    let camera = centred(40, 30, 40.0);
    let pixel = |inverse_depth, colour| crate::DepthPixel {
        inverse_depth,
        colour,
        surface: 0,
        splat: crate::Splat(0),
    };
    for (opacity, expected) in [(255, [255, 255, 255]), (128, [188, 188, 188]), (0, [0, 0, 0])] {
        let column = |x: u16| [(x, pixel(0.5, [255, 255, 255, opacity])), (x, pixel(0.497, [0, 0, 0, 255]))];
        let rows = (0..30).map(|_| (0..40).flat_map(column).collect());
        let level = crate::ResolutionLevel::of_rows(camera, rows);
        let ldi = super::with_level(level, camera_is_world(), Vec::new());
        let found = picture(&ldi, &Shot::new(camera, camera_is_world()), &of_splat(SplatKind::Sums)).picture;
        let middle = found.pixels()[40 * 15 + 20];
        let off = (0..3).map(|c| middle[c].abs_diff(expected[c])).max();
        // Positions in single precision give neighbours a weight of some thousandths, of white against black.
        assert!(
            off <= Some(2) && middle[3] == 255,
            "{middle:?} instead of {expected:?} at opacity {opacity}"
        );
    }
}

/// Returns pictures of an image by sums, in its own camera, at sizes whose pixels do not lie on the image's.
fn at_odd_sizes(ldi: &Ldi) -> Vec<Picture> {
    let sized = |width: u32| {
        let Pinhole { width: whole, height, fx, .. } = ldi.camera;
        let camera = centred(width, width * height / whole, fx * f64::from(width) / f64::from(whole));
        picture(ldi, &Shot::new(camera, ldi.pose), &of_splat(SplatKind::Sums)).picture
    };
    [70, 77, 89, 97, 123, 151].map(sized).into()
}

#[test]
fn what_another_surface_hides_does_not_show_however_near_it_is() {
    for behind in [4.02, 4.04, 4.2, 5.0] {
        let mut model = Modeller::new();
        model.object("wall").screen(4.0, [-9.0, -9.0, 9.0, 9.0]).screen(behind, [-9.0, -9.0, 9.0, 9.0]);
        let colour = |face: usize, _| if face == 0 { [250, 250, 250, 255] } else { [0, 0, 0, 255] };
        let ldi = of_model(&model.finish(), centred(100, 80, 100.0), camera_is_world(), colour);
        for picture in at_odd_sizes(&ldi) {
            let darkest = picture.pixels().iter().map(|pixel| pixel[0].min(pixel[3])).min();
            assert!(darkest >= Some(249), "{darkest:?} at width {} and {behind}", picture.width);
        }
    }
}

#[test]
fn faces_of_one_plane_are_drawn_as_one() {
    // Panes that lie in a wall which turns away.
    let mut model = Modeller::new();
    let origin = DVec3::new(-3.0, -2.0, 3.0);
    let (u, v) = (DVec3::new(0.25, 0.0, 0.4), DVec3::new(0.0, 0.25, 0.05));
    model.object("wall");
    for (i, j) in (0..24).flat_map(|i| (0..20).map(move |j| (i, j))) {
        model.quad(origin + u * f64::from(i) + v * f64::from(j), u, v);
    }
    let colour = |face: usize, point: DVec3| match face % 3 {
        0 => [0, 0, 0, 255],
        _ => patterned(0, point),
    };
    let apart = of_model(&model.finish(), centred(100, 80, 100.0), camera_is_world(), colour);
    let mut one = apart.clone();
    for level in &mut one.levels {
        level.surfaces.fill(1);
    }
    for (apart, one) in at_odd_sizes(&apart).iter().zip(&at_odd_sizes(&one)) {
        let seen = one.pixels().iter().filter(|pixel| pixel[3] == 255).count();
        assert!(seen * 2 > one.pixels().len(), "{seen} pixels of {}", one.pixels().len());
        let pixels = apart.pixels().iter().zip(one.pixels());
        let off = pixels.flat_map(|(a, b)| (0..4).map(|c| a[c].abs_diff(b[c]))).max();
        // Depth pixels of two faces at opposite rims of a pixel's splats are apart, whose weights are some hundredths.
        assert!(off <= Some(4), "{off:?} at width {}", one.width);
    }
}

#[test]
fn the_number_of_threads_and_culling_change_nothing() {
    let mut rng = Rng::new(21);
    for seed in 0..3 {
        let (ldi, eye, middle) = scene_of(seed);
        let shot = Shot::new(centred(170, 150, 160.0), step_aside(&mut rng, eye, middle, 1.0));
        for splat in SPLATS {
            let options = of_splat(splat);
            let expected = picture(&ldi, &shot, &options);
            assert!(expected.picture.pixels().iter().filter(|pixel| pixel[3] > 0).count() > 1000);
            for threads in [1, 2, 3, 16] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                assert!(pool.install(|| picture(&ldi, &shot, &options)) == expected, "{threads} threads");
            }
            let unculled = WarpOptions { unculled: true, ..options };
            assert!(picture(&ldi, &shot, &unculled).picture == expected.picture, "without culling");
        }
    }
}

/// A view of a plane of one colour, magnified so that its depth pixels are `spacing` apart, turned by an angle; and the
/// alphas of its inner pixels.
fn plane_of_one_colour(spacing: f64, angle: f64, splat: SplatKind) -> Vec<[u8; 4]> {
    let mut model = Modeller::new();
    model.object("wall").screen(4.0, [-40.0, -40.0, 40.0, 40.0]);
    let ldi =
        of_model(&model.finish(), centred(256, 256, 256.0), camera_is_world(), |_, _| [90, 140, 200, 255]);
    let turned =
        Pose { rotation: DMat3::from_rotation_z(angle), translation: DVec3::new(0.003, -0.002, 0.0) };
    let side = ((110.0 * spacing) as u32).clamp(24, 160);
    let view = picture(&ldi, &Shot::new(centred(side, side, 256.0 * spacing), turned), &of_splat(splat));
    let inner = |i: usize| [i as u32 % side, i as u32 / side].iter().all(|at| (8..side - 8).contains(at));
    let pixels = view.picture.pixels().iter().enumerate().filter(|(i, _)| inner(*i));
    pixels.map(|(_, pixel)| *pixel).collect()
}

#[test]
fn a_plane_of_one_colour_stays_so() {
    for angle in [0.0, 0.3, 0.7] {
        for spacing in [0.2, 0.5, 0.8, 1.0, 1.3, 2.0, 3.1, 5.0, 8.0] {
            for pixel in plane_of_one_colour(spacing, angle, SplatKind::Sums) {
                let off = pixel.iter().zip([90, 140, 200, 255]).map(|(a, b)| a.abs_diff(b)).max();
                assert!(off <= Some(1), "{pixel:?} at a spacing of {spacing} turned by {angle}");
            }
        }
    }
}

#[test]
fn an_edge_that_is_not_magnified_is_as_sharp_as_depth_pixels_are_apart() {
    let mut model = Modeller::new();
    model.object("wall").screen(4.0, [-40.0, -40.0, 40.0, 40.0]);
    let in_two = |_: usize, point: DVec3| if point.x < 0.0 { [0, 0, 0, 255] } else { [255; 4] };
    let ldi = of_model(&model.finish(), centred(256, 256, 256.0), camera_is_world(), in_two);
    for spacing in [0.76, 0.8, 0.9, 1.0] {
        for step in 0..10 {
            let aside = DVec3::new(f64::from(step) * 0.1 * 4.0 / (256.0 * spacing), 0.0, 0.0);
            let pose = Pose { rotation: DMat3::IDENTITY, translation: aside };
            let shot = Shot::new(centred(64, 8, 256.0 * spacing), pose);
            let view = picture(&ldi, &shot, &of_splat(SplatKind::Sums)).picture;
            let mixed = view.pixels()[4 * 64..5 * 64].iter().filter(|pixel| (1..255).contains(&pixel[0]));
            // The nearest depth pixels on both sides reach as far as they are apart: together that is one pixel at most.
            assert!(mixed.count() <= 1, "at a spacing of {spacing}, moved by {step} tenths of a pixel");
        }
    }
}

#[test]
fn the_published_masks_close_a_plane_up_to_their_spacing() {
    // The mean alphas of the masks over all rotations, found by other means: 5 x 5 at 2.4 has 0.988.
    for spacing in [0.5, 0.7, 1.0, 1.2, 1.5, 2.0, 2.4] {
        let alphas: Vec<f64> = (0..12)
            .map(|step| f64::from(step) * std::f64::consts::FRAC_PI_2 / 12.0)
            .flat_map(|angle| plane_of_one_colour(spacing, angle, SplatKind::Over))
            .map(|pixel| f64::from(pixel[3]) / 255.0)
            .collect();
        let mean = alphas.iter().sum::<f64>() / alphas.len() as f64;
        assert!(mean >= 0.98, "{mean} at a spacing of {spacing}");
    }
}

#[test]
fn a_coarser_level_is_chosen_for_a_smaller_picture_and_looks_alike() {
    let (ldi, ..) = scene_of(1);
    let small = |factor: u32| {
        let camera = ldi.levels[0].camera;
        let scale = f64::from(factor);
        let [fx, fy, cx, cy] = [camera.fx, camera.fy, camera.cx, camera.cy].map(|length| length / scale);
        let (width, height) = (camera.width / factor, camera.height / factor);
        Shot::new(Pinhole { width, height, fx, fy, cx, cy }, ldi.pose)
    };
    let automatic = WarpOptions::default();
    let of = |quality, factor| picture(&ldi, &Shot { quality, ..small(factor) }, &automatic);
    assert_eq!([1, 2, 4, 8].map(|factor| of(Quality::Preview, factor).level), [0, 0, 1, 2]);
    assert_eq!([1, 2, 4, 8].map(|factor| of(Quality::Final, factor).level), [0, 0, 0, 1]);
    let (fine, coarse) = (picture(&ldi, &small(4), &of_splat(SplatKind::Sums)), of(Quality::Preview, 4));
    let pixels = fine.picture.pixels().iter().zip(coarse.picture.pixels());
    let off: f64 = pixels.clone().map(|(a, b)| f64::from(a[0].abs_diff(b[0]))).sum();
    // The patterns are finer than these pixels in places: a tenth of their range.
    assert!(off / (pixels.len() as f64) < 12.0, "{}", off / pixels.len() as f64);
}

#[test]
fn what_is_behind_shows_when_the_camera_steps_aside() {
    let scene = closed_form::two_quads().resized(200);
    let ldi = of_model(&scene.model, scene.camera, scene.pose, |face, _| {
        if face == 0 { [255, 0, 0, 255] } else { [0, 0, 255, 255] }
    });
    let aside = Pose { translation: scene.pose.translation + DVec3::new(0.3, 0.0, 0.0), ..scene.pose };
    let count = |pose: Pose, splat| {
        let view = picture(&ldi, &Shot::new(scene.camera, pose), &of_splat(splat)).picture;
        let empty = view.pixels().iter().filter(|pixel| pixel[3] == 0).count();
        let mixed = view.pixels().iter().filter(|p| p[3] > 0 && p[0] > 30 && p[2] > 30).count();
        (empty, mixed, view.pixels().len())
    };
    for splat in SPLATS {
        let (empty, ..) = count(scene.pose, splat);
        let (empty_aside, mixed, all) = count(aside, splat);
        // Nothing opens behind the near quad: at most the far quad's own border leaves or enters the picture.
        assert!(empty_aside <= empty + all / 8, "{empty} and {empty_aside} of {all} by {splat:?}");
        // The published masks blur by design.
        assert!(mixed < all / 20 || splat == SplatKind::Over, "{mixed} of {all} by {splat:?}");
    }
}

#[test]
fn the_far_side_of_a_tower_does_not_shine_through_the_edge_where_it_meets_the_front() {
    let ldi = tower();
    for (aside, width) in [(0.0, 400), (0.0, 120), (0.05, 200), (-0.05, 400)] {
        let camera = centred(width, width * 2 / 5, 0.8 * f64::from(width));
        let pose = Pose { translation: DVec3::new(aside, 0.0, 0.0), ..camera_is_world() };
        let seen = picture(&ldi, &Shot::new(camera, pose), &WarpOptions::default()).picture;
        let front = seen.pixels().iter().filter(|pixel| pixel[3] == 255);
        // The front is (200, 180, 150); nothing else is before the empty background.
        let mixed = front.clone().filter(|pixel| pixel[0] < 196).count();
        assert!(front.count() > 500 && mixed == 0, "{mixed} pixels at {aside}, {width}");
    }
}

#[test]
fn nothing_opens_where_a_board_is_before_a_wall_at_nearly_its_depth() {
    let mut model = Modeller::new();
    model.object("wall").screen(4.06, [-9.0, -9.0, 9.0, 9.0]);
    model.object("board").screen(4.0, [-0.7, -0.5, 0.9, 0.6]);
    let ldi = of_model(&model.finish(), centred(400, 160, 320.0), camera_is_world(), |face, _| {
        if face == 0 { [40, 60, 90, 255] } else { [200, 180, 150, 255] }
    });
    for width in [200, 300, 400] {
        let focal = 0.8 * f64::from(width);
        // How far the camera steps for a pixel of parallax between them.
        let step = 1.0 / (focal * (1.0 / 4.0 - 1.0 / 4.06));
        for parallax in [-0.9, -0.7, -0.4, 0.2, 0.5, 0.6, 0.8, 1.0, 1.3] {
            let pose = Pose { translation: DVec3::X * step * parallax, ..camera_is_world() };
            let camera = centred(width, width * 2 / 5, focal);
            let seen = picture(&ldi, &Shot::new(camera, pose), &WarpOptions::default()).picture;
            // The image ends at the sides of the frame, which move aside, and fades over a splat.
            let [width, height] = [width as usize, width as usize * 2 / 5];
            let aside = (focal * (step * parallax).abs() / 4.0).ceil() as usize + 3;
            let rows = seen.pixels().chunks_exact(width).skip(3).take(height - 6);
            // What is seen moves with the translation.
            let columns = if parallax > 0.0 { aside..width - 3 } else { 3..width - aside };
            let inside = rows.flat_map(|row| &row[columns.clone()]);
            let open = inside.clone().filter(|pixel| pixel[3] < 255).count();
            assert!(inside.count() > 1000 && open == 0, "{open} pixels at {width}, {parallax}");
        }
    }
}

#[test]
fn a_side_that_the_reference_camera_does_not_see_is_drawn_only_on_request() {
    let mut model = Modeller::new();
    model.object("wall").screen(4.0, [-4.0, -4.0, 4.0, 4.0]);
    let ldi = of_model(&model.finish(), centred(64, 48, 50.0), camera_is_world(), |_, _| [255; 4]);
    // Beyond the wall, looking back at it.
    let rotation = DMat3::from_rotation_y(std::f64::consts::PI);
    let beyond = Pose { rotation, translation: rotation * -DVec3::new(0.0, 0.0, 8.0) };
    for splat in SPLATS {
        for backs in [true, false] {
            let shot = Shot { backs, ..Shot::new(centred(64, 48, 50.0), beyond) };
            let drawn = picture(&ldi, &shot, &of_splat(splat)).picture.pixels().iter().any(|p| p[3] > 0);
            assert_eq!(drawn, backs, "{splat:?}");
        }
    }
}

#[test]
fn what_is_infinitely_far_turns_with_the_camera_and_does_not_move() {
    let mut model = Modeller::new();
    model.object("wall").screen(1e30, [-1e30, -1e30, 1e30, 1e30]);
    let camera = centred(64, 48, 50.0);
    let sky = |_: usize, point: DVec3| [(40.0 + 60.0 * (point.x / 1e30 + 0.7)) as u8, 9, 9, 255];
    let mut ldi = of_model(&model.finish(), camera, camera_is_world(), sky);
    assert!(ldi.levels[0].is_empty(), "at that distance a ray meets nothing");
    let row = |y: u32| {
        (0..64)
            .map(|x| {
                (
                    x,
                    crate::DepthPixel {
                        inverse_depth: 0.0,
                        colour: [x as u8 * 3, y as u8 * 4, 0, 255],
                        surface: 0,
                        splat: crate::Splat(0),
                    },
                )
            })
            .collect()
    };
    ldi.levels = vec![crate::ResolutionLevel::of_rows(camera, (0..48).map(row))];
    let moved = Pose { rotation: DMat3::IDENTITY, translation: DVec3::new(5.0, -3.0, 2.0) };
    for splat in [SplatKind::Pixel, SplatKind::Sums] {
        let at = |pose| picture(&ldi, &Shot::new(camera, pose), &of_splat(splat)).picture;
        assert_eq!(at(moved), at(camera_is_world()));
    }
}
