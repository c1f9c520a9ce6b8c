//! The sparse points as cameras see them: each with its nearest observer, the planes that many of them lie on, and
//! samples in which small planes count as well. Coordinates are about the points' middle, in units of their median distance
//! from their observers.

use glam::DVec3;

use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::raster::robust::upper_median;
use quadratura_base::scene::SparsePoint;
use quadratura_base::scene::synthetic::Rng;

use super::linear::eigen;
use super::planes::{PointPlane, planes};

/// A point and the camera nearest to it of those that see it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObservedPoint {
    /// The camera's centre.
    pub eye: DVec3,
    /// The point.
    pub point: DVec3,
    /// The distance between the two.
    pub depth: f64,
    /// The plane of [`Points::planes`] that it lies on.
    pub plane: Option<u32>,
}

/// The sparse points in normalised coordinates: `world = origin + unit * normalised`.
pub struct Points {
    /// The points' middle, in the cameras' world.
    pub origin: DVec3,
    /// The median distance of a point from its observer, in units of the cameras' world.
    pub unit: f64,
    /// The points.
    pub sights: Vec<ObservedPoint>,
    /// The planes, that with most points first.
    pub planes: Vec<PointPlane>,
    /// The direction across which the cameras' rows lie: up or down.
    pub vertical: Option<DVec3>,
}

/// The most points that are looked at: of more, every n-th.
const MOST: usize = 30_000;

/// The least number of points in which a plane can be told from chance.
pub const FEWEST: usize = 30;

impl Points {
    /// Gives each point its nearest observer; of a point without observations, the nearest camera that has it in its
    /// picture. `None` for fewer than [`FEWEST`] points.
    pub fn new(cameras: &[(Pinhole, Pose)], points: &[SparsePoint]) -> Option<Self> {
        let eyes: Vec<DVec3> = cameras.iter().map(|(_, pose)| pose.center_in_world()).collect();
        let step = points.len().div_ceil(MOST).max(1);
        let seen: Vec<(DVec3, DVec3)> = points
            .iter()
            .step_by(step)
            .filter(|point| point.position.is_finite())
            .filter_map(|point| Some((nearest_observer(cameras, &eyes, point)?, point.position)))
            .filter(|(eye, point)| eye.distance(*point) > 0.0)
            .collect();
        if seen.len() < FEWEST {
            return None;
        }
        let unit =
            upper_median(&mut seen.iter().map(|(eye, point)| eye.distance(*point)).collect::<Vec<_>>())?;
        let median = |axis: usize| upper_median(&mut seen.iter().map(|(_, p)| p[axis]).collect::<Vec<_>>());
        let origin = DVec3::new(median(0)?, median(1)?, median(2)?);
        let sights = seen
            .iter()
            .map(|(eye, point)| {
                let (eye, point) = ((eye - origin) / unit, (point - origin) / unit);
                ObservedPoint { eye, point, depth: eye.distance(point), plane: None }
            })
            .collect();
        let vertical = vertical(cameras.iter().map(|(_, pose)| pose));
        let mut points = Self { origin, unit, sights, planes: Vec::new(), vertical };
        points.planes = planes(&mut points.sights);
        Some(points)
    }

    /// Draws points so that a plane counts by the root of its number of points, and all points on no plane together half
    /// as much; the same ones for the same seed.
    pub fn sample(&self, count: usize, seed: u64) -> Vec<u32> {
        let mut groups: Vec<Vec<u32>> = vec![Vec::new(); self.planes.len() + 1];
        for (i, sight) in (0..).zip(&self.sights) {
            groups[sight.plane.map_or(self.planes.len(), |plane| plane as usize)].push(i);
        }
        let weight = |group: usize, size: usize| {
            (size as f64).sqrt() * if group == self.planes.len() { 0.5 } else { 1.0 }
        };
        let total: f64 = groups.iter().enumerate().map(|(i, group)| weight(i, group.len())).sum();
        let mut rng = Rng::new(seed);
        let mut drawn = Vec::with_capacity(count + groups.len());
        // What a group owes beyond whole points is carried to the next one.
        let mut owed = 0.0;
        for (i, mut group) in groups.into_iter().enumerate() {
            if group.is_empty() {
                continue;
            }
            owed += count as f64 * weight(i, group.len()) / total;
            let whole = owed.round() as usize;
            owed -= whole as f64;
            for k in (1..group.len()).rev() {
                group.swap(k, rng.whole(0, k as u32) as usize);
            }
            drawn.extend(group.iter().cycle().take(whole));
        }
        drawn
    }
}

/// Returns the centre of the camera from which a point is seen nearest.
fn nearest_observer(cameras: &[(Pinhole, Pose)], eyes: &[DVec3], point: &SparsePoint) -> Option<DVec3> {
    let near = |eyes: &mut dyn Iterator<Item = DVec3>| {
        eyes.min_by(|a, b| a.distance_squared(point.position).total_cmp(&b.distance_squared(point.position)))
    };
    if point.observations.is_empty() {
        let shown = |(camera, pose): &(Pinhole, Pose)| {
            let px = camera.image_from_camera(pose.camera_from_world(point.position));
            px.is_some_and(|px| {
                px.x >= 0.0
                    && px.y >= 0.0
                    && px.x <= f64::from(camera.width)
                    && px.y <= f64::from(camera.height)
            })
        };
        return near(&mut cameras.iter().zip(eyes).filter(|(camera, _)| shown(camera)).map(|(_, eye)| *eye));
    }
    near(&mut point.observations.iter().filter_map(|(photo, _)| eyes.get(*photo as usize).copied()))
}

/// Returns the direction that the cameras' x axes avoid: most photos are taken level.
fn vertical<'a>(poses: impl Iterator<Item = &'a Pose>) -> Option<DVec3> {
    let mut sums = [[0.0; 3]; 3];
    let mut up = DVec3::ZERO;
    for pose in poses {
        let back = pose.rotation.transpose();
        let right = (back * DVec3::X).to_array();
        up -= back * DVec3::Y;
        for i in 0..3 {
            for j in 0..3 {
                sums[i][j] += right[i] * right[j];
            }
        }
    }
    let [least, second, _] = eigen(sums);
    // Where all cameras look the same way, two directions are avoided alike.
    let clear = second.0 > 0.02 * (sums[0][0] + sums[1][1] + sums[2][2]);
    if clear { Some(DVec3::from_array(least.1)) } else { up.try_normalize() }
}
