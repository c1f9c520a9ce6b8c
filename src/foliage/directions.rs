//! The directions from which sub-objects are seen in their images, 22 (Max 1996) or six (Max, Deussen & Keating 1999), and which of
//! them serve a viewpoint.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// The number of directions all around.
pub const DIRECTIONS: usize = 22;

/// The directions from which the images of a plant are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Directions {
    /// The 22 of [`ANGLES`] (Max 1996).
    #[default]
    Around,
    /// The six along the axes: +x, -x, +y, -y, +z, -z (Max, Deussen & Keating 1999).
    Axes,
}

/// The six directions along the axes, as indices of [`ANGLES`].
const AXES: [usize; 6] = [2, 6, 4, 8, 0, 1];

impl Directions {
    /// Returns the number of directions.
    pub fn count(self) -> usize {
        match self {
            Self::Around => DIRECTIONS,
            Self::Axes => AXES.len(),
        }
    }

    /// Returns the index in [`ANGLES`] of a direction.
    fn of_all(self, direction: usize) -> usize {
        match self {
            Self::Around => direction,
            Self::Axes => AXES[direction],
        }
    }

    /// Returns latitude and longitude of a direction in degrees.
    pub fn angles(self, direction: usize) -> (i32, i32) {
        ANGLES[self.of_all(direction)]
    }

    /// Returns the rotation from a sub-object's frame to the frame of the view from a direction ([`view_from_object`]).
    pub fn view_from_object(self, direction: usize) -> DMat3 {
        view_from_object(self.of_all(direction))
    }

    /// Returns the directions whose images serve a viewpoint in the direction `towards_viewer`, of any length but 0, with weights.
    pub fn serving(self, towards_viewer: DVec3) -> Vec<Serving> {
        match self {
            Self::Around => serving_images(towards_viewer),
            Self::Axes => serving_axes(towards_viewer),
        }
    }
}

/// Rings of directions from the south pole to the north pole: the index of the first, and how many.
const RINGS: [(usize, usize); 5] = [(1, 1), (16, 6), (2, 8), (10, 6), (0, 1)];

/// Latitude and longitude in degrees of each direction.
pub const ANGLES: [(i32, i32); DIRECTIONS] = [
    (90, 0),
    (-90, 0),
    (0, 0),
    (0, 45),
    (0, 90),
    (0, 135),
    (0, 180),
    (0, 225),
    (0, 270),
    (0, 315),
    (45, 0),
    (45, 60),
    (45, 120),
    (45, 180),
    (45, 240),
    (45, 300),
    (-45, 0),
    (-45, 60),
    (-45, 120),
    (-45, 180),
    (-45, 240),
    (-45, 300),
];

/// Returns the direction towards the viewer, of length 1, in the sub-object's frame.
pub fn towards_viewer(direction: usize) -> DVec3 {
    -view_from_object(direction).row(2)
}

/// Returns the rotation from a sub-object's frame to the frame of one of its views: x right, y down, z away from the viewer.
pub fn view_from_object(direction: usize) -> DMat3 {
    let (latitude, longitude) = ANGLES[direction];
    let (sin_lat, cos_lat) = exact_sin_cos(latitude);
    let (sin_lon, cos_lon) = exact_sin_cos(longitude);
    let towards = DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat);
    let right = DVec3::new(-sin_lon, cos_lon, 0.0);
    let up = towards.cross(right);
    DMat3::from_cols(right, -up, -towards).transpose()
}

/// Sine and cosine in degrees, exact where they are 0 or 1.
fn exact_sin_cos(degrees: i32) -> (f64, f64) {
    match degrees.rem_euclid(360) {
        0 => (0.0, 1.0),
        90 => (1.0, 0.0),
        180 => (0.0, -1.0),
        270 => (-1.0, 0.0),
        other => f64::from(other).to_radians().sin_cos(),
    }
}

/// A direction whose image serves a viewpoint, with its weight, above 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Serving {
    /// The index of the direction.
    pub direction: usize,
    /// The weight; those of all that serve sum to 1.
    pub weight: f64,
}

/// Returns the three or four directions around a viewpoint in the direction `towards_viewer`, of any length but 0: two each of the
/// rings of latitude below and above it, or one of a pole. Weights are bilinear in latitude and longitude and change continuously;
/// the nearest direction is one of those returned. Openness uses them all; [`Directions::serving`] leaves out those whose images are not
/// drawn. Published, all four have the same weight.
pub fn serving(towards_viewer: DVec3) -> Vec<Serving> {
    let latitude = towards_viewer.z.atan2(towards_viewer.truncate().length());
    let longitude = towards_viewer.y.atan2(towards_viewer.x);
    let ring = (latitude + 0.5 * PI) / FRAC_PI_4;
    let below = (ring.floor().max(0.0) as usize).min(RINGS.len() - 2);
    let share = (ring - below as f64).clamp(0.0, 1.0);
    let mut serving = Vec::with_capacity(4);
    for (ring, weight) in [(below, 1.0 - share), (below + 1, share)] {
        let (first, count) = RINGS[ring];
        let step = (longitude / TAU).rem_euclid(1.0) * count as f64;
        let before = (step.floor() as usize).min(count - 1);
        let share = if count == 1 { 0.0 } else { step - before as f64 };
        let pair = [(before, 1.0 - share), ((before + 1) % count, share)];
        serving.extend(pair.map(|(at, share)| Serving { direction: first + at, weight: weight * share }));
    }
    serving.retain(|serving| serving.weight > 0.0);
    serving
}

/// This share of the largest weight is subtracted from all weights of directions whose images are drawn. All samples of an image are drawn however
/// small the weight of its direction is, and what a direction farther away shows is less like the view (docs/quality.md).
const NEGLIGIBLE: f64 = 0.4;

/// Returns those one to four of the directions around a viewpoint whose images are drawn. Their weights are those of [`serving`], less
/// [`NEGLIGIBLE`] of the largest one, over their sum; they change continuously, too.
fn serving_images(towards_viewer: DVec3) -> Vec<Serving> {
    let mut serving = serving(towards_viewer);
    let negligible = NEGLIGIBLE * serving.iter().map(|of| of.weight).fold(0.0, f64::max);
    serving.iter_mut().for_each(|of| of.weight -= negligible);
    serving.retain(|of| of.weight > 0.0);
    let sum: f64 = serving.iter().map(|of| of.weight).sum();
    serving.iter_mut().for_each(|of| of.weight /= sum);
    serving
}

/// Returns the axes that face a viewpoint, three at most. Their weights are the squares of the cosines to them, which sum to 1.
fn serving_axes(towards_viewer: DVec3) -> Vec<Serving> {
    let towards = towards_viewer.normalize_or(DVec3::Z).to_array();
    let of_axis = |(axis, cosine): (usize, f64)| Serving {
        direction: 2 * axis + usize::from(cosine < 0.0),
        weight: cosine * cosine,
    };
    let serving = towards.into_iter().enumerate().map(of_axis);
    serving.filter(|serving| serving.weight > 0.0).collect()
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    fn any_direction(rng: &mut Rng) -> DVec3 {
        let mut axis = || rng.between(-1.0, 1.0);
        DVec3::new(axis(), axis(), axis())
    }

    fn weights(towards_viewer: DVec3) -> [f64; DIRECTIONS] {
        let mut weights = [0.0; DIRECTIONS];
        serving(towards_viewer).iter().for_each(|of| weights[of.direction] += of.weight);
        weights
    }

    #[test]
    fn there_are_eleven_pairs_of_opposite_directions_in_upright_right_handed_frames() {
        for direction in 0..DIRECTIONS {
            let towards = towards_viewer(direction);
            let opposite = |other: &usize| towards_viewer(*other).distance(-towards) < 1e-12;
            assert_eq!((0..DIRECTIONS).filter(opposite).count(), 1, "{direction}");
            let rotation = view_from_object(direction);
            assert!((rotation.determinant() - 1.0).abs() < 1e-12);
            // Up in space is up in the image, or nowhere for the poles.
            assert!((rotation * DVec3::Z).y <= 1e-12);
        }
    }

    #[test]
    fn no_direction_is_farther_than_30_3_degrees_from_one_and_16_6_on_average() {
        let mut rng = Rng::new(4);
        let (mut worst, mut sum) = (0.0f64, 0.0);
        let mut count = 0;
        for _ in 0..40_000 {
            let direction = any_direction(&mut rng);
            if !(0.01..1.0).contains(&direction.length_squared()) {
                continue;
            }
            let angle = |of: usize| direction.angle_between(towards_viewer(of)).to_degrees();
            let nearest = (0..DIRECTIONS).map(angle).fold(f64::MAX, f64::min);
            (worst, sum, count) = (worst.max(nearest), sum + nearest, count + 1);
        }
        assert!(worst <= 30.4 && worst > 29.5, "{worst}");
        assert!((sum / f64::from(count) - 16.6).abs() < 0.2, "{}", sum / f64::from(count));
    }

    #[test]
    fn weights_sum_to_one_and_are_one_at_a_direction_itself() {
        let mut rng = Rng::new(5);
        for _ in 0..2000 {
            let sum: f64 = weights(any_direction(&mut rng)).iter().sum();
            assert!((sum - 1.0).abs() < 1e-12);
        }
        for direction in 0..DIRECTIONS {
            assert!((weights(3.0 * towards_viewer(direction))[direction] - 1.0).abs() < 1e-9, "{direction}");
        }
    }

    #[test]
    fn two_images_are_drawn_about_halfway_between_their_directions_and_one_near_by() {
        let at = |latitude: f64, longitude: f64| {
            let (sine, cosine) = latitude.to_radians().sin_cos();
            let towards = (cosine * DVec2::from_angle(longitude.to_radians())).extend(sine);
            let of = Directions::Around.serving(towards);
            of.into_iter().map(|of| (ANGLES[of.direction], (100.0 * of.weight).round())).collect::<Vec<_>>()
        };
        assert_eq!(at(0.0, 22.5), [((0, 0), 50.0), ((0, 45), 50.0)]);
        // (2/3, 1/3) less 0.4 * 2/3, over their sum: (0.4, 0.0667) / 0.4667.
        assert_eq!(at(0.0, 15.0), [((0, 0), 86.0), ((0, 45), 14.0)]);
        assert_eq!(at(0.0, 12.0), [((0, 0), 100.0)]);
        assert_eq!(at(90.0, 12.0), [((90, 0), 100.0)]);
        let mut rng = Rng::new(8);
        let count: usize = (0..4000).map(|_| Directions::Around.serving(any_direction(&mut rng)).len()).sum();
        // 1.88 of 20,000 directions that are spread evenly; these are of a cube.
        assert!((count as f64 / 4000.0 - 1.88).abs() < 0.1, "{count}");
    }

    #[test]
    fn weights_of_images_change_without_a_jump_and_the_nearest_direction_is_drawn() {
        let mut rng = Rng::new(24);
        const STEP: f64 = 1e-3;
        let weights = |towards: DVec3| {
            let mut weights = [0.0; DIRECTIONS];
            Directions::Around.serving(towards).iter().for_each(|of| weights[of.direction] += of.weight);
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            weights
        };
        for _ in 0..50 {
            // All the way round, so that every place at which a weight could jump on this circle is passed.
            let (across, along) = any_direction(&mut rng).normalize_or(DVec3::Z).any_orthonormal_pair();
            let mut before = weights(across);
            for step in 1..=(TAU / STEP).ceil() as u32 {
                let (sine, cosine) = (STEP * f64::from(step)).sin_cos();
                let towards = cosine * across + sine * along;
                let now = weights(towards);
                // Bilinear weights change by 4/PI per radian by latitude, and by 6/TAU/cos 45 degrees by longitude at most. What is left
                // of up to four, each changed by 1.4 times that at most, is divided by 0.27 at least (beside one of 1/2.2, three that
                // just begin). A direction that came at once would have 0.12 at least.
                let most = (0..DIRECTIONS).map(|of| (now[of] - before[of]).abs()).fold(0.0, f64::max);
                assert!(most < 5.0 * 1.4 * 2.6 * STEP / 0.27, "{towards}: {before:?}, {now:?}");
                let angle = |of: &usize| towards.angle_between(towards_viewer(*of));
                let nearest = (0..DIRECTIONS).min_by(|a, b| angle(a).total_cmp(&angle(b))).unwrap();
                assert!(now[nearest] > 0.0, "{towards}");
                before = now;
            }
        }
    }

    #[test]
    fn axes_that_face_the_viewpoint_serve_and_what_they_show_of_a_surface_sums_to_all_of_it() {
        let mut rng = Rng::new(7);
        for _ in 0..4000 {
            let (towards, normal) = (any_direction(&mut rng), any_direction(&mut rng));
            let normal = if normal.dot(towards) < 0.0 { -normal } else { normal };
            let serving = Directions::Axes.serving(towards);
            assert!(
                (serving.iter().map(|of| of.weight).sum::<f64>() - 1.0).abs() < 1e-12 && serving.len() <= 3
            );
            // A surface of this normal is spread by J = n.v / (n_a v_a) when what axis a sees of it is moved to the view.
            let shares = serving.iter().map(|of| {
                let axis = -Directions::Axes.view_from_object(of.direction).row(2);
                assert!(axis.dot(towards) > 0.0);
                (axis.dot(normal) * axis.dot(towards) / normal.dot(towards)).max(0.0)
            });
            let (sum, best) = shares.fold((0.0f64, 0.0f64), |(sum, best), of| (sum + of, best.max(of)));
            // Three terms of rounding beside 1.
            assert!(sum > 1.0 - 1e-9 && best > 1.0 / 3.0 - 1e-9, "{towards} {normal}: {sum} {best}");
        }
        assert_eq!(
            Directions::Axes.serving(DVec3::new(0.0, -2.0, 0.0)),
            [Serving { direction: 3, weight: 1.0 }]
        );
    }

    #[test]
    fn weights_change_continuously_and_the_nearest_direction_serves() {
        let mut rng = Rng::new(6);
        for _ in 0..4000 {
            let Some(at) = any_direction(&mut rng).try_normalize() else { continue };
            // Longitude has no limit at a pole, where every weight of its ring is 0.
            let moved = at + 1e-4 * any_direction(&mut rng);
            let (before, after) = (weights(at), weights(moved));
            let change = before.iter().zip(after).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // A step of 1e-4 sqrt(3) changes latitude by 2.2e-4 of a ring, and longitude by 2.5e-4 of a ring of 6 and 8 beyond
            // 45 degrees of latitude; nearer to a pole the ring's weight falls as its longitude turns faster.
            assert!(change < 1.2e-3, "{at}: {change}");
            let angle = |of: &usize| at.angle_between(towards_viewer(*of));
            let nearest = (0..DIRECTIONS).min_by(|a, b| angle(a).total_cmp(&angle(b))).unwrap();
            assert!(before[nearest] > 0.0, "{at}");
        }
    }
}
