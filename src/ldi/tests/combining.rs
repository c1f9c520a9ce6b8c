//! Several layered depth images in one camera.

use std::collections::BTreeMap;

use glam::{DMat3, DVec2, DVec3};

use super::{of_model, step_aside};
use crate::combine::{Combining, CommonCamera, SourceImage, combine, combine_in_parts};
use crate::finish::{SampleCounts, Unfinished};
use crate::merge::Merging;
use crate::transfer::Transfer;
use crate::{DepthPixel, DepthPixelOrigin, Ldi, LdiKind, ResolutionLevel};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::synthetic::{Rng, centred, closed_form, look_at, random};
use quadratura_base::task::Task;

fn combined(frame: &CommonCamera, sources: &[SourceImage], combining: &Combining) -> Ldi {
    combine(LdiKind::Photos, frame, sources, combining, BTreeMap::new(), &Task::silent()).unwrap()
}

fn frame_of(ldi: &Ldi, guard: f64) -> CommonCamera {
    CommonCamera::new(ldi.camera, ldi.pose, ldi.gain, guard, true)
}

/// Returns depth images of a scene of boxes from several cameras, each coloured by the face and a pattern on it.
fn boxes(seed: u64, count: u32) -> Vec<Ldi> {
    let scene = random::boxes(seed, 12);
    let mut rng = Rng::new(seed);
    let camera = centred(96, 72, 90.0);
    let eye = scene.pose.center_in_world();
    let target = scene.model.vertices.iter().sum::<DVec3>() / scene.model.vertices.len() as f64;
    let colour = |face: usize, point: DVec3| {
        let stripes = (point * 1.5).floor().element_sum() as i64;
        [(face * 37 % 190) as u8, (stripes * 91).rem_euclid(190) as u8, 90, 255]
    };
    (0..count)
        .map(|i| {
            let pose = match i {
                0 => look_at(eye, target),
                _ => step_aside(&mut rng, eye, target, 3.0),
            };
            let mut image = of_model(&scene.model, camera, pose, colour);
            image.sources = vec![format!("{i}.png")];
            image.depth_image()
        })
        .collect()
}

fn same_depth_pixels(a: &ResolutionLevel, b: &ResolutionLevel) -> bool {
    (&a.rows, &a.columns, &a.inverse_depths, &a.colours)
        == (&b.rows, &b.columns, &b.inverse_depths, &b.colours)
}

#[test]
fn one_image_in_its_own_camera_stays_as_it_is_and_a_guard_band_moves_it_by_whole_pixels() {
    let one = &boxes(31, 1)[0];
    for published in [false, true] {
        let combining = Combining { published, ..Combining::default() };
        for is_own in [true, false] {
            let same = combined(&frame_of(one, 0.0), &[SourceImage { ldi: one, is_own }], &combining);
            assert!(same_depth_pixels(&same.levels[0], &one.levels[0]));
        }
        let grown = combined(&frame_of(one, 0.3), &[SourceImage { ldi: one, is_own: true }], &combining);
        let rect = grown.photo_rect.unwrap();
        assert_eq!((rect.x, rect.y, rect.w, rect.h), (29, 22, 96, 72));
        assert_eq!((grown.camera.width, grown.camera.height), (96 + 58, 72 + 44));
        for y in 0..72 {
            let (row, of_grown) = (one.levels[0].row(y), grown.levels[0].row(y + 22));
            let moved: Vec<u16> = one.levels[0].columns[row.clone()].iter().map(|x| x + 29).collect();
            assert_eq!(grown.levels[0].columns[of_grown.clone()], moved);
            assert_eq!(grown.levels[0].colours[of_grown], one.levels[0].colours[row]);
        }
    }
}

#[test]
fn copies_of_an_image_give_its_own_bytes() {
    let one = &boxes(32, 1)[0];
    let merging = Merging::default();
    for copies in [2, 5] {
        let sources: Vec<SourceImage> =
            (0..copies).map(|i| SourceImage { ldi: one, is_own: i == 0 }).collect();
        let all = combined(&frame_of(one, 0.0), &sources, &Combining { merging, published: false });
        assert!(same_depth_pixels(&all.levels[0], &one.levels[0]));
        assert_eq!(all.report.merged, (copies - 1) * one.levels[0].len() as u64);
    }
}

#[test]
fn the_order_of_sources_does_not_count_unless_it_is_published() {
    let images = boxes(33, 4);
    let frame = frame_of(&images[0], 0.2);
    let sources = |order: [usize; 4]| order.map(|i| SourceImage { ldi: &images[i], is_own: i == 0 });
    let combining = Combining::default();
    let expected = combined(&frame, &sources([0, 1, 2, 3]), &combining);
    for order in [[0, 3, 2, 1], [2, 0, 1, 3], [3, 1, 2, 0]] {
        let other = combined(&frame, &sources(order), &combining);
        // Means are sums of samples in the order of depths, so they are the same sums.
        assert!(same_depth_pixels(&other.levels[0], &expected.levels[0]), "{order:?}");
    }
    let published = Combining { published: true, ..Combining::default() };
    let [a, b] = [[0, 1, 2, 3], [0, 3, 2, 1]].map(|order| combined(&frame, &sources(order), &published));
    assert!(!same_depth_pixels(&a.levels[0], &b.levels[0]));
}

/// Combines in one part and in several ones, which give the same.
fn combined_in_any_parts(frame: &CommonCamera, sources: &[SourceImage], combining: &Combining) -> Ldi {
    let in_parts = |rows: u32| {
        let (kind, options) = (LdiKind::Photos, BTreeMap::new());
        combine_in_parts(kind, frame, sources, combining, options, rows, &Task::silent()).unwrap()
    };
    let all = in_parts(u32::MAX);
    // In strips of 16 rows, two and seven of them at a time.
    for other in [0, 47, 112].map(in_parts) {
        assert!(same_depth_pixels(&other.levels[0], &all.levels[0]));
        assert_eq!(other.report, all.report);
    }
    all
}

#[test]
fn every_number_of_rows_at_once_gives_the_same() {
    let images = boxes(35, 3);
    // 116 rows.
    let frame = frame_of(&images[0], 0.3);
    for own in [None, Some(0)] {
        let source = |(i, ldi)| SourceImage { ldi, is_own: own == Some(i) };
        let sources: Vec<SourceImage> = images.iter().enumerate().map(source).collect();
        for published in [false, true] {
            combined_in_any_parts(&frame, &sources, &Combining { published, ..Combining::default() });
        }
    }
}

#[test]
fn large_source_pixels_are_found_across_borders_of_parts() {
    let mut images = boxes(36, 2);
    let Ldi { camera, pose, gain, .. } = images[0];
    // Source pixels of eight pixels, of known planes and of unknown ones.
    let Pinhole { width, height, fx, fy, cx, cy } = camera;
    let [fx, fy, cx, cy] = [fx, fy, cx, cy].map(|value| 8.0 * value);
    let large = Pinhole { width: 8 * width, height: 8 * height, fx, fy, cx, cy };
    let frame = CommonCamera::new(large, pose, gain, 0.0, false);
    for is_known in [true, false] {
        if !is_known {
            for image in &mut images {
                image.surfaces.clear();
                image.levels[0].surfaces.fill(0);
            }
        }
        let sources: Vec<SourceImage> = images.iter().map(|ldi| SourceImage { ldi, is_own: false }).collect();
        let all = combined_in_any_parts(&frame, &sources, &Combining::default());
        assert!(all.levels[0].layered() > 32 * images[0].levels[0].layered());
    }
}

#[test]
fn frames_of_one_row_or_column_and_no_sources_are_combined() {
    let images = boxes(37, 2);
    let sources: Vec<SourceImage> = images.iter().map(|ldi| SourceImage { ldi, is_own: false }).collect();
    let Ldi { camera, pose, gain, .. } = images[0];
    for (width, height) in [(1, 72), (96, 1), (1, 1)] {
        let frame = CommonCamera::new(Pinhole { width, height, ..camera }, pose, gain, 0.0, false);
        let all = combined_in_any_parts(&frame, &sources, &Combining::default());
        assert_eq!(all.levels[0].rows.len(), height as usize + 1);
        assert!(combined_in_any_parts(&frame, &[], &Combining::default()).levels[0].is_empty());
    }
}

#[test]
fn every_number_of_threads_gives_the_same() {
    let images = boxes(34, 3);
    let frame = frame_of(&images[0], 0.3);
    let sources: Vec<SourceImage> =
        images.iter().enumerate().map(|(i, ldi)| SourceImage { ldi, is_own: i == 0 }).collect();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| combined(&frame, &sources, &Combining::default()))
    };
    let one = with(1);
    assert!([2, 3, 16].into_iter().all(|threads| with(threads) == one));
}

#[test]
fn what_the_reference_camera_hid_comes_from_others() {
    let images = boxes(35, 4);
    let own = &images[0];
    let sources: Vec<SourceImage> =
        images.iter().enumerate().map(|(i, ldi)| SourceImage { ldi, is_own: i == 0 }).collect();
    let all = combined(&frame_of(own, 0.0), &sources, &Combining::default());
    let level = &all.levels[0];
    let hidden = (0..level.len()).filter(|i| level.pixel(*i).splat.origin() == DepthPixelOrigin::OtherPhotos);
    assert!(hidden.count() > 200, "{}", level.len());
    assert_eq!(all.sources, ["0.png", "1.png", "2.png", "3.png"]);
    // Of everything that was collected, each sample has become something.
    let report = &all.report;
    assert_eq!(report.samples, report.merged + report.dropped + level.len() as u64);
}

#[test]
fn surfaces_have_their_planes_in_the_common_camera() {
    let images = boxes(36, 3);
    let frame = frame_of(&images[0], 0.25);
    let sources: Vec<SourceImage> =
        images.iter().enumerate().map(|(i, ldi)| SourceImage { ldi, is_own: i == 0 }).collect();
    // Samples of different surfaces stay apart, since their mean is on neither plane.
    let merging = Merging { epsilon: 1e-7, slopes: false, ..Merging::default() };
    let all = combined(&frame, &sources, &Combining { merging, published: false });
    let level = &all.levels[0];
    let mut tested = 0;
    for y in 0..level.camera.height {
        for index in level.row(y) {
            let pixel = level.pixel(index);
            let Some(surface) = usize::from(pixel.surface).checked_sub(1) else { continue };
            let nu = all.surfaces[surface].nu;
            let at = DVec2::new(f64::from(level.columns[index]) + 0.5, f64::from(y) + 0.5);
            let expected = nu.dot(at.extend(1.0));
            // Samples of narrow pixels are anywhere in their pixel, on their plane.
            let within = 0.5 * (nu.x.abs() + nu.y.abs()) + 1e-5 * expected.abs();
            assert!((f64::from(pixel.inverse_depth) - expected).abs() <= within, "{pixel:?} {expected}");
            tested += 1;
        }
    }
    assert!(tested > 5000);
}

/// Returns a depth image of a wall at depth 5, seen by `camera` from `pose`.
fn wall(camera: Pinhole, pose: Pose) -> Ldi {
    let scene = closed_form::two_quads();
    let colour =
        |_: usize, point: DVec3| [(point.x * 40.0 + 128.0) as u8, (point.y * 40.0 + 128.0) as u8, 0, 255];
    of_model(&scene.model, camera, pose, colour).depth_image()
}

#[test]
fn a_coarse_source_has_no_cracks_unless_it_is_published_also_where_its_pixels_are_long() {
    let scene = closed_form::two_quads();
    let pose = scene.photo().pose;
    let fine = Pinhole { width: 120, height: 90, fx: 120.0, fy: 120.0, cx: 60.0, cy: 45.0 };
    let truth = wall(fine, pose);
    let frame = frame_of(&truth, 0.0);
    let covered = |coarse: Pinhole, published: bool| {
        let source = wall(coarse, pose);
        let combining = Combining { published, ..Combining::default() };
        let all = combined(&frame, &[SourceImage { ldi: &source, is_own: false }], &combining);
        // Pixels of the truth that are surrounded by surface, so that the rim of a coarse pixel does not count.
        let (level, rim) = (&all.levels[0], (fine.fy / coarse.fy) as u32);
        let (mut inside, mut held) = (0, 0);
        for (y, x) in (rim..90 - rim).flat_map(|y| (rim..120 - rim).map(move |x| (y, x))) {
            let around = || (y - rim..=y + rim).flat_map(|y| (x - rim..=x + rim).map(move |x| (x, y)));
            if around().all(|(x, y)| !truth.levels[0].at(x, y).is_empty()) {
                inside += 1;
                held += usize::from(!level.at(x, y).is_empty());
            }
        }
        (inside, held)
    };
    let third = Pinhole { width: 40, height: 30, fx: 40.0, fy: 40.0, cx: 20.0, cy: 15.0 };
    let long = Pinhole { height: 12, fy: 15.0, cy: 5.625, ..fine };
    for coarse in [third, long] {
        let (inside, held) = covered(coarse, false);
        assert!(inside > 1000);
        assert_eq!(inside, held, "{coarse:?}");
    }
    let (inside, held) = covered(third, true);
    assert!(held < inside / 4, "one sample a source pixel leaves 8 of 9 pixels empty");
}

#[test]
fn each_pixel_whose_centre_a_source_covers_has_one_sample_there() {
    let camera = |scale: f64| {
        let [width, height] = [60.0, 45.0].map(|side: f64| (side * scale).round());
        Pinhole {
            width: width as u32,
            height: height as u32,
            fx: 60.0 * scale,
            fy: 60.0 * scale,
            cx: width / 2.0,
            cy: height / 2.0,
        }
    };
    let own = closed_form::two_quads().photo().pose;
    let truth = wall(camera(1.0), own);
    // Rolled, turned aside, and from another place.
    let (roll, turn) = (DMat3::from_rotation_z(0.6), DMat3::from_rotation_y(0.25));
    let from = |rotation: DMat3, eye: DVec3| Pose { rotation, translation: rotation * -eye };
    let poses = [
        from(DMat3::IDENTITY, DVec3::new(0.31, 0.17, 0.0)),
        from(roll, DVec3::new(0.2, 0.0, -0.3)),
        from(turn * roll, DVec3::new(2.0, 0.5, -0.5)),
    ];
    for (pose, scale) in poses.into_iter().flat_map(|pose| [0.55, 1.0, 1.3].map(|scale| (pose, scale))) {
        let source = wall(camera(scale), pose);
        let merging = Merging { epsilon: 1e-6, slopes: false, ..Merging::default() };
        let combining = Combining { merging, published: false };
        let all =
            combined(&frame_of(&truth, 0.0), &[SourceImage { ldi: &source, is_own: false }], &combining);
        let (level, expected) = (&all.levels[0], &truth.levels[0]);
        let transfer = Transfer::new(&truth.camera, &truth.pose, &source.camera, &source.pose);
        let mut compared = 0;
        // More than the neighbours of a pixel of the source, also along a diagonal.
        let reach = (1.5f64 / scale).ceil() as u32 + 1;
        for (x, y) in (reach..45 - reach).flat_map(|y| (reach..60 - reach).map(move |x| (x, y))) {
            // Where the truth has one surface all around, and the source sees it.
            let index = expected.at(x, y).start;
            let around = (y - reach..=y + reach).flat_map(|y| (x - reach..=x + reach).map(move |x| (x, y)));
            let is_same = |(x, y): (u32, u32)| {
                let of = expected.at(x, y);
                !of.is_empty() && expected.surfaces[of.start] == expected.surfaces[index]
            };
            if expected.at(x, y).is_empty() || !around.into_iter().all(is_same) {
                continue;
            }
            let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let depth = expected.inverse_depths[index];
            let there = transfer.position(at, f64::from(depth)).map(|(position, _)| position);
            let size = DVec2::new(f64::from(source.camera.width), f64::from(source.camera.height));
            let Some(there) =
                there.filter(|there| there.cmpge(DVec2::ONE).all() && there.cmplt(size - 1.0).all())
            else {
                continue;
            };
            let seen = source.levels[0].at(there.x as u32, there.y as u32).any(|other| {
                let of = |ldi: &Ldi, surface: u16| ldi.surfaces[usize::from(surface) - 1].object.clone();
                of(&source, source.levels[0].surfaces[other]) == of(&truth, expected.surfaces[index])
            });
            if !seen {
                continue;
            }
            let found = level.at(x, y).find(|i| (level.inverse_depths[*i] / depth - 1.0).abs() < 1e-5);
            let found = found.unwrap_or_else(|| panic!("{scale}: {x}, {y} has no sample at its centre"));
            // A pixel of the source has up to 12 steps. Light is interpolated, where the ramp is one of stored values that are
            // rounded down: that makes two steps where it is not dark.
            for (a, b) in level.colours[found].into_iter().zip(expected.colours[index]).take(2) {
                assert!(!(60..225).contains(&b) || a.abs_diff(b) <= 2, "{scale}: {x}, {y}: {a} and {b}");
            }
            compared += 1;
        }
        assert!(compared > 200, "{scale}: {compared}");
        let (samples, pixels) = (all.report.samples as f64, level.len() as f64);
        // Those where two source pixels meet, nearly, have two; where rows are parallel, these may be a whole row.
        assert!(samples < 1.1 * pixels, "{scale}: {samples} samples of {pixels} pixels");
    }
}

#[test]
fn a_source_of_unknown_planes_with_errors_of_depth_has_no_holes() {
    let camera = Pinhole { width: 60, height: 80, fx: 60.0, fy: 60.0, cx: 30.0, cy: 40.0 };
    let own = closed_form::two_quads().photo().pose;
    let frame = frame_of(&wall(camera, own), 0.0);
    let eye = DVec3::new(0.6, 0.3, 0.5);
    let mut rng = Rng::new(41);
    let mut source = wall(Pinhole { fx: 58.0, fy: 58.0, ..camera }, Pose { translation: -eye, ..own });
    source.surfaces.clear();
    let level = &mut source.levels[0];
    level.surfaces.fill(0);
    // Of the parallax of 4 pixels at depth 10, two hundredths of a pixel.
    level.inverse_depths.iter_mut().for_each(|depth| *depth *= 1.0 + rng.between(-0.005, 0.005) as f32);
    let all = combined(&frame, &[SourceImage { ldi: &source, is_own: false }], &Combining::default());
    // The near quad is in front of x from 0 to 4 and y from -2 to 2, 8 away.
    let at = |x: f64, y: f64| ((30.0 + 60.0 * x / 8.0) as u32, (40.0 + 60.0 * y / 8.0) as u32);
    let ((left, top), (right, bottom)) = (at(0.5, -1.5), at(3.5, 1.5));
    for (x, y) in (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y))) {
        assert!(!all.levels[0].at(x, y).is_empty(), "{x}, {y}");
    }
}

#[test]
fn colours_come_in_the_exposure_of_the_reference_camera() {
    let mut images = boxes(37, 2);
    let level = &mut images[1].levels[0];
    let brighter = quadratura_base::scene::light::bytes_of_light_times(0.5f64.exp());
    // Half a natural logarithm more light, as the gain says; no value is so bright that it would be clipped.
    level.colours.iter_mut().for_each(|c| (0..3).for_each(|i| c[i] = brighter[usize::from(c[i])]));
    images[1].gain = [0.5; 3];
    let plain = boxes(37, 2);
    let of = |images: &[Ldi]| {
        let sources = [0, 1].map(|i| SourceImage { ldi: &images[i], is_own: i == 0 });
        combined(&frame_of(&images[0], 0.0), &sources, &Combining::default())
    };
    let (same, expected) = (of(&images), of(&plain));
    assert_eq!(same.levels[0].columns, expected.levels[0].columns);
    let off = |i: usize| {
        let (a, b) = (same.levels[0].colours[i], expected.levels[0].colours[i]);
        (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0)
    };
    // Stored values were rounded twice, and dark ones lie far apart.
    assert!((0..same.levels[0].len()).all(|i| off(i) <= 2));
}

/// Returns a depth image of one row of depth pixels at these depths; none where a depth is 0.
fn row_of_depths(depths: &[f64]) -> Ldi {
    let camera = centred(depths.len() as u32, 1, 10.0);
    let pixel = |depth: f64| DepthPixel {
        inverse_depth: (1.0 / depth) as f32,
        colour: [(depth * 20.0) as u8, 0, 0, 255],
        surface: 0,
        splat: crate::Splat(0),
    };
    let row = (0..).zip(depths).filter(|(_, d)| **d > 0.0).map(|(x, depth)| (x, pixel(*depth))).collect();
    let unfinished = Unfinished {
        kind: LdiKind::Depth,
        inputs: String::new(),
        camera,
        pose: quadratura_base::scene::synthetic::camera_is_world(),
        photo_rect: None,
        gain: [0.0; 3],
        surfaces: Vec::new(),
        sources: vec!["row".into()],
        rows: vec![row],
        counts: SampleCounts::default(),
        options: BTreeMap::new(),
    };
    unfinished.finish(&Task::silent()).unwrap()
}

#[test]
fn the_published_rule_takes_samples_in_turn_and_means_of_stored_values() {
    let images = [row_of_depths(&[2.0, 3.0]), row_of_depths(&[2.01, 0.0]), row_of_depths(&[2.1, 3.2])];
    let sources: Vec<SourceImage> =
        images.iter().enumerate().map(|(i, ldi)| SourceImage { ldi, is_own: i == 0 }).collect();
    let merging = Merging { epsilon: 0.01, layers: 10, ..Merging::default() };
    let published = Combining { merging, published: true };
    let all = combined(&frame_of(&images[0], 0.0), &sources, &published);
    let level = &all.levels[0];
    let depths: Vec<f64> = level.inverse_depths.iter().map(|d| f64::from(d.recip())).collect();
    let expected = [2.005, 2.1, 3.0, 3.2];
    assert!(depths.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{depths:?}");
    assert_eq!(level.colours.iter().map(|c| c[0]).collect::<Vec<_>>(), [40, 42, 60, 64]);
    assert_eq!((all.report.merged, all.report.dropped), (1, 0));
    let one = Combining { merging: Merging { layers: 1, ..merging }, published: true };
    let first = combined(&frame_of(&images[0], 0.0), &sources, &one);
    assert_eq!((first.levels[0].len(), first.report.merged, first.report.dropped), (2, 1, 2));
}
