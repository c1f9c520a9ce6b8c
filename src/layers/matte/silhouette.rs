//! Where on an impostor's rectangle the object is: the silhouettes that photos show, side by side, and what the others
//! tell about one of them.

use glam::{DVec2, DVec3};

use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::raster::bilinear::Clamped;
use quadratura_base::raster::box_filter::{box_range, box_sums};
use quadratura_base::scene::impostor::{Facing, Impostor};

/// The cells across a rectangle and along it.
const CELLS: [usize; 2] = [48, 64];

/// What nobody saw counts as much as a photo of this weight that says half and half.
const RESERVE: f32 = 0.3;

/// Silhouettes are compared within as many cells: twigs of two directions do not meet, crowns do.
const BLUR: usize = 2;

/// An object stands on the foot of its impostor's axis: the logarithm of the odds there, which fall to even odds at the
/// top, and the distance from the axis, as a share of the half width, at which they fall to e^-1/2 of that.
const ON_AXIS: f32 = 2.0;
const NEAR_AXIS: f32 = 0.12;

/// The least weight of a photo's silhouette, however it is seen: crowns are round.
const LEAST_WEIGHT: f64 = 0.25;

/// An impostor as a photo sees it.
#[derive(Debug, Clone, Copy)]
pub struct SeenImpostor {
    impostor: Impostor,
    facing: Facing,
    camera: Pinhole,
    pose: Pose,
}

impl SeenImpostor {
    /// Returns the impostor as a camera sees it.
    pub fn new(impostor: &Impostor, camera: &Pinhole, pose: &Pose) -> Self {
        Self { impostor: *impostor, facing: Facing::of_pose(pose), camera: *camera, pose: *pose }
    }

    /// Returns where a pixel meets the rectangle: the position on it, 0 to 1 from the left and from the foot, and the depth
    /// in world units; `None` beside it.
    pub fn met(&self, (x, y): (i32, i32)) -> Option<(DVec2, f64)> {
        let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let direction = self.pose.rotation.transpose() * self.camera.ray_in_camera(px);
        let depth = self.impostor.met(&self.facing, direction)?;
        let place = self.impostor.place(&self.facing, self.facing.eye + direction * depth);
        let across = 0.5 + 0.5 * place.x / self.impostor.half_width;
        Some((DVec2::new(across, place.y / self.impostor.height), depth))
    }

    /// Returns the unit direction from the axis to the camera, level.
    fn towards(&self) -> DVec3 {
        self.impostor.plane(&self.facing).normal
    }
}

/// How likely a photo shows the object, by cell of its rectangle.
#[derive(Debug, Clone)]
pub struct Silhouette {
    towards: DVec3,
    /// The sum over pixels, and their number.
    cells: Vec<(f32, f32)>,
}

impl Silhouette {
    /// Makes the silhouette of an impostor that a photo sees like this, without any pixels.
    pub fn new(seen: &SeenImpostor) -> Self {
        Self { towards: seen.towards(), cells: vec![(0.0, 0.0); CELLS[0] * CELLS[1]] }
    }

    /// Adds a pixel: its position on the rectangle, and how likely it shows the object, 0 to 1.
    pub fn add(&mut self, place: DVec2, likely: f32) {
        let cell = &mut self.cells[cell(place)];
        *cell = (cell.0 + likely, cell.1 + 1.0);
    }

    /// Returns what others tell of the same object: the logarithm of the odds that the object is there, by cell.
    pub fn expected_from<'a>(&self, others: impl Iterator<Item = &'a Silhouette>) -> Expected {
        let mut sums = vec![(0.0f32, 0.0f32); self.cells.len()];
        for other in others {
            let cosine = self.towards.dot(other.towards);
            let weights = [cosine, -cosine].map(|cosine| cosine.max(LEAST_WEIGHT) as f32);
            for (index, sum) in sums.iter_mut().enumerate() {
                let (row, column) = (index / CELLS[0], index % CELLS[0]);
                // From behind, silhouettes are mirrored.
                let places = [index, row * CELLS[0] + CELLS[0] - 1 - column];
                for (place, weight) in places.into_iter().zip(weights) {
                    let (likely, count) = other.cells[place];
                    if count > 0.0 {
                        *sum = (sum.0 + weight * likely / count, sum.1 + weight);
                    }
                }
            }
        }
        let odds = |(index, (likely, weight)): (usize, (f32, f32))| {
            let column = (index % CELLS[0]) as f32 + 0.5;
            let from_axis = (2.0 * column / CELLS[0] as f32 - 1.0) / NEAR_AXIS;
            let below_top = 1.0 - (index / CELLS[0]) as f32 / CELLS[1] as f32;
            let odds_of_seen = ((likely + RESERVE) / (weight - likely + RESERVE)).ln();
            odds_of_seen + ON_AXIS * below_top * (-0.5 * from_axis * from_axis).exp()
        };
        Expected { log_odds: blurred(&sums).into_iter().enumerate().map(odds).collect() }
    }
}

/// Returns the means of the cells around each one.
fn blurred(cells: &[(f32, f32)]) -> Vec<(f32, f32)> {
    let mean = |(index, (likely, weight)): (usize, (f32, f32))| {
        let around = [index % CELLS[0], index / CELLS[0]];
        let [columns, rows] = [0, 1].map(|axis| box_range(around[axis], CELLS[axis], BLUR).len());
        let count = (columns * rows) as f32;
        (likely / count, weight / count)
    };
    box_sums(cells, CELLS, BLUR).into_iter().enumerate().map(mean).collect()
}

/// What photos tell of where an object is on its rectangle.
#[derive(Debug, Clone)]
pub struct Expected {
    log_odds: Vec<f32>,
}

impl Expected {
    /// Returns the logarithm of the odds that the object is at a position on the rectangle.
    pub fn at(&self, place: DVec2) -> f32 {
        let between = Clamped::new(place * DVec2::new(CELLS[0] as f64, CELLS[1] as f64), CELLS);
        between.mix(|x, y| self.log_odds[y * CELLS[0] + x])
    }
}

fn cell(place: DVec2) -> usize {
    let along = |at: f64, cells: usize| ((at * cells as f64) as usize).min(cells - 1);
    along(place.y, CELLS[1]) * CELLS[0] + along(place.x, CELLS[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DVec3};

    fn seen_from(eye: DVec3) -> SeenImpostor {
        let impostor = Impostor { foot: DVec3::ZERO, axis: DVec3::Z, height: 4.0, half_width: 2.0 };
        let forward = (DVec3::new(0.0, 0.0, eye.z) - eye).normalize();
        let down = DVec3::NEG_Z;
        let rotation = DMat3::from_cols(down.cross(forward), down, forward).transpose();
        let camera = Pinhole { width: 100, height: 100, fx: 100.0, fy: 100.0, cx: 50.0, cy: 50.0 };
        SeenImpostor::new(&impostor, &camera, &Pose { rotation, translation: rotation * -eye })
    }

    /// The silhouette of an object that fills the part of the rectangle to the right of the axis.
    fn right_half(seen: &SeenImpostor, right: bool) -> Silhouette {
        let mut silhouette = Silhouette::new(seen);
        for (x, y) in (0..100).flat_map(|y| (0..100).map(move |x| (x, y))) {
            if let Some((place, _)) = seen.met((x, y)) {
                silhouette.add(place, if (place.x > 0.5) == right { 1.0 } else { 0.0 });
            }
        }
        silhouette
    }

    #[test]
    fn a_photo_from_the_same_side_tells_where_the_object_is_and_one_from_behind_tells_it_mirrored() {
        let front = seen_from(DVec3::new(0.0, -6.0, 2.0));
        let (place, depth) = front.met((50, 50)).unwrap();
        // The middle of the pixel is half a pixel off, 0.03 world units.
        assert!(
            (place - DVec2::new(0.5, 0.5)).length() < 0.02 && (depth - 6.0).abs() < 1e-6,
            "{place} {depth}"
        );
        assert_eq!(front.met((2, 50)), None);
        let own = Silhouette::new(&front);
        let beside = right_half(&seen_from(DVec3::new(1.0, -6.0, 2.0)), true);
        let behind = right_half(&seen_from(DVec3::new(0.0, 6.0, 2.0)), false);
        for others in [vec![&beside], vec![&behind], vec![&beside, &behind]] {
            let expected = own.expected_from(others.into_iter());
            let (right, left) = (expected.at(DVec2::new(0.8, 0.5)), expected.at(DVec2::new(0.2, 0.5)));
            assert!(right > 0.3 && left < -0.3, "{right} {left}");
        }
        let nothing = own.expected_from([].into_iter());
        assert!(nothing.at(DVec2::new(0.9, 0.5)).abs() < 0.01, "beside the axis nobody knows");
        assert!(nothing.at(DVec2::new(0.5, 0.1)) > 1.5, "the object stands on its foot");
    }
}
