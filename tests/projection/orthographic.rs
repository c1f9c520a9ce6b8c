//! Orthographic views: the device, which draws parallel rays, against the twin, which looks from far away, and what parallel means.

use glam::DVec3;

use quadratura::task::Task;
use quadratura::testing::projection::relief::Relief;
use quadratura::testing::projection::{Renders, Storage, TextureOptions};
use quadratura::testing::scene::FaceId;
use quadratura::testing::view::{Exposure, Mode, PicturePlane, Quality, Shot};

use crate::bench::Bench;
use crate::gpu_twin::{difference, hills};

/// The front of the church: the plane y = 14 of the sample project, 13 m wide and 15.2 m high.
fn facade() -> PicturePlane {
    let middle = DVec3::new(-1.5, 14.0, 7.6);
    PicturePlane { middle, right: DVec3::X, down: DVec3::NEG_Z }
}

/// The extent of the sample project's model.
const EXTENT: f64 = 130.0;

/// A view of the facade, finer than photos, so that every lookup is at level 0, without the faces that are wholly in front of it: the twin
/// does not know where a picture begins.
fn close_up(bench: &Bench, middle: DVec3) -> Shot {
    let plane = PicturePlane { middle, ..facade() };
    let shot = Shot::orthographic(&plane, [240, 160], 900.0, EXTENT, None);
    let model = &bench.site.model;
    let is_in_front = |face: &FaceId| model.ring_points(*face).all(|corner| shot.depth_of(corner) < -0.1);
    let hidden = model.face_ids().filter(is_in_front).collect();
    Shot { exposure: Exposure::Common, hidden, ..shot }
}

#[test]
fn the_gpu_and_its_twin_show_an_orthographic_facade_alike_flat_and_with_relief() {
    let Some(bench) = Bench::piazza(&["01", "02", "03", "08"]) else { return };
    for relief in [Relief::default(), hills(&bench.site.model)] {
        for (mode, middle) in [
            (Mode::Smooth, DVec3::new(-4.5, 14.0, 6.0)),
            (Mode::Lumigraph, DVec3::new(2.5, 14.0, 8.0)),
            (Mode::Best, DVec3::new(-1.5, 14.0, 13.0)),
        ] {
            let mut shot = close_up(&bench, middle);
            (shot.blend.mode, shot.quality) = (mode, Quality::Final);
            let found = difference(&mut bench.renderer(&relief), &mut bench.twin(&relief), &shot);
            println!("{mode}: {found}");
            assert!(found.flipped < 0.005 * found.pixels, "{mode}: faces differ: {found}");
            assert!(found.display > 0.3 * found.pixels, "{mode}: next to nothing shown: {found}");
            assert!(found.far < 0.002 * found.pixels && found.mean() < 0.75, "{mode}: {found}");
        }
    }
}

#[test]
fn faces_of_an_orthographic_view_are_where_the_model_has_them_to_a_pixel_whatever_their_depth() {
    let Some(bench) = Bench::piazza(&["01", "02"]) else { return };
    let (width, px_per_unit) = (1300u32, 50.0);
    let plane = facade();
    let shot = Shot::orthographic(&plane, [width, 760], px_per_unit, EXTENT, None);
    let faces = bench.renderer(&Relief::default()).faces(&shot, &Task::silent()).unwrap();
    let model = &bench.site.model;
    // The campanile is 19 m behind the facade's plane, and drawn in the same scale.
    let shaft = model.object_named("campanile.shaft").unwrap();
    let of_shaft = |number: &u32| *number > 0 && model.faces[*number as usize - 1].object == shaft;
    let row = &faces[300 * width as usize..301 * width as usize];
    let seen: Vec<usize> = (0..row.len()).filter(|x| of_shaft(&row[*x])).collect();
    let corners = model.object(shaft).faces.iter().flat_map(|face| model.ring_points(*face));
    let at = |corner: DVec3| (corner - plane.middle).dot(plane.right) * px_per_unit + 0.5 * f64::from(width);
    let (low, high) = corners.map(at).fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
    let (first, last) = (*seen.first().unwrap() as f64, *seen.last().unwrap() as f64 + 1.0);
    println!("the shaft is seen from {first} to {last}, and spans {low:.2} to {high:.2}");
    assert!(high.min(f64::from(width)) - last < 1.0 && (last - high).abs() <= 1.0, "{last} and {high}");
    assert!(first >= low - 1.0);
}

#[test]
fn what_is_in_front_of_where_the_picture_begins_is_left_out() {
    let Some(bench) = Bench::piazza(&["01", "02"]) else { return };
    let count = |from_depth| {
        let shot = Shot::orthographic(&facade(), [260, 304], 20.0, EXTENT, from_depth);
        let faces = bench.renderer(&Relief::default()).faces(&shot, &Task::silent()).unwrap();
        let model = &bench.site.model;
        let facade = model.object_named("church.facade").unwrap();
        let of_facade = |number: &&u32| **number > 0 && model.faces[**number as usize - 1].object == facade;
        faces.iter().filter(of_facade).count()
    };
    let (all, cut) = (count(None), count(Some(-1.0)));
    println!("of the facade {all} pixels are seen from afar, {cut} from a metre in front");
    assert!(cut > all + 1000, "trees and houses stand in front of it: {all} and {cut}");
}

#[test]
fn tiles_of_an_orthographic_picture_are_the_picture() {
    let Some(bench) = Bench::piazza(&["01", "02"]) else { return };
    let shot = Shot {
        exposure: Exposure::Common,
        ..Shot::orthographic(&facade(), [1300, 1520], 100.0, EXTENT, Some(-1.0))
    };
    let mut renderer = bench.renderer(&Relief::default());
    let whole = renderer.picture(&shot, &Task::silent()).unwrap();
    let mut sliced = renderer.begin(&shot, &Task::silent()).unwrap();
    let (mut rows, mut parts) = (Vec::new(), 0);
    while !renderer.advance(&mut sliced, &Task::silent()).unwrap() {
        rows.extend(sliced.take_rows());
        parts += 1;
    }
    rows.extend(sliced.take_rows());
    assert!(parts > 1, "it was drawn at once");
    let apart = rows.iter().zip(&whole.rgba).filter(|(a, b)| a.abs_diff(**b) > 1).count();
    assert_eq!(rows.len(), whole.rgba.len());
    // Positions are rounded relative to a tile's corner, so that a few samples at outlines fall to the other side.
    assert!(100_000 * apart < rows.len(), "{apart} of {}", rows.len());
}

/// Draws a view in slices with texture memory of so many tiles; returns whether it is said that this is not enough.
fn drawn_within(bench: &Bench, tiles: u64, shot: &Shot) -> (Vec<u8>, bool) {
    let budget_bytes = tiles * Storage::Plain.slot_bytes();
    let textures = TextureOptions { budget_bytes, ..TextureOptions::default() };
    let (mut renderer, task) = (bench.renderer_within(textures), Task::silent());
    let mut sliced = renderer.begin(shot, &task).unwrap().alone_within(&textures);
    while !renderer.advance(&mut sliced, &task).unwrap() {}
    let is_coarser = sliced.is_coarser();
    (sliced.picture().rgba, is_coarser)
}

/// The shares of bytes that differ at all, and by more than bands that begin at other rows make of positions of 24 bits.
fn apart(a: &[u8], b: &[u8]) -> [f64; 2] {
    let share = |more_than: u8| {
        let differ = a.iter().zip(b).filter(|(a, b)| a.abs_diff(**b) > more_than).count();
        differ as f64 / a.len() as f64
    };
    [share(0), share(2)]
}

#[test]
fn little_memory_shows_the_same_in_smaller_bands_and_far_too_little_is_said() {
    let Some(bench) = Bench::piazza(&["01", "02", "03", "08"]) else { return };
    let of_size = |size_px| {
        let shot = Shot::orthographic(&facade(), size_px, 100.0, EXTENT, None);
        Shot { exposure: Exposure::Common, supersampled: false, ..shot }
    };
    let shot = of_size([1300, 760]);
    let (enough, is_coarser) = drawn_within(&bench, 100_000, &shot);
    assert!(!is_coarser);
    for tiles in [500, 100] {
        let (little, is_coarser) = drawn_within(&bench, tiles, &shot);
        let [differ, far] = apart(&enough, &little);
        println!("{tiles} tiles: shares of bytes that differ: {differ:.2e}, by more than 2: {far:.2e}");
        // At edges of faces a sample may fall on the other side.
        assert!(!is_coarser && differ < 5e-4 && far < 5e-6, "{tiles}: {differ}, {far}");
    }
    // Drawn as a whole it is coarser with as little memory, so that bands are what makes them the same.
    let textures = TextureOptions { budget_bytes: 100 * Storage::Plain.slot_bytes(), ..Default::default() };
    let whole = bench.renderer_within(textures).picture(&shot, &Task::silent()).unwrap();
    let [_, far] = apart(&enough, &whole.rgba);
    assert!(far > 0.01, "as a whole: {far}");
    assert!(drawn_within(&bench, 2, &of_size([100, 50])).1, "two tiles are not enough for anything");
}
