//! Tests of polygons of trees that are left out because they are behind others.

use std::sync::Arc;

use glam::{DVec3, Vec2, Vec4};

use super::super::hidden::{TILE, TileDepths};
use super::hidden::row;
use super::{oak, renderer};
use crate::left_out::on_adapter;
use crate::{Gpu, Renderer};
use quadratura_base::scene::Model;
use quadratura_base::scene::synthetic::{Modeller, centred, look_at};
use quadratura_base::task::Task;
use quadratura_foliage::{PlacedSpecies, PlacedTrees, Plant};
use quadratura_projection::Renders;
use quadratura_view::{Quality, Shot};

/// A view from so near that much is drawn as polygons, along the row.
fn near(radius: f64, middle: DVec3, quality: Quality) -> Shot {
    let eye = middle - 1.2 * radius * DVec3::Y;
    Shot { quality, ..Shot::new(centred(240, 200, 250.0), look_at(eye, middle)) }
}

/// A row of trees that have images of their large branches alone, so that much is drawn as polygons.
fn row_with_few_images(plant: &Plant) -> PlacedTrees {
    let mut placed = row(plant, 6, 0.2);
    let mut images = (**placed.species[0].images.as_ref().unwrap()).clone();
    for (of, object) in images.objects.iter_mut().zip(&plant.objects) {
        of.take_if(|_| object.counts.polygons < 50_000);
    }
    assert!(images.objects.iter().any(Option::is_some));
    placed.species[0].images = Some(Arc::new(images));
    placed
}

#[test]
fn polygons_behind_others_are_left_out_and_no_pixel_changes() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let plant = oak();
    let mut placed = row_with_few_images(&plant);
    // Of other species, too: one that has images, and one that is drawn as polygons alone.
    let other = placed.species[0].clone();
    placed.species.extend([other.clone(), PlacedSpecies { images: None, ..other }]);
    (placed.trees[1].species, placed.trees[3].species, placed.trees[4].species) = (1, 2, 1);
    let ball = plant.whole().bounds.ball;
    for quality in [Quality::Preview, Quality::Final] {
        let shot = near(ball.radius, ball.middle, quality);
        let drawn = |least: Option<u64>, most_of_band: u64| {
            let mut renderer = renderer(&gpu, Arc::new(Model::default()), Some(placed.clone()));
            let view = &mut renderer.plants.as_mut().unwrap().view;
            view.polygons.least_of_batch = least;
            view.flakes.most_of_band = view.flakes.most_of_band.min(most_of_band);
            let picture = renderer.picture(&shot, &Task::silent()).unwrap();
            let view = &renderer.plants.as_ref().unwrap().view;
            let (counts, batches) = (view.polygons.counts(), view.polygons.batches.len());
            assert_eq!(view.flakes.bands.len() > 1, most_of_band < u64::MAX);
            let numbers = renderer.seen_faces(&shot, &Task::silent()).unwrap();
            (picture, numbers, counts, batches)
        };
        let (expected, numbers, [all, of_all], one) = drawn(None, u64::MAX);
        assert_eq!((one, of_all), (1, all), "{quality:?}");
        // Bands of 70 rows are no multiple of a tile's. Final pictures, which take long, are drawn in bands alone.
        let bands: &[u64] = match quality {
            Quality::Preview => &[u64::MAX, 8 * 240 * 70],
            Quality::Final | Quality::Finer => &[8 * 240 * 4 * 70],
        };
        for &band in bands {
            let (found, found_numbers, [in_view, seen], batches) = drawn(Some(1 << 10), band);
            assert!(found == expected && found_numbers == numbers, "{quality:?}, {band}");
            assert!(batches > 2 && in_view == all, "{batches}");
            assert!(10 * (all - seen) > all, "{quality:?}: {seen} of {all}");
        }
    }
}

#[test]
fn what_a_drawing_that_was_given_up_left_behind_is_not_drawn_again() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let plant = oak();
    let ball = plant.whole().bounds.ball;
    let shot = near(ball.radius, ball.middle, Quality::Preview);
    let mut renderer = renderer(&gpu, Arc::new(Model::default()), Some(row_with_few_images(&plant)));
    renderer.plants.as_mut().unwrap().view.polygons.least_of_batch = Some(1 << 10);
    renderer.picture(&shot, &Task::silent()).unwrap();
    // Numbers are drawn with what the picture was drawn with, or as here with what is found anew.
    let expected = renderer.seen_faces(&shot, &Task::silent()).unwrap();
    let counts = |renderer: &Renderer| renderer.plants.as_ref().unwrap().view.polygons.counts();
    let before = counts(&renderer);
    renderer.picture(&shot, &Task::silent()).unwrap();
    renderer.plants.as_ref().unwrap().view.is_found.set(false);
    assert!(renderer.seen_faces(&shot, &Task::silent()).unwrap() == expected);
    assert_eq!(counts(&renderer), before);
}

#[test]
fn polygons_behind_a_wall_are_left_out() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let plant = oak();
    let ball = plant.whole().bounds.ball;
    let shot = near(ball.radius, ball.middle, Quality::Preview);
    let counts = |wall_at: Option<f64>| {
        let mut model = Modeller::new();
        if let Some(at) = wall_at {
            let [right, down, forward] = [0, 1, 2].map(|axis| shot.pose.rotation.row(axis));
            let corner = shot.viewpoint() + at * (forward - 2.0 * right - 2.0 * down);
            model.object("wall").quad(corner, at * 4.0 * right, at * 4.0 * down);
        }
        let mut renderer = renderer(&gpu, model.finish(), Some(row(&plant, 2, 0.5)));
        renderer.plants.as_mut().unwrap().view.polygons.least_of_batch = Some(1 << 10);
        renderer.picture(&shot, &Task::silent()).unwrap();
        renderer.plants.as_ref().unwrap().view.polygons.counts()
    };
    let [without, wall_behind, wall_in_front] =
        [None, Some(9.0 * ball.radius), Some(0.05 * ball.radius)].map(counts);
    assert_eq!(wall_behind, without);
    // Trunk and large branches have balls that reach to the viewer.
    let [all, seen] = wall_in_front;
    assert!(all == without[0] && 20 * seen < all, "{seen} of {all}");
}

/// Tiles of a picture of 40 x 22 pixels in bands of 10 and 12 rows, in which all is at one depth but one tile, which is empty.
fn tiles(near: f32, empty: Option<(u32, u32)>) -> TileDepths {
    let across = 40u32.div_ceil(TILE);
    let band = |(first, count): (u32, u32)| {
        let nearness = |tile: u32| {
            let at = (tile % across, first + TILE * (tile / across));
            if empty == Some(at) { 0.0 } else { 1.0 / near }
        };
        (first, count, (0..across * count.div_ceil(TILE)).map(nearness).collect())
    };
    let bands = [(0, 10), (10, 12)].map(band).to_vec();
    TileDepths { focal: Vec2::new(30.0, 32.0), center: Vec2::new(20.0, 11.0), width: 40, bands }
}

#[test]
fn balls_are_hidden_where_all_of_their_tiles_are_nearer() {
    let ball = |x: f32, y: f32, z: f32, radius: f32| Vec4::new(x, y, z, radius);
    let all = tiles(5.0, None);
    assert!(all.hide(&ball(0.0, 0.0, 7.0, 1.0)));
    // What is as near counts as seen, and so does what reaches before it, or to the viewer.
    for seen in [ball(0.0, 0.0, 6.0, 1.0), ball(0.0, 0.0, 5.5, 1.0), ball(0.0, 0.0, 0.5, 1.0)] {
        assert!(!all.hide(&seen), "{seen}");
    }
    assert!(!all.hide(&ball(0.0, 0.0, f32::NAN, 1.0)) && !all.hide(&ball(0.0, 0.0, -9.0, 1.0)));
    // Beside the picture; partly beside it, where all of the rest is hidden.
    assert!(all.hide(&ball(40.0, 0.0, 10.0, 1.0)) && all.hide(&ball(7.0, 0.0, 10.0, 1.0)));
    // Each tile of both bands is looked at: balls all over the picture are seen where its tile is empty, and only there.
    for (x, y) in (0..40).flat_map(|x| (0..22).map(move |y| (x, y))) {
        let row = if y < 10 { y / TILE * TILE } else { 10 + (y - 10) / TILE * TILE };
        let with_hole = tiles(5.0, Some((x / TILE, row)));
        let (column, z) = (x as f32 + 0.5, 10.0);
        let at = ball((column - 20.0) * z / 30.0, (y as f32 + 0.5 - 11.0) * z / 32.0, z, 0.05);
        assert!(!with_hole.hide(&at), "{x}, {y}");
        let other = tiles(5.0, Some(((x / TILE + 3) % 10, row)));
        assert!(other.hide(&at), "{x}, {y}");
    }
}
