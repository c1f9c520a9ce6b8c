//! The shares of photos in the exposure of a view, by nearness to it.

use glam::DVec3;

use crate::Projector;
use quadratura_base::geometry::Pose;
use quadratura_base::scene::PhotoId;

/// The distance between a view and a photo, in radians, at which the common exposure weighs as much as the
/// photo's own.
const FADES_AT_RAD: f64 = 1.0;

/// The power of the distance by which weights decrease. Leaving out photo by photo, gains are predicted about
/// as well (within a tenth) by powers from 2 to 4 and fading from 0.5 to 2 rad, on one site whose exposures
/// follow the view and on one where they are random.
const POWER: i32 = 3;

/// The shares of the photos and of the common exposure in a view's gain; all sum to 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Shares {
    /// The share of each photo; 0 for those that do not take part.
    pub of_photo: Vec<f64>,
    /// The share of the common exposure: 0 at a photo's own camera, 1 far from all photos.
    pub of_common: f64,
    /// False for photos that must not contribute.
    pub takes_part: Vec<bool>,
}

impl Shares {
    /// Returns the share of one of several photos, which is all.
    pub(super) fn of_one(photo: PhotoId, count: usize) -> Self {
        let of_photo = PhotoId::all(count).map(|other| f64::from(u8::from(other == photo))).collect();
        Self { of_photo, of_common: 0.0, takes_part: vec![true; count] }
    }

    /// Computes the shares by nearness to a view alone: Shepard's interpolation (1968) of the photos' gains
    /// and of 0, the common exposure, which counts as a photo that is always one radian away.
    ///
    /// The distance combines parallax and rotation, in radians: a movement of the camera counts by the angle
    /// under which a surface at the distance `reach` (in world units) would see it. At a photo's own camera
    /// (position and direction; the lens does not matter) that photo's share is exactly 1, and shares are
    /// continuous in the camera everywhere. Photos in `without` have none.
    pub fn new(view: &Pose, reach: f64, photos: &[Projector], without: &[PhotoId]) -> Self {
        let takes_part: Vec<bool> =
            PhotoId::all(photos.len()).map(|photo| !without.contains(&photo)).collect();
        let distance = |(photo, takes_part): (&Projector, &bool)| match takes_part {
            true => distance_rad(view, &photo.pose, reach),
            false => f64::INFINITY,
        };
        let distances: Vec<f64> = photos.iter().zip(&takes_part).map(distance).collect();
        let nearest = distances.iter().copied().fold(FADES_AT_RAD, f64::min);
        // The weights are scaled so that the nearest photo has 1: nothing is divided by 0, and at a photo's
        // own camera all others vanish.
        let weight = |distance: f64| if distance <= nearest { 1.0 } else { (nearest / distance).powi(POWER) };
        let weights: Vec<f64> = distances.into_iter().map(weight).collect();
        let common = weight(FADES_AT_RAD);
        let all = common + weights.iter().sum::<f64>();
        let of_photo = weights.into_iter().map(|weight| weight / all).collect();
        Self { of_photo, of_common: common / all, takes_part }
    }
}

fn distance_rad(view: &Pose, photo: &Pose, reach: f64) -> f64 {
    let step = (view.center_in_world() - photo.center_in_world()).length() / reach;
    // The angle is computed from the chord, which is exactly 0 for equal directions.
    let turn = 2.0 * (0.5 * (forward(view) - forward(photo)).length()).min(1.0).asin();
    step.hypot(turn)
}

fn forward(pose: &Pose) -> DVec3 {
    pose.rotation.transpose() * DVec3::Z
}
