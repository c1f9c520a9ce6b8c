//! Depth pixels that a view stretches.

use glam::{DMat2, DVec2, DVec3};

use super::super::warp::warp;
use super::{floor, from_above, of_model, slow, step_aside};
use crate::splat::sums::{LEAST, OVERFULL};
use crate::stretch::{CLOSED, Jacobian, LEAST_RATIO, LONGEST, Parallelogram, Squares, jacobian, plane_maps};
use crate::transfer::Transfer;
use crate::{LdiSurface, SplatKind, WarpOptions};
use quadratura_base::scene::synthetic::{Modeller, Rng, camera_is_world, centred, look_at};
use quadratura_base::task::Task;
use quadratura_view::Shot;

/// Returns a Jacobian whose singular values are these, mirrored or not.
fn with_sides(rng: &mut Rng, [long, short]: [f64; 2]) -> DMat2 {
    let mut turn = || DMat2::from_angle(rng.between(0.0, std::f64::consts::TAU));
    let (one, other) = (turn(), turn());
    let mirrored = if rng.chance(0.5) { -short } else { short };
    one * DMat2::from_diagonal(DVec2::new(long, mirrored)) * other
}

fn in_rows(j: DMat2) -> Jacobian {
    [[j.x_axis.x as f32, j.y_axis.x as f32], [j.x_axis.y as f32, j.y_axis.y as f32]]
}

/// Returns the sum of weights at a position of all depth pixels of a grid, and checks that no weight is beyond the reach.
fn sum_at(splat: &Parallelogram, j: DMat2, position: DVec2, steps: i32) -> f32 {
    let mut sum = 0.0;
    for (x, y) in (-steps..=steps).flat_map(|x| (-steps..=steps).map(move |y| (x, y))) {
        let apart = (position - j * DVec2::new(x.into(), y.into())).as_vec2();
        let weight = splat.weight(apart.x, apart.y);
        let [low, high] = splat.extent(apart.y);
        let reached = apart.abs().cmple(glam::Vec2::from_array(splat.reach)).all();
        let clipped = splat.reach.iter().any(|reach| *reach >= LONGEST);
        assert!(
            weight <= 0.0 || clipped || reached && low <= apart.x && apart.x <= high,
            "{splat:?} at {apart}"
        );
        sum += weight;
    }
    sum
}

#[test]
fn weights_of_a_grid_sum_up_to_one_everywhere() {
    let mut rng = Rng::new(31);
    for _ in 0..200 {
        // Neither column of the parallelogram is wider or narrower than what is limited.
        let long = rng.between(1.5, 7.0);
        let j = with_sides(&mut rng, [long, 1.3]);
        let splat = Parallelogram::new(&in_rows(j), LEAST);
        for _ in 0..20 {
            let position = DVec2::new(rng.between(-0.5, 0.5), rng.between(-0.5, 0.5));
            let sum = sum_at(&splat, j, position, 12);
            assert!((sum - 1.0).abs() < 1e-3, "{sum} of {splat:?}");
        }
    }
}

#[test]
fn weights_of_a_grid_of_thin_depth_pixels_are_one_on_average_and_cover_everything() {
    let mut rng = Rng::new(32);
    for _ in 0..60 {
        let sides = [rng.between(1.3, 7.0), rng.between(0.1, 0.7)];
        let j = with_sides(&mut rng, sides);
        let splat = Parallelogram::new(&in_rows(j), LEAST);
        // Over one cell of the grid.
        let cell =
            |(x, y): (u32, u32)| j * DVec2::new((f64::from(x) + 0.5) / 8.0, (f64::from(y) + 0.5) / 8.0);
        let sums: Vec<f32> = (0..64).map(|i| sum_at(&splat, j, cell((i % 8, i / 8)), 40)).collect();
        // The tents of a grid that are wider across than it: those of 0.75 sum up to 0.891 to 1.125 for all widths below.
        let mean = sums.iter().sum::<f32>() / 64.0;
        let (least, largest) = (f32::INFINITY, 0.0f32);
        let (least, largest) =
            (sums.iter().copied().fold(least, f32::min), sums.iter().copied().fold(largest, f32::max));
        assert!(
            (mean - 1.0).abs() < 0.02 && least > 0.88 && largest < OVERFULL,
            "{least} {mean} {largest} at {sides:?}"
        );
    }
}

#[test]
fn what_is_longer_than_splats_reach_is_as_wide_as_what_is_not() {
    let mut rng = Rng::new(36);
    for _ in 0..100 {
        let (long, short) = (rng.between(17.0, 200.0), rng.between(0.1, 12.0));
        let turned = DMat2::from_angle(rng.between(0.0, std::f64::consts::TAU));
        // Columns at a right angle, either of them the longer one.
        let sides = if rng.chance(0.5) { DVec2::new(long, short) } else { DVec2::new(short, long) };
        let splat = Parallelogram::new(&in_rows(turned * DMat2::from_diagonal(sides)), LEAST);
        let half = short.max(LEAST.into());
        let across = turned * if sides.x > sides.y { DVec2::Y } else { DVec2::X };
        let at =
            |share: f64| splat.weight((share * half * across.x) as f32, (share * half * across.y) as f32);
        let expected = at(0.0) / 2.0;
        assert!(splat.is_cut && at(1.01) == 0.0 && (at(0.5) - expected).abs() < 1e-3 * expected, "{splat:?}");
    }
}

#[test]
fn jacobians_are_finite_differences_and_their_squares_are_bounded() {
    let mut rng = Rng::new(33);
    let mut stretched = 0;
    for _ in 0..300 {
        let nu = DVec3::new(rng.between(-2e-3, 2e-3), rng.between(-2e-3, 2e-3), rng.between(0.05, 0.4));
        let surface = LdiSurface { nu, object: "wall".into(), face: None };
        let level = crate::ResolutionLevel::of_rows(centred(320, 240, 300.0), (0..240).map(|_| Vec::new()));
        let ldi = super::with_level(level, camera_is_world(), vec![surface]);
        let eye = DVec3::ZERO;
        let pose = step_aside(&mut rng, eye, DVec3::new(0.5, 4.0, 0.3), 0.8);
        let looking = look_at(eye, DVec3::Y * 4.0);
        let transfer = Transfer::new(&ldi.camera, &looking, &centred(200, 160, 250.0), &pose);
        // Of the level whose pixels are twice as large.
        let maps = plane_maps(&ldi, &transfer, 2.0);
        assert_eq!(maps[0], [[0.0; 2]; 3], "the unknown surface");
        let (squares, half) = (Squares::new(&maps[1]), transfer.rows().half);
        let (position, step) = (DVec2::new(rng.between(0.0, 320.0), rng.between(0.0, 240.0)), 1e-4);
        let at = |p: DVec2| transfer.position(p, nu.dot(p.extend(1.0)));
        let Some((place, omega)) = at(position) else { continue };
        let [x, y] = [DVec2::X, DVec2::Y].map(|axis| {
            let [before, after] = [-step, step].map(|step| at(position + step * axis).unwrap().0);
            2.0 * (after - before) / (2.0 * step)
        });
        let from_centre = (place.as_vec2() - glam::Vec2::from_array(half)).to_array();
        let found = jacobian(&maps[1], from_centre, 1.0 / omega as f32);
        let expected = in_rows(DMat2::from_cols(x, y));
        let size = x.length().max(y.length());
        for (found, expected) in found.as_flattened().iter().zip(expected.as_flattened()) {
            let apart = f64::from((found - expected).abs());
            assert!(apart < 1e-3 * size.max(1.0), "{found} instead of {expected} of {size}");
        }
        let root = (x.length_squared() + y.length_squared()).sqrt();
        let margin = f64::from(LONGEST);
        if place.min_element() > -margin && place.x < 200.0 + margin && place.y < 160.0 + margin {
            // Single precision has seven digits.
            assert!(f64::from(squares.largest_root(half)) >= omega * root * 0.9999);
        }
        // The longer side over the shorter one, from the singular values.
        let area = x.perp_dot(y).abs();
        let ratio = (root * root + (root.powi(4) - 4.0 * area * area).max(0.0).sqrt()) / (2.0 * area);
        let is_stretched = squares.is_stretched(from_centre, 1.0 / omega as f32, area.sqrt() as f32);
        let expected = ratio > f64::from(LEAST_RATIO) && root > f64::from(CLOSED);
        let close = |value: f64, limit: f32| (value / f64::from(limit) - 1.0).abs() < 1e-2;
        assert!(is_stretched == expected || close(ratio, LEAST_RATIO) || close(root, CLOSED));
        stretched += u32::from(is_stretched);
    }
    assert!((30..270).contains(&stretched), "{stretched}");
}

/// How far colours are from those of the floor, in stored values: its depth pixels are up to 0.5 apart in these views, over which
/// [`slow`] changes by 50 at most, and bends by 3 (a second derivative of 100, times 0.5 squared, over 8); light is mixed where it is
/// linear, which makes 4 more of 50, and is rounded.
const INTERPOLATED: u8 = 8;

#[test]
fn a_floor_seen_at_a_grazing_angle_has_no_cracks_from_above() {
    let (model, ldi) = floor();
    let mut rng = Rng::new(34);
    for step in 0..12 {
        let shot = from_above(&mut rng);
        let camera = shot.camera;
        let options = WarpOptions { splat: SplatKind::Sums, level: Some(0), ..WarpOptions::default() };
        let found = warp(&ldi, &shot, &options, &Task::silent()).unwrap().picture;
        let truth = of_model(&model, camera, shot.pose, slow);
        let truth = &truth.levels[0];
        let mut worst = 0;
        for (i, pixel) in found.pixels().iter().enumerate() {
            let (x, y) = (i as u32 % 90, i as u32 / 90);
            let Some(at) = truth.at(x, y).next() else { continue };
            let ray = camera.ray_in_camera(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
            let point = shot.pose.world_from_camera(ray / f64::from(truth.inverse_depths[at]));
            let DVec3 { x: right, y: down, z } = ldi.pose.camera_from_world(point);
            // The reference camera sees 0.5 to each side of its axis at a distance of 1.
            if right.abs().max(down.abs()) > 0.49 * z {
                continue;
            }
            assert_eq!(pixel[3], 255, "a crack in view {step} at {x}, {y}");
            worst = worst.max((0..3).map(|c| pixel[c].abs_diff(truth.colours[at][c])).max().unwrap());
        }
        assert!(worst <= INTERPOLATED, "{worst} in view {step}");
        let unculled = WarpOptions { unculled: true, ..options };
        assert!(
            warp(&ldi, &shot, &unculled, &Task::silent()).unwrap().picture == found,
            "culling changes nothing"
        );
    }
}

#[test]
fn what_a_view_mirrors_is_no_other() {
    // The same floor from below, drawn with the sides that the reference camera does not see.
    let (model, ldi) = floor();
    let target = DVec3::new(0.3, 6.0, -1.0);
    let pose = look_at(target + DVec3::new(0.4, -1.5, -4.0), target);
    let shot = Shot { backs: true, ..Shot::new(centred(90, 70, 120.0), pose) };
    let options = WarpOptions { splat: SplatKind::Sums, level: Some(0), ..WarpOptions::default() };
    let found = warp(&ldi, &shot, &options, &Task::silent()).unwrap().picture;
    let truth = of_model(&model, shot.camera, pose, slow);
    let mut seen = 0;
    for (i, pixel) in found.pixels().iter().enumerate() {
        let Some(at) = truth.levels[0].at(i as u32 % 90, i as u32 / 90).next() else { continue };
        let off = (0..4).map(|c| pixel[c].abs_diff(truth.levels[0].colours[at][c])).max();
        assert!(off <= Some(INTERPOLATED), "{pixel:?} at {i}");
        seen += 1;
    }
    assert!(seen > 5000, "{seen}");
}

#[test]
fn a_stretched_floor_does_not_cover_the_foot_of_what_is_on_it() {
    let mut model = Modeller::new();
    model.object("floor").quad(DVec3::new(-30.0, 0.0, -0.3), DVec3::X * 60.0, DVec3::Y * 30.0);
    model.object("post").quad(DVec3::new(-0.5, 6.0, -0.3), DVec3::X, DVec3::Z * 1.2);
    let (model, reference) = (model.finish(), look_at(DVec3::ZERO, DVec3::Y));
    let colour = |face: usize, _| if face == 0 { [30, 40, 50, 255] } else { [220, 210, 200, 255] };
    let ldi = of_model(&model, centred(256, 256, 256.0), reference, colour);
    let options = WarpOptions { splat: SplatKind::Sums, level: Some(0), ..WarpOptions::default() };
    let mut posts = 0;
    for (height, focal) in [(1.0, 150.0), (2.0, 200.0), (3.0, 250.0)] {
        let (eye, camera) = (DVec3::new(0.3, 1.0, height), centred(90, 70, focal));
        let shot = Shot::new(camera, look_at(eye, DVec3::new(0.0, 6.0, -0.6)));
        let found = warp(&ldi, &shot, &options, &Task::silent()).unwrap().picture;
        let truth = of_model(&model, camera, shot.pose, colour);
        let shows_post = |x: u32, y: u32| {
            let first = truth.levels[0].at(x, y).next();
            first.is_some_and(|at| truth.levels[0].colours[at][0] == 220)
        };
        for (x, y) in (1..69).flat_map(|y| (1..89).map(move |x| (x, y))) {
            // Splats of the post itself end up to a pixel and a half before its outline.
            let around = (0..9).all(|i| shows_post(x + i % 3 - 1, y + i / 3 - 1));
            if around {
                let pixel = found.pixels()[(y * 90 + x) as usize];
                // Along the foot both are at one depth, and mixed: most of the light is the post's.
                assert!(pixel[0] >= 160, "{pixel:?} at {x}, {y} from a height of {height}");
                posts += 1;
            }
        }
    }
    assert!(posts > 500, "{posts}");
}
