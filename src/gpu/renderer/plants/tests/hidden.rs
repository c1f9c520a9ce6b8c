//! Tests of samples of trees that are left out because they are hidden.

use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

use glam::{DAffine3, DVec3};

use super::super::flakes::Flakes;
use super::{oak, placed, renderer, with_images};
use crate::left_out::on_adapter;
use crate::readback;
use crate::{Gpu, Renderer};
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::Model;
use quadratura_base::scene::synthetic::{Modeller, centred, look_at};
use quadratura_base::task::Task;
use quadratura_foliage::{PlacedTrees, Plant, Tree, WalkOptions};
use quadratura_projection::Renders;
use quadratura_view::{Quality, Shot};

/// A row of oaks, each so many radii behind the one before it and a little aside.
pub fn row(plant: &Plant, count: u32, apart: f64) -> PlacedTrees {
    let mut placed = with_images(placed(plant.clone()));
    let radius = plant.whole().bounds.ball.radius;
    let tree = |number: u32| {
        let at = radius * DVec3::new(0.05 * f64::from(number % 3), apart * f64::from(number), 0.0);
        let name = format!("tree {number}");
        Tree { number, name, world_from_plant: DAffine3::from_translation(at), ..placed.trees[0].clone() }
    };
    placed.trees = (0..count).map(tree).collect();
    placed
}

/// A view along the row, with trees in the size of the picture and smaller.
fn along(plant: &Plant, quality: Quality) -> Shot {
    let ball = plant.whole().bounds.ball;
    let eye = ball.middle - 4.0 * ball.radius * DVec3::Y;
    Shot { quality, ..Shot::new(centred(240, 200, 250.0), look_at(eye, ball.middle)) }
}

/// Returns whether each block of samples of the last picture was hidden.
fn hidden(gpu: &Gpu, renderer: &Renderer) -> Vec<bool> {
    hidden_of(gpu, &renderer.plants.as_ref().unwrap().view.flakes)
}

fn hidden_of(gpu: &Gpu, flakes: &Flakes) -> Vec<bool> {
    let jobs = flakes.batches.iter().flatten();
    let flags = |jobs: &Range<u32>| {
        let range = u64::from(jobs.start)..u64::from(jobs.end);
        let [words] = readback::read(gpu, [(&flakes.is_hidden, range)]).unwrap();
        words.into_iter().map(|word| word != 0)
    };
    jobs.filter(|jobs| jobs.start < jobs.end).flat_map(flags).collect()
}

/// How the images of trees are drawn.
#[derive(Debug, Clone, Copy)]
struct How {
    leaves_out: bool,
    least_of_batch: usize,
    /// Bytes.
    most_of_band: u64,
}

/// Without tests, in the same batches as [`TESTED`].
const ALL: How = How { leaves_out: false, ..TESTED };
/// With tests, in batches that are small enough for a few trees.
const TESTED: How = How { leaves_out: true, least_of_batch: 8, most_of_band: u64::MAX };

fn set(flakes: &mut Flakes, how: How) {
    let How { leaves_out, least_of_batch, most_of_band } = how;
    (flakes.leaves_out, flakes.least_of_batch) = (leaves_out, least_of_batch);
    flakes.most_of_band = flakes.most_of_band.min(most_of_band);
}

fn count(hidden: &[bool]) -> usize {
    hidden.iter().filter(|hidden| **hidden).count()
}

#[test]
fn samples_behind_others_are_left_out_and_no_pixel_changes() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let plant = oak();
    let placed = row(&plant, 16, 0.3);
    let narrow = gpu.without_wide_atomics();
    for (gpu, quality) in [(&gpu, Quality::Preview), (&gpu, Quality::Final), (&narrow, Quality::Preview)] {
        let shot = along(&plant, quality);
        let drawn = |how: How| {
            let mut renderer = renderer(gpu, Arc::new(Model::default()), Some(placed.clone()));
            set(&mut renderer.plants.as_mut().unwrap().view.flakes, how);
            let picture = renderer.picture(&shot, &Task::silent()).unwrap();
            (picture, hidden(gpu, &renderer))
        };
        let ((expected, none), (found, some)) = (drawn(ALL), drawn(TESTED));
        assert!(found == expected, "{quality:?}");
        assert_eq!(count(&none), 0);
        // In one batch, nothing is left out but what is outside of the picture.
        let (_, outside) = drawn(How { least_of_batch: usize::MAX, ..TESTED });
        // Of so many trees in each other, a tenth at least is behind others.
        let (behind, all) = (count(&some) - count(&outside), some.len());
        assert!(10 * behind > all, "{quality:?}: {behind} of {all}");
        // Bands of 70 rows, which are no multiple of a tile's.
        let samples = if quality == Quality::Final { 4 } else { 1 };
        let (banded, _) = drawn(How { most_of_band: 8 * 240 * samples * 70, ..TESTED });
        assert!(banded == expected, "{quality:?}, in bands");
    }
}

#[test]
fn samples_behind_a_wall_are_left_out_and_those_before_it_are_not() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let plant = oak();
    let placed = row(&plant, 2, 2.0);
    for quality in [Quality::Preview, Quality::Final] {
        let shot = along(&plant, quality);
        let [right, down, forward] = [0, 1, 2].map(|axis| shot.pose.rotation.row(axis));
        let hidden = |wall_at: Option<f64>| {
            let mut model = Modeller::new();
            if let Some(at) = wall_at {
                let corner = shot.viewpoint() + at * (forward - 2.0 * right - 2.0 * down);
                model.object("wall").quad(corner, at * 4.0 * right, at * 4.0 * down);
            }
            let mut renderer = renderer(&gpu, model.finish(), Some(placed.clone()));
            renderer.picture(&shot, &Task::silent()).unwrap();
            hidden(&gpu, &renderer)
        };
        let radius = plant.whole().bounds.ball.radius;
        let [without, wall_behind, wall_in_front] = [None, Some(20.0 * radius), Some(radius)].map(hidden);
        assert!(wall_in_front.iter().all(|hidden| *hidden), "{quality:?}");
        assert_eq!(wall_behind, without, "{quality:?}");
        assert!(2 * count(&without) < without.len(), "{quality:?}: most blocks are in the picture");
    }
}

#[test]
fn what_the_sun_does_not_see_is_left_out_and_no_shadow_changes() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let plant = oak();
    let mut placed = row(&plant, 16, 0.2);
    placed.trees.iter_mut().for_each(|tree| tree.casts = true);
    // Along the row and down.
    placed.light.towards_sun = DVec3::new(0.0, -1.0, 0.5).normalize();
    let mut model = Modeller::new();
    let (side, up) = (40.0 * plant.whole().bounds.ball.radius, placed.light.up);
    assert_eq!(up, DVec3::Z);
    model.object("ground").quad(DVec3::new(-0.5 * side, -0.5 * side, 0.0), side * DVec3::X, side * DVec3::Y);
    let model = model.finish();
    let drawn = |how: How| {
        let mut renderer = renderer(&gpu, model.clone(), Some(placed.clone()));
        let catches =
            |renderer: &mut Renderer| renderer.picture(&along(&plant, Quality::Preview), &Task::silent());
        // The first picture makes what the second one is drawn with.
        catches(&mut renderer).unwrap();
        renderer.forget_shadows();
        let shadows = renderer.shadows.as_mut().unwrap();
        set(shadows.flakes(), how);
        let picture = catches(&mut renderer).unwrap();
        let hidden = hidden_of(&gpu, renderer.shadows.as_mut().unwrap().flakes());
        (picture, hidden)
    };
    let ((expected, none), (found, some)) = (drawn(ALL), drawn(TESTED));
    assert!(found == expected);
    assert_eq!(count(&none), 0);
    let (_, outside) = drawn(How { least_of_batch: usize::MAX, ..TESTED });
    let (behind, all) = (count(&some) - count(&outside), some.len());
    // The crowns of oaks are airy, and the sun's view is narrow.
    assert!(100 * behind > all, "{behind} of {all}");
}

#[test]
fn samples_that_reach_several_pixels_are_left_out_only_where_all_of_them_is_hidden() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let plant = oak();
    let placed = row(&plant, 16, 0.3);
    // A nanosecond is too little for any device, so that the second picture is as coarse as can be.
    let camera = centred(720, 600, 750.0);
    let shot =
        Shot { camera, trees_within: Some(Duration::from_nanos(1)), ..along(&plant, Quality::Preview) };
    let drawn = |how: How| {
        let mut renderer = renderer(&gpu, Arc::new(Model::default()), Some(placed.clone()));
        set(&mut renderer.plants.as_mut().unwrap().view.flakes, How { least_of_batch: 2, ..how });
        renderer.picture(&shot, &Task::silent()).unwrap();
        let picture = renderer.picture(&shot, &Task::silent()).unwrap();
        assert_eq!(renderer.plants.as_ref().unwrap().view.options, WalkOptions::COARSEST);
        (picture, hidden(&gpu, &renderer))
    };
    let ((expected, none), (found, some)) = (drawn(ALL), drawn(TESTED));
    assert!(found == expected);
    assert!(count(&none) == 0 && count(&some) > 0, "{} of {}", count(&some), some.len());
}

#[test]
fn images_are_drawn_on_the_pixels_around_them_alone_and_none_of_theirs_is_missing() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let plant = oak();
    let ball = plant.whole().bounds.ball;
    let (width, height) = (240, 200);
    // So far away that all of a tree is drawn from images, 50 pixels high.
    let eye = ball.middle - 10.0 * ball.radius * DVec3::Y;
    for quality in [Quality::Preview, Quality::Final] {
        let shot = Shot { quality, ..Shot::new(centred(width, height, 250.0), look_at(eye, ball.middle)) };
        // Places in radii from the middle of the picture, to the right and up.
        let drawn = |places: &[[f64; 2]]| {
            let mut placed = row(&plant, places.len() as u32, 0.0);
            for (tree, [right, up]) in placed.trees.iter_mut().zip(places) {
                let at = ball.radius * (right * DVec3::X + up * DVec3::Z);
                tree.world_from_plant = DAffine3::from_translation(at);
            }
            let mut renderer = renderer(&gpu, Arc::new(Model::default()), Some(placed));
            let picture = renderer.picture(&shot, &Task::silent()).unwrap();
            (picture, renderer.plants.as_ref().unwrap().view.rect)
        };
        let [middle, corners] = [[-1.0, 0.0], [4.6, 3.6]];
        let [x, y] = corners;
        let ((one, around), (all, whole)) =
            (drawn(&[middle]), drawn(&[middle, [-x, -y], [x, -y], [-x, y], [x, y]]));
        assert_eq!(whole, PixelRect::of_size(width, height));
        // Trees in the corners do not come near it.
        let PixelRect { x, y, w, h } = around;
        assert!(x > 40 && w < 80 && y > 50 && y + (h as i32) < 150, "{around:?}");
        let (mut covered, mut others) = (0, 0);
        for ((one, all), i) in one.pixels().iter().zip(all.pixels()).zip(0..) {
            let [x, y] = [(i % width) as i32, (i / width) as i32];
            if (50..150).contains(&y) && (40..200).contains(&x) {
                assert_eq!(one, all, "{quality:?}: {x}, {y}");
                covered += u32::from(one[3] > 0);
            } else {
                assert_eq!(one[3], 0);
                others += u32::from(all[3] > 0);
            }
        }
        assert!(covered > 300 && others > 300, "{covered} and {others}");
    }
}
