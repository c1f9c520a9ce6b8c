//! Tests of trees that have the light that photos show of them.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};

use super::super::ratio::have_same_ratios;
use super::{oak, placed, renderer, with_images};
use crate::left_out::on_adapter;
use crate::{Gpu, Renderer};
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::light::linear_of_srgb;
use quadratura_base::scene::synthetic::{centred, look_at};
use quadratura_base::scene::{Model, PhotoId};
use quadratura_base::task::Task;
use quadratura_foliage::synthetic::plant_of;
use quadratura_foliage::{Material, OutdoorLight, PlacedTrees, RATIO_CELLS, RatioImage, RatiosInView};
use quadratura_projection::Renders;
use quadratura_view::{Picture, Quality, Shot};

/// A ratio image of a photo that looks at the origin: logarithms rise from cell to cell, each channel in its own way.
fn rising(photo: u32, eye: DVec3) -> RatioImage {
    let of_cell = |cell: usize| {
        let [x, y] = [cell % RATIO_CELLS, cell / RATIO_CELLS].map(|at| at as f32 / (RATIO_CELLS - 1) as f32);
        Vec3::new(0.9 * x - 0.6, 0.7 * y - 0.5, 0.5 - 0.6 * x * y) + 0.1 * photo as f32
    };
    RatioImage {
        photo: PhotoId(photo),
        camera: centred(300, 260, 350.0),
        pose: look_at(eye, DVec3::ZERO),
        rect: PixelRect { x: 70, y: 40, w: 180, h: 190 },
        logs: (0..RATIO_CELLS * RATIO_CELLS).map(of_cell).collect(),
        mean: Vec3::new(-0.1, 0.05, 0.2),
        blocks: 200.0,
        share: 0.9,
    }
}

/// Three photos around the view, and one from the other side.
fn ratios() -> Arc<[RatioImage]> {
    [(-1.5, -6.0), (1.0, -7.0), (2.5, -5.0), (0.0, 6.0)]
        .into_iter()
        .enumerate()
        .map(|(i, (x, y))| rising(i as u32, DVec3::new(x, y, 0.7)))
        .collect()
}

/// A square of side 2 across y around the origin in even light, and before it in the list one that it hides.
fn upright_squares() -> PlacedTrees {
    let mut placed = placed(plant_of(Material { reflected: [0.4; 3], ..Material::default() }));
    let upright = DAffine3::from_rotation_x(0.5 * std::f64::consts::PI);
    let places = [DAffine3::from_translation(3.0 * DVec3::Y) * upright, upright];
    for (tree, place) in placed.trees.iter_mut().zip(places) {
        (tree.world_from_plant, tree.tint) = (place, Vec3::ONE);
    }
    let even = Vec3::splat(0.8);
    placed.light = OutdoorLight { sun: Vec3::ZERO, sky: even, ground: even, ..placed.light };
    placed
}

fn linear(picture: &Picture, at: usize) -> Vec3 {
    let [r, g, b, _] = picture.pixels()[at];
    Vec3::from_array([r, g, b].map(|byte| linear_of_srgb(f64::from(byte) / 255.0) as f32))
}

#[test]
fn the_light_of_each_pixel_changes_by_the_factor_of_its_point_in_the_photos() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let polygons = upright_squares();
    for placed in [with_images(polygons.clone()), polygons] {
        let eye = DVec3::new(0.3, -5.0, 0.2);
        let camera = centred(120, 120, 270.0);
        let shot = Shot { quality: Quality::Preview, ..Shot::new(camera, look_at(eye, DVec3::ZERO)) };
        let mut renderer = renderer(&gpu, Arc::new(Model::default()), Some(placed.clone()));
        let bare = renderer.picture(&shot, &Task::silent()).unwrap();
        let mut with = placed;
        with.trees[1].ratios = ratios();
        with.trees[0].ratios =
            ratios().iter().map(|ratio| rising(7 - ratio.photo.0, ratio.pose.center_in_world())).collect();
        renderer.set_trees(Some(Arc::new(with.clone()))).unwrap();
        let middle = with.ball(&with.trees[1]).middle;
        for without in [vec![], vec![PhotoId(1)]] {
            let shot = Shot { without: without.clone(), ..shot.clone() };
            let found = renderer.picture(&shot, &Task::silent()).unwrap();
            let in_view = RatiosInView::new(&ratios(), middle, eye, &without);
            assert_eq!(in_view.images.len(), 3 - without.len());
            let (mut pixels, mut smallest, mut largest) = (0, f32::INFINITY, 0.0f32);
            for y in 25..95u32 {
                for x in 25..95u32 {
                    let at = (y * 120 + x) as usize;
                    assert_eq!((bare.pixels()[at][3], found.pixels()[at][3]), (255, 255), "{x} {y}");
                    let ray = camera.ray_in_camera(glam::DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
                    let ray = shot.pose.rotation.transpose() * ray;
                    let point = eye - eye.y / ray.y * ray;
                    let expected = in_view.factor_at(&ratios(), point);
                    let ratio = linear(&found, at) / linear(&bare, at);
                    // Half a step of 255 of each picture is up to 1.2 % of the darkest light here; a sample of an image is lit at its
                    // own point, up to a pixel from the pixel's middle, where factors differ by less than 1.5 %.
                    let off = (ratio / expected - 1.0).abs().max_element();
                    assert!(off < 0.04, "{ratio} and {expected} at {x} {y}");
                    pixels += 1;
                    (smallest, largest) = (smallest.min(expected.x), largest.max(expected.x));
                }
            }
            // Far more than the tolerance.
            assert!(pixels == 4900 && largest > 1.15 * smallest, "{smallest} {largest}");
        }
    }
}

#[test]
fn without_ratio_images_in_the_view_a_tree_has_their_mean_and_without_any_the_same_bytes_as_ever() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let plant = oak();
    let mut placed = placed(plant.clone());
    let shot = super::shot(&plant, Quality::Final);
    let mut renderer = renderer(&gpu, Arc::new(Model::default()), Some(placed.clone()));
    let bare = renderer.picture(&shot, &Task::silent()).unwrap();
    // A photo from the other side.
    let ball = plant.whole().bounds.ball;
    let behind = ball.middle - 3.0 * (shot.pose.center_in_world() - ball.middle);
    let of_half = Vec3::splat(0.5f32.ln());
    let sure = RatioImage { mean: of_half, blocks: 1e9, share: 1.0, ..rising(0, behind) };
    placed.trees.iter_mut().for_each(|tree| tree.ratios = [sure.clone()].into());
    renderer.set_trees(Some(Arc::new(placed.clone()))).unwrap();
    let darker = renderer.picture(&shot, &Task::silent()).unwrap();
    placed.trees.iter_mut().for_each(|tree| {
        tree.ratios = Arc::default();
        tree.tint *= 0.5;
    });
    renderer.set_trees(Some(Arc::new(placed.clone()))).unwrap();
    let tinted = renderer.picture(&shot, &Task::silent()).unwrap();
    let differ = darker.rgba.iter().zip(&tinted.rgba).filter(|(a, b)| a.abs_diff(**b) > 1).count();
    assert_eq!(differ, 0, "half of the light is half of the light");
    assert!(darker != bare);
    placed.trees.iter_mut().for_each(|tree| tree.tint *= 2.0);
    renderer.set_trees(Some(Arc::new(placed))).unwrap();
    assert_eq!(renderer.picture(&shot, &Task::silent()).unwrap(), bare);
}

#[test]
fn a_tree_that_moves_changes_no_ratio_image_and_others_replace_them() {
    let Some(gpu) = on_adapter(Gpu::headless()) else { return };
    let mut placed = upright_squares();
    placed.trees[1].ratios = ratios();
    let (mut moved, mut others, mut fewer) = (placed.clone(), placed.clone(), placed.clone());
    moved.trees[0].world_from_plant = DAffine3::from_translation(DVec3::X) * placed.trees[0].world_from_plant;
    others.trees[1].ratios = [rising(5, DVec3::new(0.5, -6.0, 0.0))].into();
    fewer.trees.remove(0);
    let shot = Shot::new(centred(120, 120, 270.0), look_at(DVec3::new(0.3, -5.0, 0.2), DVec3::ZERO));
    let picture = |renderer: &mut Renderer| renderer.picture(&shot, &Task::silent()).unwrap();
    let mut kept = renderer(&gpu, Arc::new(Model::default()), Some(placed.clone()));
    let mut before = placed;
    for (next, same) in [(moved, true), (others, false), (fewer, false)] {
        assert_eq!(have_same_ratios(&before, &next), same);
        kept.set_trees(Some(Arc::new(next.clone()))).unwrap();
        let mut new = renderer(&gpu, Arc::new(Model::default()), Some(next.clone()));
        assert!(picture(&mut kept) == picture(&mut new));
        before = next;
    }
}
