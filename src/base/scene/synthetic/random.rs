//! Random scenes: each seed gives one, the same on every machine.

use std::f64::consts::TAU;

use glam::{DMat3, DQuat, DVec3, dvec2, dvec3};

use super::{Modeller, Rng, Scene, Truth, look_at};
use crate::geometry::{Pinhole, Pose};

/// Makes convex polygons of 3 to 7 corners with random orientations, in several objects. They intersect, occlude
/// each other in cycles, and extend behind the camera and out of the photo; the scene has no structure.
pub fn soup(seed: u64, face_count: u32) -> Scene {
    let mut rng = Rng::new(seed);
    let (camera, pose) = (any_camera(&mut rng), any_pose(&mut rng));
    let mut m = Modeller::new();
    let objects = 1 + face_count / 4;
    for _ in 0..face_count {
        m.object(format!("object {}", rng.whole(1, objects)));
        let in_camera = any_polygon(&mut rng, &camera);
        let in_world: Vec<DVec3> = in_camera.into_iter().map(|p| pose.world_from_camera(p)).collect();
        m.polygon(&in_world);
    }
    let name = format!("soup of {face_count} faces, seed {seed}");
    Scene { name, model: m.finish(), camera, pose, truth: Truth::Unknown }
}

/// Makes boxes on a ground, upright and rotated, with windows drawn on their walls; some touch, some intersect. It
/// resembles the model of a real site.
pub fn boxes(seed: u64, count: u32) -> Scene {
    let mut rng = Rng::new(seed);
    let camera = any_camera(&mut rng);
    let mut m = Modeller::new();
    m.object("ground").quad(dvec3(-60.0, -60.0, 0.0), DVec3::X * 120.0, DVec3::Y * 120.0);
    for i in 0..count {
        let half = dvec3(rng.between(0.5, 3.0), rng.between(0.5, 3.0), rng.between(0.5, 4.0));
        let centre = dvec3(rng.between(-8.0, 8.0), rng.between(-8.0, 8.0), half.z);
        let axes = DMat3::from_rotation_z(rng.between(0.0, TAU));
        m.object(format!("box {i}")).cuboid(centre, half, axes);
        window(&mut rng, &mut m, centre, half, axes);
    }
    let angle = rng.between(0.0, TAU);
    let eye = dvec3(22.0 * angle.cos(), 22.0 * angle.sin(), rng.between(1.0, 15.0));
    let target = dvec3(rng.between(-3.0, 3.0), rng.between(-3.0, 3.0), rng.between(0.0, 4.0));
    let name = format!("{count} boxes, seed {seed}");
    Scene { name, model: m.finish(), camera, pose: look_at(eye, target), truth: Truth::Unknown }
}

/// Adds a window in the plane of a box's first wall.
fn window(rng: &mut Rng, m: &mut Modeller, centre: DVec3, half: DVec3, axes: DMat3) {
    let size = rng.between(0.2, 0.7);
    let [out, u, v] = [axes.x_axis * half.x, axes.y_axis * half.y, axes.z_axis * half.z];
    m.quad(centre + out - size * (u + v), 2.0 * size * u, 2.0 * size * v);
}

/// Returns a random camera of 96 x 64 to 160 x 120 pixels, landscape or portrait, with its principal point near the
/// middle.
fn any_camera(rng: &mut Rng) -> Pinhole {
    let (width, height) = (rng.whole(96, 160), rng.whole(64, 120));
    let focal = f64::from(width) * rng.between(0.5, 1.4);
    Pinhole {
        width,
        height,
        fx: focal,
        fy: focal * rng.between(0.95, 1.05),
        cx: f64::from(width) * rng.between(0.3, 0.7),
        cy: f64::from(height) * rng.between(0.3, 0.7),
    }
}

/// Returns a random pose within 100 units of the origin.
fn any_pose(rng: &mut Rng) -> Pose {
    let rotation = DMat3::from_quat(any_rotation(rng));
    let mut coordinate = || rng.between(-100.0, 100.0);
    Pose { rotation, translation: dvec3(coordinate(), coordinate(), coordinate()) }
}

/// Returns a uniformly distributed rotation (Shoemake, *Uniform Random Rotations*, 1992).
fn any_rotation(rng: &mut Rng) -> DQuat {
    let share = rng.unit();
    let first = rng.between(0.0, TAU);
    let second = rng.between(0.0, TAU);
    let (r1, r2) = ((1.0 - share).sqrt(), share.sqrt());
    DQuat::from_xyzw(r1 * first.sin(), r1 * first.cos(), r2 * second.sin(), r2 * second.cos())
}

/// Returns corners on a circle in camera coordinates, in or near the photo. One polygon in ten is large and may
/// reach behind the camera.
fn any_polygon(rng: &mut Rng, camera: &Pinhole) -> Vec<DVec3> {
    let depth = 2.0 * (16.0_f64).powf(rng.unit());
    let (x, y) = (rng.between(-0.1, 1.1), rng.between(-0.1, 1.1));
    let at = dvec2(x * f64::from(camera.width), y * f64::from(camera.height));
    let centre = camera.ray_in_camera(at) * depth;
    let radius = depth * if rng.chance(0.1) { rng.between(1.0, 3.0) } else { rng.between(0.05, 0.4) };
    let axes = DMat3::from_quat(any_rotation(rng));
    let corners = rng.whole(3, 7);
    let start = rng.between(0.0, TAU);
    let on_circle = |i: u32| {
        let angle = start + TAU * (f64::from(i) + rng.between(0.0, 0.8)) / f64::from(corners);
        centre + radius * (axes.x_axis * angle.cos() + axes.y_axis * angle.sin())
    };
    (0..corners).map(on_circle).collect()
}
