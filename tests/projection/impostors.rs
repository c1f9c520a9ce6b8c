//! Impostors: the GPU's pictures against the twin's, photos in their own cameras, and no popping around a tree.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DQuat, DVec2, DVec3};
use quadratura::task::Task;
use quadratura::testing::projection::relief::Relief;
use quadratura::testing::scene::impostor::{Facing, Impostor};
use quadratura::testing::scene::synthetic::{Rng, Scene, centred, look_at, random};
use quadratura::testing::scene::{FaceId, Object};
use quadratura::testing::view::{Exposure, Mode, Shot};

use crate::bench::Bench;
use crate::mattes::put_mattes;
use crate::own_camera::check;
use crate::random_scenes::compare;

/// The scene in which every other object turns about what is up in its camera.
pub fn turning(mut scene: Scene) -> Scene {
    let up = -(scene.pose.rotation.transpose() * DVec3::Y);
    let model = Arc::unwrap_or_clone(scene.model);
    let names: Vec<String> = model.objects.iter().map(|object| object.name.clone()).collect();
    let turns =
        |object: &Object| names.iter().position(|name| *name == object.name).is_some_and(|i| i % 2 == 1);
    let (model, refused) = model.with_impostors(up, turns);
    assert!(model.has_impostors(), "{refused:?}");
    scene.model = Arc::new(model);
    scene
}

#[test]
fn the_gpu_and_its_twin_turn_impostors_alike() {
    let scenes = (51..=53).flat_map(|seed| [random::soup(seed, 24), random::boxes(seed, 8)]).map(turning);
    compare(scenes, |bench, rng| bench.pin(0.2, rng), |_| Relief::default(), "impostors");
}

fn piazza(photos: &[&str]) -> Option<Bench> {
    Bench::turning_piazza(photos, |object| object.name.contains("billboard"))
}

#[test]
fn the_piazzas_photos_come_back_in_their_own_cameras_with_trees_that_turn() {
    let Some(bench) = piazza(&["01", "02", "03", "08"]) else { return };
    // Previews take sRGB for a quartic, which is off by up to 0.7 steps: 51 dB.
    check(&bench, 1, 0.5, [55.0, 50.0]);
}

/// The number of places around a tree at which changes are looked at.
const STEPS: u32 = 120;

/// The stretch over which they are, in radians: short, so that changes are nearly linear.
const STRIDE: f64 = 1e-3;

/// The largest ratio between the change over half of a stretch and over all of it: a linear change has 0.5, a jump 1.
const GRADUAL: f64 = 0.6;

/// The least jump that counts, in linear light. Where a curve turns within a stretch, the change over all of it is small
/// and the ratio says nothing; such changes are as small as the stretch.
const LEAST_JUMP: f64 = 1e-3;

/// A view of a tree from some angle about its axis.
fn around(tree: &Impostor, angle: f64) -> Shot {
    let middle = tree.foot + tree.axis * (0.5 * tree.height);
    let beside = tree.axis.any_orthonormal_vector();
    let eye = middle + DQuat::from_axis_angle(tree.axis, angle) * beside * (3.0 * tree.height);
    Shot::new(centred(200, 150, 240.0), look_at(eye, middle))
}

#[test]
fn nothing_pops_on_a_flight_around_a_tree() {
    let Some(bench) = piazza(&["01", "02", "03", "04", "05", "08"]) else { return };
    fly_around(&bench);
}

#[test]
fn neither_colours_nor_mattes_pop_on_a_flight_around_a_tree_that_one_sees_through() {
    let Some(mut bench) = piazza(&["01", "02", "03", "04", "05", "08"]) else { return };
    put_mattes(&mut bench);
    fly_around(&bench);
}

fn fly_around(bench: &Bench) {
    let model = &bench.site.model;
    let names_tree = |face: &FaceId| model.face_name(*face) == "tree_1.billboard[0]";
    let face: FaceId = model.face_ids().find(names_tree).expect("the piazza has trees");
    let tree = *model.impostor(face).unwrap();
    let mut twin = bench.twin(&Relief::default());
    let mut rng = Rng::new(7);
    let places: Vec<DVec2> = (0..250)
        .map(|_| DVec2::new(rng.between(-0.9, 0.9) * tree.half_width, rng.between(0.1, 0.9) * tree.height))
        .collect();
    let mut worst_jump = |mode: Mode| {
        let mut shown = |angle: f64| -> Vec<Option<[f64; 4]>> {
            let mut shot = around(&tree, angle);
            shot.blend.mode = mode;
            // Exposure follows the view by itself, and is tested beside other surfaces.
            shot.exposure = Exposure::Raw;
            let facing = Facing::of_pose(&shot.pose);
            let points: Vec<_> = places.iter().map(|place| (face, tree.point(&facing, *place))).collect();
            twin.colours_at(&shot, &points, &Task::silent()).unwrap()
        };
        let (mut compared, mut worst) = (0, 0.0f64);
        for i in 0..STEPS {
            let from = f64::from(i) * TAU / f64::from(STEPS);
            let [a, b, c] = [0.0, 0.5, 1.0].map(|share| shown(from + share * STRIDE));
            for ((a, b), c) in a.into_iter().zip(b).zip(c) {
                let (Some(a), Some(b), Some(c)) = (a, b, c) else { continue };
                let change =
                    |a: [f64; 4], b: [f64; 4]| (0..4).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max);
                let half = change(a, b).max(change(b, c));
                compared += 1;
                if half > GRADUAL * change(a, c) {
                    worst = worst.max(half);
                }
            }
        }
        assert!(compared > 20_000, "{compared}");
        worst
    };
    let best = worst_jump(Mode::Best);
    assert!(best > 10.0 * LEAST_JUMP, "where another photo becomes the best one, colours jump: {best}");
    for mode in [Mode::Debevec, Mode::Lumigraph, Mode::Smooth] {
        let worst = worst_jump(mode);
        println!("{mode}: {worst}; {}: {best}", Mode::Best);
        assert!(worst < LEAST_JUMP, "{mode}: {worst}");
    }
}
