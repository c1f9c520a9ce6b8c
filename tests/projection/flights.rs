//! Flights over a site, of which no two are alike.

use glam::{DQuat, DVec3};
use quadratura::testing::scene::Photo;
use quadratura::testing::scene::synthetic::Rng;
use quadratura::testing::view::Shot;
use quadratura::testing::view::flight::{Aim, Flight, FrameLens, Keyframe, Speed};

use crate::bench::Bench;

/// From one photo's camera to another one's, not straight and without looking straight ahead.
pub fn between(bench: &Bench, [from, to]: [usize; 2], seed: u64) -> Flight {
    let mut rng = Rng::new(seed);
    let [from, to] = [from, to].map(|photo| &bench.site.photos[photo]);
    let frame = |time_s: f64, position: DVec3, turn: DQuat, photo: &Photo| Keyframe {
        time_s,
        position,
        aim: Aim::Rotation(turn),
        lens: FrameLens::from_camera(&photo.camera),
    };
    let turn = |photo: &Photo| DQuat::from_mat3(&photo.pose.rotation.transpose());
    let eye = |photo: &Photo| photo.pose.center_in_world();
    let way = eye(from).distance(eye(to));
    let aside = DVec3::from_array([(); 3].map(|()| rng.between(-0.1, 0.1) * way));
    let tilt = DQuat::from_rotation_y(rng.between(-0.1, 0.1));
    let halfway = turn(from).slerp(turn(to), 0.5) * tilt;
    let keyframes = [
        frame(0.0, eye(from), turn(from), from),
        frame(0.5, eye(from).lerp(eye(to), rng.between(0.4, 0.6)) + aside, halfway, from),
        frame(1.0, eye(to), turn(to), to),
    ];
    Flight::new(&keyframes, [480, 320], Speed::Constant, DVec3::Z).unwrap()
}

/// What is seen on the way; all of it takes a second.
pub fn shot(flight: &Flight, time_s: f64) -> Shot {
    let (camera, pose) = flight.at(time_s);
    Shot::new(camera, pose)
}
