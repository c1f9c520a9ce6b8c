//! Which way is up: from the cameras, and then from the walls.

use glam::DVec3;

use quadratura_align::linear::eigen;

use super::planes::PlaneSearch;
use super::points::NormalisedPoint;
use super::view::WorkingPhoto;

/// A plane within 7 degrees of plumb tells about up: the sine of that.
const NEARLY_PLUMB: f64 = 0.12;

/// Planes that are looked for.
const PLANES: usize = 6;

/// The largest turn of the cameras' up by planes that is believed: the cosine of 6 degrees.
const MOST_TURN: f64 = 0.9945;

/// The mean square of how far the x axes of cameras held by hand are off level: that of 4 degrees. Where they are rolled more, they
/// lie on both sides of level, and count less by as much.
const ROLLED_BY_HAND: f64 = 0.005;

/// Returns the unit direction upwards. Photos are taken level, so that the cameras' x axes lie across it; where all of them look
/// the same way, or are rolled, their y axes decide. Planes that are nearly plumb then refine it.
pub fn up(views: &[WorkingPhoto], points: &[NormalisedPoint]) -> DVec3 {
    let back = |view: &WorkingPhoto, axis: DVec3| view.pose.rotation.transpose() * axis;
    let mean_up = views.iter().map(|view| -back(view, DVec3::Y)).sum::<DVec3>().normalize_or(DVec3::Z);
    let mut of_cameras = Sum::default();
    views.iter().for_each(|view| of_cameras.add(back(view, DVec3::X), 1.0 / views.len() as f64));
    let doubt = (of_cameras.along(mean_up) / ROLLED_BY_HAND).max(1.0);
    let mut first = of_cameras.clone();
    first.add_across(mean_up, 0.02 * doubt);
    let from_cameras = first.least(mean_up);
    let mut up = from_cameras;
    for round in 0..2 {
        let mut all = Sum::default();
        let found = PlaneSearch::new(points, None, 11 + round).ending_at_chance().planes(PLANES);
        let total: usize = found.iter().map(|plane| plane.members.len()).sum();
        for plane in found.iter().filter(|plane| plane.plane.normal.dot(up).abs() < NEARLY_PLUMB) {
            all.add(plane.plane.normal, plane.members.len() as f64 / total as f64);
        }
        all.add_all(&of_cameras, 0.05 / doubt);
        all.add_across(up, 0.002);
        up = all.least(up);
    }
    if up.dot(from_cameras) < MOST_TURN { from_cameras } else { up }
}

/// A sum of squares of directions.
#[derive(Clone, Default)]
struct Sum([[f64; 3]; 3]);

impl Sum {
    fn add(&mut self, direction: DVec3, weight: f64) {
        let d = direction.to_array();
        for i in 0..3 {
            for j in 0..3 {
                self.0[i][j] += weight * d[i] * d[j];
            }
        }
    }

    /// Returns the sum of squares along a unit direction.
    fn along(&self, direction: DVec3) -> f64 {
        DVec3::from_array(self.0.map(|row| DVec3::from_array(row).dot(direction))).dot(direction)
    }

    /// Adds the squares of all directions across one.
    fn add_across(&mut self, direction: DVec3, weight: f64) {
        DVec3::AXES.into_iter().for_each(|axis| self.add(axis, weight));
        self.add(direction, -weight);
    }

    fn add_all(&mut self, other: &Self, weight: f64) {
        self.0.as_flattened_mut().iter_mut().zip(other.0.as_flattened()).for_each(|(a, b)| *a += weight * b);
    }

    /// Returns the direction with the smallest sum, on the side of another one.
    fn least(&self, side: DVec3) -> DVec3 {
        let least = DVec3::from_array(eigen(self.0)[0].1);
        if least.dot(side) < 0.0 { -least } else { least }
    }
}
