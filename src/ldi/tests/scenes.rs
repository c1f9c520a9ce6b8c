//! Scenes in which the order of drawing matters, compared with what rays meet in the new camera.

use glam::{DMat3, DVec2, DVec3};

use super::super::warp::warp;
use super::of_model;
use crate::{DrawingOrder, Ldi, SplatKind, WarpOptions};
use quadratura_base::geometry::Pose;
use quadratura_base::scene::light::{linear_of_srgb, srgb_from_linear};
use quadratura_base::scene::synthetic::{Modeller, Scene, Truth, camera_is_world, centred, closed_form};
use quadratura_base::task::Task;
use quadratura_view::Shot;

/// A scene with the cameras that look at it, and what is told of it.
struct CameraMoves {
    name: &'static str,
    scene: Scene,
    poses: Vec<Pose>,
}

/// Returns a camera at a place in the frame of the reference camera, turned to the right by an angle in radians.
fn at(scene: &Scene, place: DVec3, angle: f64) -> Pose {
    let Pose { rotation, translation } = scene.pose;
    let turned = DMat3::from_rotation_y(-angle);
    Pose { rotation: turned * rotation, translation: turned * (translation - place) }
}

/// Pickets before a wall, on the ground: every second gap shows the wall.
fn picket_fence() -> Scene {
    let mut model = Modeller::new();
    model.object("wall").screen(8.0, [-9.0, -4.0, 9.0, 1.5]);
    model.object("ground").quad(DVec3::new(-9.0, 1.5, 1.0), DVec3::X * 18.0, DVec3::Z * 7.0);
    model.object("fence");
    for picket in -14..=14 {
        let left = 0.4 * f64::from(picket);
        model.screen(4.0, [left, -0.6, left + 0.2, 1.2]);
    }
    for rail in [-0.3, 0.8] {
        model.screen(4.05, [-5.6, rail, 5.8, rail + 0.1]);
    }
    scene("picket fence", model)
}

fn scene(name: &str, mut model: Modeller) -> Scene {
    Scene {
        name: name.into(),
        model: model.finish(),
        camera: centred(200, 150, 150.0),
        pose: camera_is_world(),
        truth: Truth::Unknown,
    }
}

fn all() -> Vec<CameraMoves> {
    let fence = picket_fence();
    let aside = |scene: &Scene, by: f64| {
        let places = [DVec3::new(by, 0.0, 0.0), DVec3::new(-by, 0.3 * by, 0.0), DVec3::new(0.0, -by, 0.2)];
        places.map(|place| at(scene, place, 0.0)).to_vec()
    };
    let moves = |name, scene: Scene| CameraMoves { name, poses: aside(&scene, 0.5), scene };
    let ground = closed_form::ground_behind_the_camera().resized(200);
    let along = [DVec3::Z * 2.0, DVec3::Z * -1.0, DVec3::new(0.5, 0.0, 1.0)];
    vec![
        CameraMoves { name: "fence, sideways", poses: aside(&fence, 0.7), scene: fence.clone() },
        // The epipole is in the picture.
        CameraMoves {
            name: "fence, forward",
            poses: vec![at(&fence, DVec3::new(0.2, -0.1, 1.5), 0.0), at(&fence, DVec3::Z, 0.2)],
            scene: fence.clone(),
        },
        CameraMoves {
            name: "fence, backward",
            poses: vec![at(&fence, DVec3::new(0.3, 0.2, -1.5), 0.0), at(&fence, DVec3::Z * -1.0, -0.2)],
            scene: fence.clone(),
        },
        // Between the fence and the wall, towards the reference camera.
        CameraMoves {
            name: "fence, looking back",
            poses: vec![at(&fence, DVec3::new(0.3, -0.2, 7.0), std::f64::consts::PI)],
            scene: fence,
        },
        moves("three beams", closed_form::three_beams().resized(200)),
        moves("crossing boxes", closed_form::crossing_boxes().resized(200)),
        CameraMoves {
            name: "ground behind the camera",
            poses: along.into_iter().map(|place| at(&ground, place, 0.1)).collect(),
            scene: ground,
        },
    ]
}

/// Colours that differ from face to face.
fn by_face(face: usize, _: DVec3) -> [u8; 4] {
    [(60 + face * 83 % 190) as u8, (40 + face * 47 % 200) as u8, (30 + face * 131 % 220) as u8, 255]
}

/// Returns the share of a view's pixels that show another face than the nearest one that the image has there, and the share
/// that is compared: within one face, with something of the image in them.
fn wrong(ldi: &Ldi, truth: &Ldi, pose: Pose, options: &WarpOptions) -> [f64; 2] {
    let camera = truth.camera;
    let picture = warp(ldi, &Shot::new(camera, pose), options, &Task::silent()).unwrap().picture;
    let level = &truth.levels[0];
    // Layers that are level show either colour.
    let expected = |x: u32, y: u32| {
        let nearest = level.at(x, y).next()?;
        let depth = level.inverse_depths[nearest];
        // What the reference camera has beyond its frame is not in the image; what is behind it may be.
        let ray = camera.ray_in_camera(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        let point = pose.world_from_camera(ray / f64::from(depth));
        let own = ldi.camera.image_from_camera(ldi.pose.camera_from_world(point))?;
        let size = DVec2::new(f64::from(ldi.camera.width), f64::from(ldi.camera.height));
        if own.min_element() < 1.0 || !(own + 1.0).cmple(size).all() {
            return None;
        }
        let same = level.at(x, y).filter(|&i| level.inverse_depths[i] > 0.999 * depth);
        Some(same.map(|i| level.surfaces[i]).max().expect("the nearest one is level with itself"))
    };
    let (mut compared, mut wrong) = (0u32, 0u32);
    for y in 1..camera.height - 1 {
        for x in 1..camera.width - 1 {
            let Some(face) = expected(x, y) else { continue };
            let around = (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| (x, y)));
            let [r, g, b, alpha] = picture.pixels()[(y * camera.width + x) as usize];
            if alpha < 128 || !around.into_iter().all(|(x, y)| expected(x, y) == Some(face)) {
                continue;
            }
            let colour = by_face(usize::from(face) - 1, DVec3::ZERO);
            compared += 1;
            wrong += u32::from([r, g, b].iter().zip(colour).any(|(found, own)| found.abs_diff(own) > 12));
        }
    }
    let all = f64::from(camera.width * camera.height);
    [f64::from(wrong) / f64::from(compared), f64::from(compared) / all]
}

#[test]
fn pictures_show_the_nearest_surface_whichever_way_the_camera_moves_and_reversed_they_do_not() {
    for CameraMoves { name, scene, poses } in all() {
        let ldi = of_model(&scene.model, scene.camera, scene.pose, by_face);
        let (mut in_order_wrong, mut reversed_wrong) = (0.0f64, 0.0f64);
        for (i, pose) in poses.into_iter().enumerate() {
            let truth = of_model(&scene.model, scene.camera, pose, by_face);
            let options = WarpOptions { level: Some(0), ..WarpOptions::default() };
            let [share, compared] = wrong(&ldi, &truth, pose, &options);
            assert!(compared > 0.09, "{name} {i}: {compared} compared");
            // Next to nothing; at outlines, where boxes cross and where the picture magnifies, sums are softer than faces.
            assert!(share <= 0.04, "{name} {i}: {share} wrong of {compared}");
            // Single pixels show the order, and cracks, which do not depend on it.
            let in_order = WarpOptions { splat: SplatKind::Pixel, ..options };
            in_order_wrong = in_order_wrong.max(wrong(&ldi, &truth, pose, &in_order)[0]);
            let reversed = WarpOptions { order: DrawingOrder::Reversed, ..in_order };
            reversed_wrong = reversed_wrong.max(wrong(&ldi, &truth, pose, &reversed)[0]);
        }
        assert!(
            reversed_wrong > in_order_wrong + 0.05,
            "{name}: {reversed_wrong} wrong in the reversed order, {in_order_wrong} in order"
        );
    }
}

#[test]
fn soft_paint_on_a_billboard_lies_over_the_billboard_behind_it() {
    let mut model = Modeller::new();
    model.object("wall").screen(10.0, [-12.0, -9.0, 12.0, 9.0]);
    model.object("far").screen(6.0, [-2.0, -2.0, 1.0, 2.0]);
    model.object("near").screen(4.0, [-1.0, -1.2, 1.5, 1.2]);
    let colours = [[40, 60, 200, 255], [60, 200, 40, 255], [220, 60, 40, 128]];
    let scene = scene("billboards", model);
    let ldi = of_model(&scene.model, scene.camera, scene.pose, |face, _| colours[face]);
    let mixed = |behind: [u8; 4]| -> [u8; 3] {
        let opacity = f64::from(colours[2][3]) / 255.0;
        std::array::from_fn(|c| {
            let [front, back] =
                [colours[2][c], behind[c]].map(|value| linear_of_srgb(f64::from(value) / 255.0));
            (srgb_from_linear(opacity * front + (1.0 - opacity) * back) * 255.0).round() as u8
        })
    };
    let [over_far, over_wall] = [colours[1], colours[0]].map(mixed);
    for place in [DVec3::X * 0.3, DVec3::X * -0.4, DVec3::new(0.0, 0.2, 1.0), DVec3::Z * -1.0] {
        let pose = at(&scene, place, 0.0);
        let options = WarpOptions { level: Some(0), ..WarpOptions::default() };
        let shot = Shot::new(scene.camera, pose);
        let picture = warp(&ldi, &shot, &options, &Task::silent()).unwrap().picture;
        let pixel = |point: DVec3| {
            let px = scene.camera.image_from_camera(pose.camera_from_world(point)).unwrap();
            picture.pixels()[(px.y as u32 * scene.camera.width + px.x as u32) as usize]
        };
        // Points on the near billboard, before the far one and before the wall alone.
        for (point, expected) in
            [(DVec3::new(-0.2, 0.1, 4.0), over_far), (DVec3::new(1.2, -0.6, 4.0), over_wall)]
        {
            let found = pixel(point);
            let off = found.iter().zip(expected).map(|(a, b)| a.abs_diff(b)).max().unwrap();
            // Two roundings: of the colour and of the opacity.
            assert!(off <= 3 && found[3] == 255, "{found:?} instead of {expected:?} from {place}");
        }
    }
}
