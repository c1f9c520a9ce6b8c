//! The exposure of a view: a blend of the photos' gains by nearness.

use glam::DVec3;

use super::Gains;
use crate::geometry::Pose;
use crate::projection::{PhotoId, Projector};

/// How far a view is from a photo when the common exposure counts as much as the photo's own, in
/// radians.
const FADES_AT_RAD: f64 = 1.0;

/// Weights fall with this power of the distance. Leaving out photo by photo, gains are predicted
/// about as well (within a tenth) by powers from 2 to 4 and fading from 0.5 to 2 rad, on one site whose
/// exposures follow the view (2.5 times better than by the common exposure) and on one where they were
/// drawn by lot (1.4 times).
const POWER: i32 = 3;

/// The log gain of a view, R, G, B: Shepard's interpolation (1968) of the photos' gains and of 0, the
/// common exposure, which counts as a photo that is always [`FADES_AT_RAD`] away.
///
/// Nearness is measured in radians, of parallax and of turning: a step of the camera counts by the
/// angle under which a surface at [`Gains::reach`] would see it. At a photo's own camera (position and
/// direction; the lens does not matter) the result is exactly that photo's gain, and it is continuous
/// in the camera everywhere. Photos in `without` do not count.
pub fn view_gain(view: &Pose, gains: &Gains, photos: &[Projector], without: &[PhotoId]) -> [f64; 3] {
    let taking_part = (0..).map(PhotoId).zip(photos).filter(|(id, _)| !without.contains(id));
    let near = taking_part
        .map(|(id, photo)| (distance_rad(view, &photo.pose, gains.reach), gains.of_photo[id.0 as usize]));
    let mut near: Vec<(f64, [f64; 3])> = near.collect();
    near.push((FADES_AT_RAD, [0.0; 3]));
    let nearest = near.iter().map(|(distance, _)| *distance).fold(f64::INFINITY, f64::min);
    // Scaled such that the nearest has 1: nothing is divided by 0, and in a photo's own camera all
    // others vanish.
    let weight = |distance: f64| if distance <= nearest { 1.0 } else { (nearest / distance).powi(POWER) };
    let all: f64 = near.iter().map(|(distance, _)| weight(*distance)).sum();
    let blend = |c: usize| near.iter().map(|(distance, gain)| weight(*distance) * gain[c]).sum::<f64>() / all;
    [0, 1, 2].map(blend)
}

fn distance_rad(view: &Pose, photo: &Pose, reach: f64) -> f64 {
    let step = (view.center_in_world() - photo.center_in_world()).length() / reach;
    // By the chord, which is exactly 0 for equal directions.
    let turn = 2.0 * (0.5 * (forward(view) - forward(photo)).length()).min(1.0).asin();
    step.hypot(turn)
}

fn forward(pose: &Pose) -> DVec3 {
    pose.rotation.transpose() * DVec3::Z
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::synthetic::{Dice, centred, look_at};

    fn photos(dice: &mut Dice, count: usize) -> (Vec<Projector>, Gains) {
        let mut place = || DVec3::new(dice.between(-9.0, 9.0), dice.between(-9.0, 9.0), 2.0);
        let poses: Vec<Pose> = (0..count).map(|_| look_at(place(), place() + DVec3::Z)).collect();
        let camera = centred(300, 200, 300.0);
        let projector = |pose| Projector { name: String::new(), camera, pose };
        let of_photo = (0..count).map(|_| [0; 3].map(|_: i32| dice.between(-0.5, 0.5))).collect();
        (poses.into_iter().map(projector).collect(), Gains { of_photo, reach: 8.0 })
    }

    #[test]
    fn a_photos_own_camera_has_exactly_its_gain() {
        let (photos, gains) = photos(&mut Dice::new(11), 30);
        for (photo, gain) in photos.iter().zip(&gains.of_photo) {
            assert_eq!(view_gain(&photo.pose, &gains, &photos, &[]), *gain);
        }
    }

    #[test]
    fn a_photo_left_out_does_not_tell_its_gain() {
        let (photos, mut gains) = photos(&mut Dice::new(12), 5);
        let own = PhotoId(2);
        let before = view_gain(&photos[2].pose, &gains, &photos, &[own]);
        gains.of_photo[2] = [9.0; 3];
        assert_eq!(view_gain(&photos[2].pose, &gains, &photos, &[own]), before);
    }

    #[test]
    fn a_small_step_of_the_camera_is_a_small_step_of_the_gain() {
        let (photos, gains) = photos(&mut Dice::new(13), 12);
        let eye = photos[3].pose.center_in_world();
        let at = |step: f64| {
            let pose = look_at(eye + DVec3::new(step, 0.3 * step, 0.0), DVec3::new(0.0, 1.0, 2.0 + step));
            view_gain(&pose, &gains, &photos, &[])
        };
        let largest = |steps: i32| {
            let apart = |k: i32| {
                (at(f64::from(k) / f64::from(steps))[0] - at(f64::from(k + 1) / f64::from(steps))[0]).abs()
            };
            (-steps..steps).map(apart).fold(0.0, f64::max)
        };
        let (coarse, fine) = (largest(500), largest(1000));
        assert!(fine < 0.6 * coarse && coarse < 0.02, "{coarse} {fine}");
    }

    #[test]
    fn far_from_every_photo_the_exposure_is_the_common_one() {
        let (photos, gains) = photos(&mut Dice::new(14), 4);
        let pose = look_at(DVec3::new(900.0, 0.0, 2.0), DVec3::new(1000.0, 1.0, 2.0));
        assert!(view_gain(&pose, &gains, &photos, &[]).iter().all(|gain| gain.abs() < 1e-3));
        assert_eq!(view_gain(&pose, &Gains::none(0), &[], &[]), [0.0; 3]);
    }
}
