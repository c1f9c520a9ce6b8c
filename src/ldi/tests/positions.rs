//! Where depth pixels are in pictures, and how far apart.

use glam::{DMat3, DVec2, DVec3};

use super::super::spacing::{Factors, entry_of, exact, factor, is_from_behind, normal_of, normal_of_entry};
use super::super::transfer::{Positions, RUN, Transfer};
use super::{step_aside, with_level};
use crate::{DepthPixel, DepthPixelOrigin, LdiSurface, ResolutionLevel, Splat};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::synthetic::Rng;

fn camera(width: u32, height: u32, rng: &mut Rng) -> Pinhole {
    let focal = f64::from(width) * rng.between(0.6, 1.6);
    let (cx, cy) = (f64::from(width) * rng.between(0.4, 0.6), f64::from(height) * rng.between(0.4, 0.6));
    Pinhole { width, height, fx: focal, fy: focal * rng.between(0.9, 1.1), cx, cy }
}

/// Two cameras at `origin` that look the same way from up to a metre apart, and the target that they look at.
fn two_cameras(origin: DVec3, rng: &mut Rng) -> ([(Pinhole, Pose); 2], DVec3) {
    let target = origin + DVec3::new(rng.between(-2.0, 2.0), 8.0, rng.between(-2.0, 2.0));
    let poses = [0.1, 1.0].map(|apart| step_aside(rng, origin, target, apart));
    let sizes = [(3072, 2048), (1920, 1080)].map(|(width, height)| camera(width, height, rng));
    ([(sizes[0], poses[0]), (sizes[1], poses[1])], target)
}

#[test]
fn the_transfer_is_projection_through_the_world() {
    let mut rng = Rng::new(5);
    for _ in 0..50 {
        let ([(camera1, pose1), (camera2, pose2)], _) = two_cameras(DVec3::ZERO, &mut rng);
        let transfer = Transfer::new(&camera1, &pose1, &camera2, &pose2);
        for _ in 0..20 {
            let position = DVec2::new(rng.between(0.0, 3072.0), rng.between(0.0, 2048.0));
            let depth = rng.between(2.0, 40.0);
            let point = pose1.world_from_camera(camera1.ray_in_camera(position) * depth);
            let expected = camera2.image_from_camera(pose2.camera_from_world(point)).unwrap();
            let (found, omega) = transfer.position(position, 1.0 / depth).unwrap();
            // Two ways through f64 in pixels of some thousands: twelve digits of a pixel would be exact.
            assert!(found.distance(expected) < 1e-8, "{found} instead of {expected}");
            assert!((omega * depth - pose2.camera_from_world(point).z).abs() < 1e-9);
        }
        let centre = camera1.image_from_camera(pose1.camera_from_world(pose2.center_in_world()));
        if let Some(centre) = centre {
            assert!(
                (transfer.epipole.truncate() / transfer.epipole.z).distance(centre) < 1e-5 * centre.length()
            );
        }
    }
}

#[test]
fn positions_in_single_precision_are_right_to_a_hundredth_of_a_pixel_also_far_from_the_origin() {
    let mut rng = Rng::new(6);
    let mut worst: f64 = 0.0;
    for origin in [DVec3::ZERO, DVec3::new(3e6, -4e6, 1e5)] {
        for _ in 0..40 {
            let ([(camera1, pose1), (camera2, pose2)], _) = two_cameras(origin, &mut rng);
            let transfer = Transfer::new(&camera1, &pose1, &camera2, &pose2);
            let rows = transfer.rows();
            let y = rng.whole(0, 2047);
            let first = rng.whole(0, 11) * RUN;
            let columns: Vec<u16> = (first..first + RUN).map(|column| column as u16).collect();
            let depths: Vec<f32> = columns.iter().map(|_| (1.0 / rng.between(3.0, 60.0)) as f32).collect();
            let mut positions = Positions::default();
            rows.place(&rows.start(first, y), &columns, &depths, &mut positions);
            for (i, (&column, &depth)) in columns.iter().zip(&depths).enumerate() {
                let position = DVec2::new(f64::from(column) + 0.5, f64::from(y) + 0.5);
                let Some((expected, omega)) = transfer.position(position, f64::from(depth)) else { continue };
                let inside = expected.min_element() >= 0.0 && expected.x <= 1920.0 && expected.y <= 1080.0;
                if inside && omega > 0.05 {
                    let found = DVec2::new(f64::from(positions.u[i]), f64::from(positions.v[i]));
                    worst = worst.max(found.distance(expected));
                }
            }
        }
    }
    assert!(worst <= 0.01, "{worst} px");
    assert!(worst > 0.0);
}

#[test]
fn positions_do_not_depend_on_where_a_batch_begins() {
    let mut rng = Rng::new(7);
    let ([(camera1, pose1), (camera2, pose2)], _) = two_cameras(DVec3::ZERO, &mut rng);
    let rows = Transfer::new(&camera1, &pose1, &camera2, &pose2).rows();
    let columns: Vec<u16> = (512..768).collect();
    let depths: Vec<f32> = columns.iter().map(|_| rng.between(0.0, 0.4) as f32).collect();
    let (mut whole, mut part) = (Positions::default(), Positions::default());
    rows.place(&rows.start(512, 9), &columns, &depths, &mut whole);
    for from in [1, 63, 200] {
        rows.place(&rows.start(u32::from(columns[from]), 9), &columns[from..], &depths[from..], &mut part);
        for i in from..256 {
            let bits = |p: &Positions, i: usize| [p.u[i], p.v[i], p.per_omega[i]].map(f32::to_bits);
            assert_eq!(bits(&whole, i), bits(&part, i - from));
        }
    }
}

/// A plane through the target, as it is in the reference camera.
fn plane(normal: DVec3, target: DVec3, camera: &Pinhole, pose: &Pose) -> LdiSurface {
    let normal = pose.rotation * normal;
    let scaled = normal / normal.dot(pose.camera_from_world(target));
    let Pinhole { fx, fy, cx, cy, .. } = *camera;
    let (x, y) = (scaled.x / fx, scaled.y / fy);
    LdiSurface { nu: DVec3::new(x, y, scaled.z - x * cx - y * cy), object: "wall".into(), face: None }
}

#[test]
fn the_exact_spacing_is_that_of_finite_differences() {
    let mut rng = Rng::new(8);
    let mut compared = 0;
    for _ in 0..200 {
        let ([one, two], target) = two_cameras(DVec3::ZERO, &mut rng);
        let transfer = Transfer::new(&one.0, &one.1, &two.0, &two.1);
        let normal = DVec3::new(rng.between(-1.0, 1.0), -1.0, rng.between(-1.0, 1.0)).normalize();
        let wall = plane(normal, target, &one.0, &one.1);
        let position = DVec2::new(rng.between(200.0, 2800.0), rng.between(200.0, 1800.0));
        let at = |position: DVec2| {
            let depth = wall.nu.dot(position.extend(1.0));
            (depth > 0.02).then(|| transfer.position(position, depth)).flatten()
        };
        let step = 1e-3;
        let around = [DVec2::X, -DVec2::X, DVec2::Y, -DVec2::Y].map(|to| at(position + step * to));
        let [Some(right), Some(left), Some(down), Some(up)] = around else { continue };
        let Some((_, omega)) = at(position) else { continue };
        let area = ((right.0 - left.0) / (2.0 * step)).perp_dot((down.0 - up.0) / (2.0 * step)).abs();
        let skew = |camera: &Pinhole| (camera.fx * camera.fy).sqrt();
        assert!((transfer.focal_ratio - skew(&two.0) / skew(&one.0)).abs() < 1e-12);
        let expected = factor(&wall, &transfer) * omega.powf(-1.5);
        assert!((expected / area.sqrt() - 1.0).abs() < 1e-6, "{expected} instead of {}", area.sqrt());
        let single = exact(factor(&wall, &transfer) as f32, (1.0 / omega) as f32);
        assert!((f64::from(single) / expected - 1.0).abs() < 1e-5);
        compared += 1;
    }
    assert!(compared > 100, "{compared}");
}

#[test]
fn a_surface_is_seen_from_behind_beyond_its_plane() {
    let identity = Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO };
    let beyond = Pose { rotation: DMat3::IDENTITY, translation: DVec3::new(0.0, 0.0, -8.0) };
    let camera = Pinhole { width: 64, height: 48, fx: 50.0, fy: 50.0, cx: 32.0, cy: 24.0 };
    let wall = plane(-DVec3::Z, DVec3::new(0.0, 0.0, 4.0), &camera, &identity);
    let to = |pose: &Pose| Transfer::new(&camera, &identity, &camera, pose);
    assert!(!is_from_behind(&wall, &to(&identity)) && is_from_behind(&wall, &to(&beyond)));
    let ahead = normal_of(&wall, &camera);
    assert!(ahead.distance(-DVec3::Z) < 1e-12);
}

#[test]
fn the_published_table_is_the_truth_within_a_factor_of_two() {
    let mut rng = Rng::new(9);
    let quartiles = [6.0, 8.0, 11.0];
    let (mut good, mut all) = (0, 0);
    for _ in 0..300 {
        let ([one, two], target) = two_cameras(DVec3::ZERO, &mut rng);
        let transfer = Transfer::new(&one.0, &one.1, &two.0, &two.1);
        let normal = DVec3::new(rng.between(-0.6, 0.6), -1.0, rng.between(-0.6, 0.6)).normalize();
        let wall = plane(normal, target, &one.0, &one.1);
        let position = DVec2::new(rng.between(200.0, 2800.0), rng.between(200.0, 1800.0));
        let depth = wall.nu.dot(position.extend(1.0));
        let Some((_, omega)) = transfer.position(position, depth).filter(|_| depth > 0.02) else { continue };
        let distance = (one.0.ray_in_camera(position) / depth).length();
        if !(5.0..14.0).contains(&distance) {
            continue;
        }
        let entry = entry_of(normal_of(&wall, &one.0), distance, &quartiles);
        let splat = Splat::new(entry, DepthPixelOrigin::Photo);
        let sample = DepthPixel { inverse_depth: depth as f32, colour: [255; 4], surface: 1, splat };
        let small = Pinhole { width: 1, height: 1, ..one.0 };
        let mut ldi =
            with_level(ResolutionLevel::of_rows(small, [vec![(0, sample)]]), one.1, vec![wall.clone()]);
        ldi.report.quartiles = quartiles;
        let Factors::Table(table) = Factors::table(&ldi, &two.1, transfer.focal_ratio) else {
            unreachable!()
        };
        let found = f64::from(table[usize::from(entry)]) * depth / omega;
        let truth = factor(&wall, &transfer) * omega.powf(-1.5);
        all += 1;
        good += u32::from((0.5..2.0).contains(&(found / truth)));
    }
    assert!(all > 100 && good * 100 > all * 95, "{good} of {all}");
}

#[test]
fn a_normal_is_in_the_bins_of_its_entry() {
    for entry in 0..16 {
        let normal = normal_of_entry(entry);
        assert!((normal.length() - 1.0).abs() < 1e-12 && normal.z < 0.0);
        let is_on_disc = !matches!(entry, 0 | 3 | 12 | 15);
        if is_on_disc {
            assert_eq!(entry_of(normal, 0.5, &[1.0, 2.0, 3.0]), entry);
        }
    }
    let far = |distance| entry_of(-DVec3::Z, distance, &[1.0, 2.0, 3.0]) >> 4;
    assert_eq!([0.5, 1.5, 2.5, 9.0].map(far), [0, 1, 2, 3]);
}
