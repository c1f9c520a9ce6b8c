//! Colours change little by little with the camera.

use glam::{DQuat, DVec2, DVec3};
use quadratura::geometry::Pose;
use quadratura::projection::relief::Relief;
use quadratura::projection::surface::Surface;
use quadratura::projection::{Mode, Shot};
use quadratura::scene::FaceId;
use quadratura::scene::light::srgb_of_linear;
use quadratura::scene::synthetic::Dice;
use quadratura::task::Task;

use crate::bench::Bench;

/// The camera at a share of the way between two photos'.
fn on_the_way(bench: &Bench, share: f64) -> Shot {
    let [a, b] = [0, 1].map(|photo| &bench.site.photos[photo]);
    let turn = |pose: &Pose| DQuat::from_mat3(&pose.rotation);
    let rotation = glam::DMat3::from_quat(turn(&a.pose).slerp(turn(&b.pose), share));
    let center = a.pose.center_in_world().lerp(b.pose.center_in_world(), share);
    Shot::new(a.camera, Pose { rotation, translation: -(rotation * center) })
}

/// Surface points that a view sees, with their faces.
fn seen(surface: &Surface, shot: &Shot, dice: &mut Dice, count: usize) -> Vec<(FaceId, DVec3)> {
    let mut points = Vec::with_capacity(count);
    while points.len() < count {
        let (w, h) = (f64::from(shot.camera.width), f64::from(shot.camera.height));
        let px = DVec2::new(dice.between(0.0, w), dice.between(0.0, h));
        let direction = shot.pose.rotation.transpose() * shot.camera.ray_in_camera(px);
        let hit = surface.owner(shot.viewpoint(), direction, 1e-4);
        points.extend(hit.map(|hit| (hit.face, shot.viewpoint() + direction * hit.t)));
    }
    points
}

fn is_seen(surface: &Surface, shot: &Shot, (face, point): &(FaceId, DVec3)) -> bool {
    let eye = shot.viewpoint();
    surface.owner(eye, *point - eye, 1e-4).is_some_and(|hit| hit.face == *face)
}

/// In steps of 8 bits, without rounding.
fn step(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|c| 255.0 * (srgb_of_linear(a[c]) - srgb_of_linear(b[c])).abs()).fold(0.0, f64::max)
}

/// The largest change of colour over a step of the flight, of points that both ends see.
fn largest_change(bench: &Bench, mode: Mode, from: f64, steps: &[f64], points: usize) -> Vec<f64> {
    let surface = Surface::of(&bench.site.model);
    let mut twin = bench.twin(&Relief::default());
    let task = Task::silent();
    let shot = |share: f64| {
        let mut shot = on_the_way(bench, share);
        shot.blend.mode = mode;
        shot
    };
    let first = shot(from);
    let points = seen(&surface, &first, &mut Dice::new(61), points);
    let before = twin.colours_at(&first, &points, &task).unwrap();
    let change = |length: &f64| {
        let next = shot(from + length);
        let after = twin.colours_at(&next, &points, &task).unwrap();
        let both = points.iter().zip(before.iter().zip(&after)).filter(|(p, _)| is_seen(&surface, &next, p));
        let changes = both.map(|(_, colours)| match colours {
            (Some(a), Some(b)) => step(a, b),
            (None, None) => 0.0,
            _ => 255.0,
        });
        changes.fold(0.0, f64::max)
    };
    steps.iter().map(change).collect()
}

#[test]
fn nothing_pops_on_a_flight_between_two_photos() {
    let Some(bench) = Bench::piazza(&["01", "02", "03", "08"]) else { return };
    for mode in [Mode::Debevec, Mode::Lumigraph, Mode::Smooth] {
        for from in [0.05, 0.25, 0.5, 0.75] {
            let changes = largest_change(&bench, mode, from, &[1e-3, 0.5e-3], 10_000);
            println!("{mode} at {from}: {:.3}, half a step {:.3}", changes[0], changes[1]);
            assert!(changes[0] <= 2.0, "{mode} at {from}: {changes:?}");
            // A step that is no jump becomes smaller with its length; a quarter of slack for curvature.
            assert!(changes[1] <= 0.625 * changes[0], "{mode} at {from}: {changes:?}");
        }
    }
}
