//! The GPU against its plain twin. The graph is compared exactly, on the GPU's own fragment lists;
//! coverage apart, because a GPU moves corners to a grid of sub-pixels before it fills triangles.

use std::collections::BTreeMap;

use crate::common;
use quadratura::task::Task;
use quadratura::testing::geometry::{InverseDepth, PixelRect};
use quadratura::testing::gpu::GpuRasteriser;
use quadratura::testing::layers::rasteriser::{Presence, VISIBLE};
use quadratura::testing::layers::{
    FragmentLists, Fragments, Item, ProjectedModel, Rasteriser, SoftwareRasteriser,
};
use quadratura::testing::layers::{Occlusion, is_behind};
use quadratura::testing::scene::FaceId;
use quadratura::testing::scene::synthetic::{Rng, Scene, closed_form, large, random};

const TOLERANCE: f32 = 1e-4;

/// With pass *pairs*, on software adapters too.
fn rasteriser() -> Option<GpuRasteriser> {
    common::gpu_rasteriser().map(|rasteriser| rasteriser.counting_pairs_on_device(true))
}

fn view(scene: &Scene) -> ProjectedModel {
    ProjectedModel::new(&scene.model, &scene.camera, &scene.pose)
}

fn draw(rasteriser: &dyn Rasteriser, view: &ProjectedModel) -> Fragments {
    rasteriser.fragments(view, TOLERANCE, &Task::silent()).expect("the device works")
}

fn random_scenes(count: u64) -> impl Iterator<Item = Scene> {
    (0..count).map(|seed| match seed % 2 {
        0 => random::soup(seed, 10 + (seed % 7) as u32 * 10),
        _ => random::boxes(seed, 2 + (seed % 5) as u32),
    })
}

/// Every pixel: column, row, entries sorted.
fn pixels(lists: &FragmentLists) -> impl Iterator<Item = (u32, u32, Vec<u32>)> + '_ {
    let rows = lists.bands.iter().flat_map(|band| (band.y0..band.y1).map(move |y| (band, y)));
    rows.flat_map(move |(band, y)| {
        (0..lists.width).map(move |x| {
            let mut entries = lists.pixel(band, x, y).to_vec();
            entries.sort_by_key(|entry| entry & !VISIBLE);
            (x, y, entries)
        })
    })
}

/// The table of pairs, pixel by pixel.
fn recounted(view: &ProjectedModel, lists: &FragmentLists) -> Vec<Occlusion> {
    let mut table = BTreeMap::new();
    for (x, y, entries) in pixels(lists) {
        let items: Vec<u32> = entries.iter().map(|entry| entry & !VISIBLE).collect();
        let depth = |item: u32| view.items[item as usize].inverse_depth.at(x, y);
        for (&front, &back) in items.iter().flat_map(|front| items.iter().map(move |back| (front, back))) {
            if is_behind(depth(back), depth(front), TOLERANCE) {
                *table.entry((front, back)).or_insert(0) += 1;
            }
        }
    }
    table.into_iter().map(|((front, back), px)| Occlusion { front, back, px }).collect()
}

/// Everything that follows from the lists alone.
fn assert_consistent(name: &str, view: &ProjectedModel, drawn: &Fragments) {
    assert_eq!(drawn.occlusions, recounted(view, &drawn.lists), "{name}: the table of pairs");
    let mut rows = 0;
    for band in &drawn.lists.bands {
        assert_eq!(band.y0, rows, "{name}: bands leave no gaps");
        rows = band.y1;
    }
    assert_eq!(rows, view.height, "{name}: bands end with the photo");
    let mut seen = vec![(false, None); view.items.len()];
    for (x, y, entries) in pixels(&drawn.lists) {
        let depth = |entry: &u32| view.items[(entry & !VISIBLE) as usize].inverse_depth.at(x, y);
        let nearest = entries.iter().map(depth).fold(0.0, f32::max);
        for entry in &entries {
            let visible = !is_behind(depth(entry), nearest, TOLERANCE);
            assert_eq!(entry & VISIBLE != 0, visible, "{name}: the visible bit at {x}, {y}");
            let item = &mut seen[(entry & !VISIBLE) as usize];
            item.0 |= visible;
            item.1.get_or_insert((x, y));
        }
    }
    for (item, (visible, covered)) in seen.iter().enumerate() {
        let working = drawn.presence[item] == Presence::Working;
        assert_eq!((working, working), (*visible, covered.is_some()), "{name}: item {item}");
    }
}

#[test]
fn a_photo_that_sees_nothing_is_drawn_like_any_other() {
    let Some(gpu) = common::gpu_rasteriser() else { return };
    let scene = random::soup(1, 10);
    let seen = view(&scene);
    let nothing =
        ProjectedModel { width: 40, height: 30, largest_inverse_depth: 1.0, ..ProjectedModel::default() };
    let outside = seen.corners.iter().map(|triangle| triangle.map(|[x, y, w]| [x + 9.0 * w.abs(), y, w]));
    let beside = ProjectedModel { corners: outside.collect(), ..seen.clone() };
    for (name, view) in [("no items", nothing), ("items beside the photo", beside)] {
        let (drawn, twin) = (draw(&gpu, &view), draw(&SoftwareRasteriser, &view));
        assert!(drawn.lists.is_empty() && drawn.occlusions.is_empty(), "{name}");
        assert_eq!(drawn.presence, twin.presence, "{name}");
        assert_consistent(name, &view, &drawn);
        let none = vec![true; view.items.len()];
        let behind = gpu.occluded(&view, TOLERANCE, &none, &[]).expect("the device works");
        assert!(behind.iter().all(|behind| !behind), "{name}");
        gpu.stencil_peeling(&view, TOLERANCE, &none, &Task::silent()).expect("the device works");
    }
}

/// Items of every pixel, rising, without those that only one of the two has in its working set
/// (visible at edge pixels only).
fn covers(drawn: &Fragments, other: &Fragments) -> Vec<Vec<u32>> {
    let common = |item: &u32| {
        [drawn, other].iter().all(|fragments| fragments.presence[*item as usize] == Presence::Working)
    };
    pixels(&drawn.lists)
        .map(|(_, _, entries)| entries.iter().map(|entry| entry & !VISIBLE).filter(common).collect())
        .collect()
}

/// Compares the two on one scene; returns pixels that differ, and all covered ones.
fn compare(rasteriser: &GpuRasteriser, scene: &Scene) -> (u64, u64) {
    let view = view(scene);
    let (drawn, plain) = (draw(rasteriser, &view), draw(&SoftwareRasteriser, &view));
    assert_consistent(&scene.name, &view, &drawn);
    assert_eq!(plain.occlusions, recounted(&view, &plain.lists), "{}: the twin's table", scene.name);
    let (here, there) = (covers(&drawn, &plain), covers(&plain, &drawn));
    let width = view.width as usize;
    let mut differing = 0;
    for pixel in (0..there.len()).filter(|&pixel| here[pixel] != there[pixel]) {
        let (x, y) = (pixel % width, pixel / width);
        let around = (y.saturating_sub(1)..=y + 1).flat_map(|y| {
            (x.saturating_sub(1)..=x + 1).filter_map(move |x| (x < width).then_some(y * width + x))
        });
        let at_an_edge = around
            .filter_map(|near| there.get(near))
            .any(|items| *items == here[pixel] || *items != there[pixel]);
        assert!(
            at_an_edge,
            "{}: {x}, {y} is away from all edges: {:?}, {:?}",
            scene.name, here[pixel], there[pixel]
        );
        differing += 1;
    }
    (differing, there.iter().filter(|items| !items.is_empty()).count() as u64)
}

#[test]
fn the_table_of_pairs_is_that_of_the_lists_on_hundreds_of_random_scenes() {
    let Some(rasteriser) = rasteriser() else { return };
    let (mut differing, mut all) = (0, 0);
    for scene in random_scenes(300) {
        let (here, covered) = compare(&rasteriser, &scene);
        differing += here;
        all += covered;
    }
    let share = differing as f64 / all as f64;
    println!("{differing} of {all} covered pixels differ from the twin's: {share:.6}");
    // llvmpipe was seen to differ at 0.006 %; other hardware may round vertices to another grid.
    assert!(share < 0.001, "{differing} of {all} covered pixels differ from the twin's");
}

#[test]
fn closed_form_scenes_look_alike_to_both() {
    let Some(rasteriser) = rasteriser() else { return };
    for scene in closed_form::all() {
        let (differing, all) = compare(&rasteriser, &scene);
        println!("{}: {differing} of {all}", scene.name);
        // These pictures are small, so that a large share of their pixels lies on edges, where an adapter may round
        // corners to another grid. That it is edges only is asserted in `compare`.
        assert!(differing * 30 <= all, "{}: {differing} of {all} pixels differ", scene.name);
    }
}

#[test]
fn a_street_and_a_town_look_alike_to_both() {
    let Some(rasteriser) = rasteriser() else { return };
    for scene in [large::street(1000).resized(320), large::town(20_000).resized(320)] {
        let (differing, all) = compare(&rasteriser, &scene);
        println!("{}: {differing} of {all}", scene.name);
        // Many thousands of faces in few pixels: as above, edges are a large share.
        assert!(differing * 30 <= all, "{}: {differing} of {all} pixels differ", scene.name);
    }
}

#[test]
fn exact_peeling_marks_the_back_of_every_pair_that_is_not_forgiven() {
    let Some(rasteriser) = rasteriser() else { return };
    for scene in random_scenes(100) {
        let view = view(&scene);
        let drawn = draw(&rasteriser, &view);
        let alive: Vec<bool> = drawn.presence.iter().map(|p| *p == Presence::Working).collect();
        for every in [usize::MAX, 7, 2, 1] {
            let forgiven: Vec<_> =
                drawn.occlusions.iter().step_by(every).map(|pair| (pair.front, pair.back)).collect();
            let forgiven = if every == usize::MAX { Vec::new() } else { forgiven };
            let mut expected = vec![false; view.items.len()];
            for pair in &drawn.occlusions {
                expected[pair.back as usize] |= !forgiven.contains(&(pair.front, pair.back));
            }
            let marked = rasteriser.occluded(&view, TOLERANCE, &alive, &forgiven).expect("the device works");
            assert_eq!(marked, expected, "{}, {} pairs forgiven", scene.name, forgiven.len());
        }
    }
}

#[test]
fn stencil_peeling_finds_the_layers_of_the_twin_where_both_cover_the_same_pixels() {
    let Some(rasteriser) = common::gpu_rasteriser() else { return };
    let (mut compared, mut locked) = (0, 0);
    for scene in random_scenes(150).chain(closed_form::all()) {
        let view = view(&scene);
        let (drawn, plain) = (draw(&rasteriser, &view), draw(&SoftwareRasteriser, &view));
        if !pixels(&drawn.lists).eq(pixels(&plain.lists)) {
            continue;
        }
        let working: Vec<bool> = drawn.presence.iter().map(|p| *p == Presence::Working).collect();
        for tolerance in [TOLERANCE, 0.0] {
            let peel = |rasteriser: &dyn Rasteriser| {
                rasteriser.stencil_peeling(&view, tolerance, &working, &Task::silent()).expect("it works")
            };
            let found = peel(&rasteriser);
            assert_eq!(found, peel(&SoftwareRasteriser), "{}, tolerance {tolerance}", scene.name);
            locked += u32::from(found.locked > 0);
        }
        compared += 1;
    }
    assert!(compared > 50 && locked > 0, "{compared} scenes compared, {locked} locked up");
}

#[test]
fn several_threads_may_draw_at_a_time() {
    let Some(rasteriser) = common::gpu_rasteriser() else { return };
    let views: Vec<ProjectedModel> = random_scenes(12).map(|scene| view(&scene)).collect();
    let sorted = |view: &ProjectedModel| {
        let drawn = draw(&rasteriser, view);
        (drawn.presence.clone(), pixels(&drawn.lists).collect::<Vec<_>>(), drawn.occlusions)
    };
    let alone: Vec<_> = views.iter().map(sorted).collect();
    std::thread::scope(|scope| {
        let together: Vec<_> = views.iter().map(|view| scope.spawn(|| sorted(view))).collect();
        for (alone, together) in alone.iter().zip(together) {
            assert!(
                *alone == together.join().expect("no thread panics"),
                "threads do not disturb each other"
            );
        }
    });
}

#[test]
fn bands_and_parts_change_nothing_but_the_sub_pixel_grid() {
    let Some(rasteriser) = rasteriser() else { return };
    let Some(in_parts) = self::rasteriser().map(|whole| whole.with_limits(3000, 4000)) else { return };
    for scene in random_scenes(20) {
        let view = view(&scene);
        let (whole, parts) = (draw(&rasteriser, &view), draw(&in_parts, &view));
        assert!(parts.lists.bands.len() > whole.lists.bands.len(), "{}: there are parts", scene.name);
        assert_consistent(&scene.name, &view, &parts);
        let (here, there) = (covers(&parts, &whole), covers(&whole, &parts));
        let differing = here.iter().zip(&there).filter(|(here, there)| here != there).count();
        assert!(differing * 100 <= here.len(), "{}: {differing} pixels differ", scene.name);
    }
}

#[test]
fn a_row_that_fits_no_buffer_is_an_error_that_names_it() {
    let Some(rasteriser) = rasteriser().map(|whole| whole.with_limits(3000, 100)) else { return };
    let drawn = rasteriser.fragments(&view(&closed_form::two_quads()), TOLERANCE, &Task::silent());
    let message = drawn.expect_err("100 entries are less than a row").to_string();
    assert!(message.contains("row ") && message.contains("simplify the model"), "{message}");
}

/// Thousands of small upright rectangles at random places and depths: tens of thousands of pairs,
/// though few faces lie behind each other at any one pixel.
fn confetti(count: u32) -> ProjectedModel {
    let mut rng = Rng::new(7);
    let card = |_| {
        let depth = rng.between(2.0, 20.0) as f32;
        let (x, y) = (rng.whole(0, 150) as f32, rng.whole(0, 112) as f32);
        (depth, [x, y, x + 10.0, y + 8.0])
    };
    cards((0..count).map(card))
}

/// A view of 160 x 120 pixels of cards that face it: each has a depth and is seen from these columns and rows to the others.
fn cards(all: impl Iterator<Item = (f32, [f32; 4])>) -> ProjectedModel {
    let mut view =
        ProjectedModel { width: 160, height: 120, largest_inverse_depth: 1.0, ..ProjectedModel::default() };
    for (item, (depth, [left, top, right, bottom])) in (0..).zip(all) {
        let corner = |x: f32, y: f32| [(x / 80.0 - 1.0) * depth, (1.0 - y / 60.0) * depth, depth];
        let [a, b, c, d] =
            [corner(left, top), corner(left, bottom), corner(right, bottom), corner(right, top)];
        let inverse_depth = InverseDepth { a: 0.0, b: 0.0, c: 1.0 / depth, u0: 80.0, v0: 60.0 };
        let (face, bounds) = (FaceId(item), PixelRect::from_edges(0, 0, 160, 120));
        view.items.push(Item {
            face,
            triangle: None,
            inverse_depth,
            back: false,
            bounds,
            see_through: false,
        });
        view.corners.extend([[a, b, c], [a, c, d]]);
        view.triangle_items.extend([item; 2]);
    }
    view
}

#[test]
fn pairs_of_deep_piles_are_counted_with_those_of_shallow_ones() {
    let Some(on_device) = rasteriser() else { return };
    let Some(on_processor) = common::gpu_rasteriser().map(|here| here.counting_pairs_on_device(false)) else {
        return;
    };
    // 10 cards lie over each other in the rows above, 150 in those below: more than a device counts without a pause.
    let pile = |count: u32, top: f32, bottom: f32| {
        (0..count).map(move |card| (2.0 + 0.1 * card as f32, [0.0, top, 160.0, bottom]))
    };
    let view = cards(pile(10, 0.0, 40.0).chain(pile(150, 40.0, 120.0)));
    let alive = vec![true; view.items.len()];
    let nobody = (u32::MAX, u32::MAX);
    // All but the first of each pile are behind another.
    let expected: Vec<bool> = (0..160).map(|item| !matches!(item, 0 | 10)).collect();
    for rasteriser in [&on_device, &on_processor] {
        let behind = rasteriser.occluded(&view, TOLERANCE, &alive, &[nobody]).expect("the device works");
        assert_eq!(behind, expected);
    }
    assert_eq!(draw(&on_device, &view).occlusions, draw(&on_processor, &view).occlusions);
}

#[test]
fn a_table_that_is_too_small_grows() {
    let Some(rasteriser) = rasteriser() else { return };
    let view = confetti(4000);
    let alive = vec![true; view.items.len()];
    let nobody = (u32::MAX, u32::MAX);
    // With a pair to forgive, even a pair of nobody, all pairs are counted: more than the 65,536
    // slots that the table begins with.
    let [quick, counted] = [&[][..], &[nobody]]
        .map(|forgiven| rasteriser.occluded(&view, TOLERANCE, &alive, forgiven).expect("the table grows"));
    assert!(quick == counted, "pairs are lost");
}

#[test]
fn faces_that_lie_behind_each_other_by_the_hundred_lose_no_pair() {
    let Some(rasteriser) = common::gpu_rasteriser() else { return };
    let view = view(&random::soup(1, 900));
    let alive = vec![true; view.items.len()];
    let nobody = (u32::MAX, u32::MAX);
    let [quick, counted] = [&[][..], &[nobody]]
        .map(|forgiven| rasteriser.occluded(&view, TOLERANCE, &alive, forgiven).expect("the device works"));
    assert!(quick == counted, "pairs are lost");
}

#[test]
fn the_table_is_the_same_wherever_it_is_counted() {
    let Some(rasteriser) = common::gpu_rasteriser() else { return };
    let on_device = rasteriser.counting_pairs_on_device(true);
    let view = view(&large::street(1000).resized(640));
    let there = draw(&on_device, &view);
    let here = draw(&on_device.counting_pairs_on_device(false), &view);
    assert_eq!(there.occlusions, here.occlusions);
}
