//! Tests that flights pass smoothly through their keyframes, without flips.

use super::*;
use quadratura_base::scene::synthetic::Rng;

const SIZE: [u32; 2] = [640, 360];

fn random_rotation(rng: &mut Rng) -> DQuat {
    let mut part = || rng.between(-1.0, 1.0);
    DQuat::from_xyzw(part(), part(), part(), part()).normalize()
}

fn random_keyframes(seed: u64, count: usize, looks_at: bool) -> Vec<Keyframe> {
    let mut rng = Rng::new(seed);
    let mut time_s = 3.0;
    let keyframe = |_| {
        time_s += rng.between(0.5, 2.0);
        let position = DVec3::new(rng.between(-9.0, 9.0), rng.between(-9.0, 9.0), rng.between(0.0, 4.0));
        let aim = if looks_at {
            Aim::At(DVec3::new(rng.between(-2.0, 2.0), rng.between(20.0, 30.0), 1.0))
        } else {
            Aim::Rotation(random_rotation(&mut rng))
        };
        Keyframe { time_s, position, aim, lens: FrameLens::with_field_of_view(rng.between(0.3, 1.5)) }
    };
    (0..count).map(keyframe).collect()
}

fn flight(keyframes: &[Keyframe], speed: Speed) -> Flight {
    Flight::new(keyframes, SIZE, speed, DVec3::Z).unwrap()
}

/// Returns the difference of two poses: in position, and in the direction of every axis.
fn gap(a: &Pose, b: &Pose) -> f64 {
    let turned = a.rotation - b.rotation;
    a.center_in_world().distance(b.center_in_world())
        + [turned.x_axis, turned.y_axis, turned.z_axis].map(DVec3::length).into_iter().sum::<f64>()
}

#[test]
fn a_timed_flight_passes_through_its_keyframes_at_their_times() {
    for looks_at in [false, true] {
        let keyframes = random_keyframes(1, 7, looks_at);
        let flight = flight(&keyframes, Speed::Timed);
        for frame in &keyframes {
            let (camera, pose) = flight.at(frame.time_s);
            assert!(pose.center_in_world().distance(frame.position) < 1e-9);
            let expected = frame.lens.camera(SIZE[0], SIZE[1]);
            assert!((camera.fy / expected.fy - 1.0).abs() < 1e-9);
            match frame.aim {
                Aim::At(point) => {
                    let px = camera.image_from_camera(pose.camera_from_world(point)).unwrap();
                    assert!((px - glam::DVec2::new(320.0, 180.0)).length() < 1e-6, "{px}");
                    assert!(pose.rotation_rows()[0][2].abs() < 1e-12, "the horizon is level");
                }
                Aim::Rotation(rotation) => {
                    let expected = DMat3::from_quat(rotation).transpose();
                    assert!(gap(&pose, &Pose { rotation: expected, ..pose }) < 1e-6);
                }
            }
        }
    }
}

#[test]
fn speed_does_not_jump_anywhere() {
    for (looks_at, speed) in
        [(false, Speed::Timed), (true, Speed::Timed), (false, Speed::Constant), (true, Speed::Eased)]
    {
        let keyframes = random_keyframes(2, 6, looks_at);
        let flight = flight(&keyframes, speed);
        let [start, end] = flight.span_s();
        // Velocities are estimated by differences. Across a jump the velocities of two steps differ by the
        // jump however short the steps are; on a smooth path they differ in proportion to the step.
        let largest_change = |step: f64| {
            let count = ((end - start) / step) as usize;
            let velocity = |i: usize| {
                let at = |j: usize| flight.at(start + j as f64 * step).1;
                let (a, b) = (at(i), at(i + 1));
                let turned = (b.rotation - a.rotation) * (1.0 / step);
                ((b.center_in_world() - a.center_in_world()) / step, turned)
            };
            let change = |i: usize| {
                let ((v, r), (w, s)) = (velocity(i), velocity(i + 1));
                let turned = s - r;
                v.distance(w) + turned.x_axis.length() + turned.y_axis.length() + turned.z_axis.length()
            };
            (0..count - 2).map(change).fold(0.0, f64::max)
        };
        let (coarse, fine) = (largest_change(1e-2), largest_change(1e-3));
        assert!(fine < 0.2 * coarse, "{looks_at} {speed:?}: {coarse} {fine}");
    }
}

#[test]
fn a_quaternion_and_its_negative_make_the_same_flight() {
    let keyframes = random_keyframes(3, 6, false);
    let mut negated = keyframes.clone();
    for frame in negated.iter_mut().step_by(2) {
        let Aim::Rotation(rotation) = frame.aim else { unreachable!() };
        frame.aim = Aim::Rotation(-rotation);
    }
    let (a, b) = (flight(&keyframes, Speed::Timed), flight(&negated, Speed::Timed));
    for i in 0..200 {
        let time = 3.0 + f64::from(i) * 0.05;
        assert!(gap(&a.at(time).1, &b.at(time).1) < 1e-9, "{time}");
    }
}

#[test]
fn small_turns_stay_small_between_keyframes() {
    // Keyframes are ten degrees apart; no direction between them may deviate much more.
    let mut rng = Rng::new(4);
    let mut keyframes = random_keyframes(5, 8, false);
    let mut rotation = random_rotation(&mut rng);
    for frame in &mut keyframes {
        frame.aim = Aim::Rotation(rotation);
        let axis = DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), 0.3).normalize();
        rotation *= DQuat::from_axis_angle(axis, 10f64.to_radians());
    }
    let flight = flight(&keyframes, Speed::Timed);
    for pair in keyframes.windows(2) {
        let Aim::Rotation(before) = pair[0].aim else { unreachable!() };
        for i in 0..=20 {
            let time = pair[0].time_s + (pair[1].time_s - pair[0].time_s) * f64::from(i) / 20.0;
            let forward = flight.at(time).1.rotation.transpose() * DVec3::Z;
            let off = forward.angle_between(before * DVec3::Z).to_degrees();
            assert!(off < 15.0, "{off} degrees");
        }
    }
}

#[test]
fn a_constant_flight_moves_by_equal_parts_and_an_eased_one_starts_and_ends_at_rest() {
    // Keyframes on a line, unevenly spaced in position and time, with the same direction.
    let keyframe = |(time_s, x): (f64, f64)| Keyframe {
        time_s,
        position: DVec3::new(x, 0.0, 0.0),
        aim: Aim::Rotation(DQuat::IDENTITY),
        lens: FrameLens::with_field_of_view(1.0),
    };
    let keyframes: Vec<_> = [(0.0, 0.0), (1.0, 6.0), (7.0, 7.0), (10.0, 10.0)].map(keyframe).into();
    let x = |flight: &Flight, time: f64| flight.at(time).1.center_in_world().x;
    let constant = flight(&keyframes, Speed::Constant);
    let eased = flight(&keyframes, Speed::Eased);
    for i in 0..=10 {
        let time = f64::from(i);
        assert!((x(&constant, time) - time).abs() < 2e-3, "{time}: {}", x(&constant, time));
    }
    assert!((x(&eased, 5.0) - 5.0).abs() < 2e-3);
    assert!(x(&eased, 0.1) < 0.01 && x(&eased, 9.9) > 9.99);
}

#[test]
fn a_film_has_its_first_and_last_keyframe_and_a_still_flight_stands() {
    let keyframes = random_keyframes(6, 4, false);
    let frames = flight(&keyframes, Speed::Timed).frames(25.0);
    let seconds = keyframes[3].time_s - keyframes[0].time_s;
    assert_eq!(frames.len(), (seconds * 25.0).round() as usize + 1);
    for (frame, keyframe) in [(0, 0), (frames.len() - 1, 3)] {
        let center = frames[frame].1.center_in_world();
        assert!(center.distance(keyframes[keyframe].position) < 1e-9);
    }
    let alone = flight(&keyframes[..1], Speed::Eased).frames(25.0);
    assert_eq!(alone.len(), 1);
    let still = [keyframes[0], Keyframe { time_s: 9.0, ..keyframes[0] }];
    let still = flight(&still, Speed::Constant).frames(2.0);
    assert!(still.iter().all(|frame| gap(&frame.1, &still[0].1) < 1e-9));
}

#[test]
fn what_cannot_be_flown_is_told_by_keyframe() {
    let mut keyframes = random_keyframes(7, 4, true);
    let problem = |keyframes: &[Keyframe]| Flight::new(keyframes, SIZE, Speed::Timed, DVec3::Z).unwrap_err();
    assert_eq!(problem(&[]).0, 0);
    keyframes[2].time_s = keyframes[1].time_s;
    assert_eq!(problem(&keyframes).0, 2);
    keyframes[2].time_s += 0.01;
    keyframes[1].aim = Aim::At(keyframes[1].position + DVec3::Z);
    let (index, found) = problem(&keyframes);
    assert!(index == 1 && found.contains("straight up"), "{found}");
}
