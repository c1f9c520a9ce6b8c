//! Cubes and sets: seams close, nearer surfaces come last across faces, and several images become one picture.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::super::cube::{cube, cube_cameras};
use super::super::splat::{Canvas, Dot};
use super::super::warp::set_drawn_in_order;
use super::{of_model, step_aside};
use crate::{Arrangement, Ldi, LdiSet, SplatKind, WarpOptions, Warped, warp, warp_set};
use quadratura_base::Error;
use quadratura_base::geometry::Pose;
use quadratura_base::scene::Model;
use quadratura_base::scene::synthetic::{Modeller, Rng, centred, look_at};
use quadratura_base::task::Task;
use quadratura_view::{Picture, Shot};

const SPLATS: [SplatKind; 3] = [SplatKind::Pixel, SplatKind::Over, SplatKind::Sums];

fn of_splat(splat: SplatKind) -> WarpOptions {
    WarpOptions { splat, ..WarpOptions::default() }
}

fn picture(set: &LdiSet, shot: &Shot, options: &WarpOptions) -> Warped {
    warp_set(set, shot, options, &Task::silent()).unwrap()
}

/// A room around the origin with boxes in it, none of which is around the middle.
fn room(boxes: u32, seed: u64) -> Arc<Model> {
    let mut model = Modeller::new();
    model.object("room").cuboid(DVec3::new(0.4, -0.3, 0.2), DVec3::new(5.0, 4.0, 6.0), DMat3::IDENTITY);
    let mut rng = Rng::new(seed);
    for number in 0..boxes {
        let direction = DVec3::from_array(std::array::from_fn(|_| rng.between(-1.0, 1.0)));
        let turn =
            DMat3::from_rotation_y(rng.between(0.0, 3.0)) * DMat3::from_rotation_x(rng.between(0.0, 3.0));
        let half = DVec3::from_array(std::array::from_fn(|_| rng.between(0.2, 0.5)));
        let centre = direction.normalize_or(DVec3::X) * rng.between(1.7, 3.0);
        model.object(format!("box {number}")).cuboid(centre, half, turn);
    }
    model.finish()
}

fn cube_of(model: &Arc<Model>, side: u32, colour: impl Fn(usize, DVec3) -> [u8; 4] + Copy) -> LdiSet {
    cube(
        cube_cameras(DVec3::ZERO, &DMat3::IDENTITY, side)
            .map(|(camera, pose)| of_model(model, camera, pose, colour)),
    )
    .unwrap()
}

/// A view from a place up to `apart` from the middle of the room in any direction, often across seams and corners.
fn anywhere(rng: &mut Rng, apart: f64) -> Shot {
    let mut vector = || DVec3::from_array(std::array::from_fn(|_| rng.between(-1.0, 1.0)));
    let (eye, ahead) = (apart * vector(), vector());
    Shot { backs: true, ..Shot::new(centred(150, 140, 110.0), look_at(eye, eye + ahead)) }
}

#[test]
fn a_room_of_one_colour_stays_so_across_the_seams_of_a_cube() {
    let colour = [90, 140, 200, 255];
    let cube = cube_of(&room(0, 0), 256, |_, _| colour);
    let mut rng = Rng::new(31);
    let corner = DVec3::new(1.0, 1.0, 1.0);
    let ways = [corner, -corner, DVec3::new(1.0, 0.0, 1.0), DVec3::new(0.0, -1.0, -1.0)];
    let at_seams = ways.map(|ahead| Shot {
        backs: true,
        ..Shot::new(centred(150, 140, 110.0), look_at(DVec3::ZERO, ahead))
    });
    let views = at_seams.into_iter().chain((0..24).map(|_| anywhere(&mut rng, 1.5)));
    for (view, shot) in views.enumerate() {
        let sums = picture(&cube, &shot, &of_splat(SplatKind::Sums)).picture;
        for (i, pixel) in sums.pixels().iter().enumerate() {
            let off = pixel.iter().zip(colour).map(|(a, b)| a.abs_diff(b)).max();
            assert!(off <= Some(1), "{pixel:?} at {}, {} of view {view}", i % 150, i / 150);
        }
        // Quarters over each other are opaque enough up to a spacing of 2.4, as on a single plane.
        let over = picture(&cube, &shot, &of_splat(SplatKind::Over)).picture;
        let alphas: Vec<u8> = over.pixels().iter().map(|pixel| pixel[3]).collect();
        let mean = alphas.iter().map(|alpha| f64::from(*alpha)).sum::<f64>() / (255.0 * alphas.len() as f64);
        assert!(mean >= 0.98 && alphas.iter().all(|alpha| *alpha > 0), "{mean} in view {view}");
    }
}

/// What is drawn at each pixel: the inverse depths of the nearest depth pixel and of the last one.
struct LastDrawn {
    width: usize,
    pixels: Vec<[f32; 2]>,
}

impl Canvas for LastDrawn {
    const SPACED: bool = true;
    const REACH: f32 = f32::INFINITY;

    fn draw(&mut self, dot: &Dot) {
        let rows = self.pixels.len() / self.width;
        if dot.u >= 0.0 && dot.v >= 0.0 && (dot.u as usize) < self.width && (dot.v as usize) < rows {
            let [nearest, last] = &mut self.pixels[dot.v as usize * self.width + dot.u as usize];
            (*nearest, *last) = (nearest.max(dot.q), dot.q);
        }
    }
}

/// Returns the share of pixels whose last depth pixel is more than 1 % behind the nearest.
fn share_of_wrong(set: &LdiSet, shot: &Shot) -> f64 {
    let options = WarpOptions { level: Some(0), unculled: true, ..WarpOptions::default() };
    let (width, height) = (shot.camera.width as usize, shot.camera.height as usize);
    let canvas = LastDrawn { width, pixels: vec![[0.0; 2]; width * height] };
    let drawn = set_drawn_in_order(set, shot, &options, canvas, |canvas, _| canvas).pixels;
    let wrong = drawn.iter().filter(|[nearest, last]| *last < 0.99 * nearest).count();
    wrong as f64 / drawn.iter().filter(|[nearest, _]| *nearest > 0.0).count().max(1) as f64
}

#[test]
fn across_the_faces_of_a_cube_nearer_surfaces_come_last() {
    let mut rng = Rng::new(32);
    let (mut wrong, mut any_order, views) = (0.0, 0.0, 30);
    for seed in 0..views {
        let cube = cube_of(&room(14, seed), 96, |_, _| [255; 4]);
        let shot = anywhere(&mut rng, 1.2);
        wrong += share_of_wrong(&cube, &shot) / f64::from(views as u32);
        // The same depth pixels in the order of the viewpoint on the other side of the centre.
        let images = cube.images.iter().rev().cloned().collect();
        let disordered = LdiSet { arrangement: Arrangement::Single, images };
        any_order += share_of_wrong(&disordered, &shot) / f64::from(views as u32);
    }
    // As of one frame: points of one pixel lie on slightly different rays.
    assert!(wrong <= 0.01, "{wrong}");
    assert!(any_order > 2.0 * wrong + 0.002, "{any_order} in another order, {wrong} in the right one");
}

#[test]
fn a_cube_shows_what_rays_show_whatever_the_direction() {
    let patterned = |face: usize, _: DVec3| {
        [(37 * face % 251) as u8, (91 * face % 241) as u8, (53 * face % 239) as u8, 255]
    };
    let model = room(14, 77);
    let cube = cube_of(&model, 320, patterned);
    let mut rng = Rng::new(33);
    for view in 0..8 {
        let shot = anywhere(&mut rng, 0.1);
        let truth = of_model(&model, shot.camera, shot.pose, patterned);
        let shown = picture(&cube, &shot, &of_splat(SplatKind::Sums)).picture;
        let level = &truth.levels[0];
        let like = |(i, pixel): &(usize, &[u8; 4])| {
            let first = level.at(*i as u32 % 150, *i as u32 / 150).next();
            first.is_some_and(|first| {
                level.colours[first].iter().zip(*pixel).all(|(a, b)| a.abs_diff(*b) <= 8)
            })
        };
        let same = shown.pixels().iter().enumerate().filter(like).count();
        let share = same as f64 / shown.pixels().len() as f64;
        // Edges are mixtures; a box of this room has an outline of a hundred pixels.
        assert!(share > 0.85, "{share} of view {view}");
    }
}

/// The same scene as seen from two places, with other exposures of one colour.
fn two_of_one_wall() -> [Ldi; 2] {
    let mut model = Modeller::new();
    model.object("wall").screen(4.0, [-40.0, -40.0, 40.0, 40.0]);
    let model = model.finish();
    let camera = centred(200, 150, 150.0);
    [(-1.0, 0.0), (1.2, 0.3)].map(|(x, gain)| {
        let pose = Pose { rotation: DMat3::from_rotation_y(-0.2 * x), translation: DVec3::new(-x, 0.0, 0.0) };
        let colour = |_: usize, _: DVec3| {
            // The wall has a linear light of 0.2 at the first one's exposure.
            let srgb = quadratura_view::srgb::Srgb::tables();
            let byte = srgb.encoded((0.2 * f64::exp(gain)) as f32);
            [byte, byte, byte, 255]
        };
        Ldi { gain: [gain; 3], ..of_model(&model, camera, pose, colour) }
    })
}

#[test]
fn a_set_has_one_exposure_and_closes_where_each_of_its_images_ends() {
    let images = two_of_one_wall();
    let grey = images[0].levels[0].colours[0];
    let set = LdiSet { arrangement: Arrangement::Set, images: images.into() };
    for x in [-2.0, -0.5, 0.0, 0.9, 2.0] {
        let shot = Shot::new(
            centred(160, 60, 100.0),
            look_at(DVec3::new(x, 0.1, 0.3), DVec3::new(0.3 * x, 0.0, 4.0)),
        );
        let shown = picture(&set, &shot, &WarpOptions::default());
        let seen: Vec<_> = shown.picture.pixels().iter().filter(|pixel| pixel[3] == 255).collect();
        assert!(seen.len() > 5_000, "{} pixels at {x}", seen.len());
        // Stored values of both exposures are rounded.
        assert!(seen.iter().all(|pixel| pixel.iter().zip(grey).all(|(a, b)| a.abs_diff(b) <= 2)), "at {x}");
        let of_one =
            |i: usize| picture(&set.images[i].clone().into(), &shot, &WarpOptions::default()).picture;
        let covered = |picture: &Picture| picture.pixels().iter().filter(|pixel| pixel[3] == 255).count();
        assert!(covered(&of_one(0)).max(covered(&of_one(1))) <= seen.len());
    }
}

#[test]
fn a_set_has_no_order_in_which_depth_pixels_could_be_drawn_over_each_other() {
    let set = LdiSet { arrangement: Arrangement::Set, images: two_of_one_wall().into() };
    let shot = Shot::new(centred(20, 20, 20.0), set.images[0].pose);
    for splat in [SplatKind::Pixel, SplatKind::Over] {
        let refused = warp_set(&set, &shot, &of_splat(splat), &Task::silent());
        assert!(matches!(refused, Err(Error::Request(ref found)) if found.contains("--splat sums")));
    }
}

#[test]
fn one_image_alone_is_drawn_as_it_is_and_threads_change_nothing() {
    let model = room(6, 5);
    let patterned =
        |face: usize, point: DVec3| [(40 * face % 256) as u8, (60.0 * (point.x + 2.0)) as u8, 9, 255];
    let cube = cube_of(&model, 64, patterned);
    let mut rng = Rng::new(34);
    for splat in SPLATS {
        let options = of_splat(splat);
        let eye = step_aside(&mut rng, DVec3::ZERO, DVec3::Z, 0.4);
        let shot = Shot::new(centred(170, 150, 90.0), eye);
        let one = cube.images[4].clone();
        let alone = warp(&one, &shot, &options, &Task::silent()).unwrap();
        assert!(picture(&one.into(), &shot, &options) == alone);
        let expected = picture(&cube, &shot, &options);
        assert!(expected.depth_pixels > alone.depth_pixels);
        for threads in [1, 2, 16] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert!(pool.install(|| picture(&cube, &shot, &options)) == expected, "{threads} threads");
        }
    }
}
