//! See-through surfaces, piece by piece: of an impostor the rectangle that faces a photo, of other objects each planar
//! face. Where on a piece the object is, photos tell each other: of an impostor by silhouettes ([`super::silhouette`]),
//! of a face point by point, because all photos see the same points of it.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::silhouette::{Expected, SeenImpostor, Silhouette};
use quadratura_base::geometry::{Pinhole, Plane, Pose};
use quadratura_base::raster::bilinear::Clamped;
use quadratura_base::raster::box_filter::box_sums;

/// The least and the largest number of cells along the longer side of a face.
const CELLS: [f64; 2] = [16.0, 768.0];

/// What no photo saw counts as much as a photo that says half and half with this weight: as in silhouettes.
const RESERVE: f32 = 0.3;

/// Cells are compared with their neighbours: models are off by a pixel or two.
const BLUR: usize = 1;

/// A planar face that one sees through in places, with a grid of cells over it.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceGrid {
    plane: Plane,
    across: DVec3,
    along: DVec3,
    /// The lowest corner in `across` and `along`, and the extent, in world units.
    low: DVec2,
    size: DVec2,
    /// The outline in the same units, from `low`.
    outline: Vec<DVec2>,
    cells: [usize; 2],
}

impl FaceGrid {
    /// Lays a grid over a planar outline. `longer_px` is the length of its longer side in photos, in pixels: there are as many
    /// cells.
    pub fn new(plane: &Plane, outline: &[DVec3], longer_px: f64) -> Self {
        let across = plane.normal.any_orthonormal_vector();
        let along = plane.normal.cross(across);
        let flat = |point: &DVec3| {
            let from = *point - plane.point;
            DVec2::new(from.dot(across), from.dot(along))
        };
        let corners: Vec<DVec2> = outline.iter().map(flat).collect();
        let low = corners.iter().copied().reduce(DVec2::min).unwrap_or_default();
        let high = corners.iter().copied().reduce(DVec2::max).unwrap_or_default();
        let size = (high - low).max(DVec2::splat(f64::MIN_POSITIVE));
        let longer = longer_px.clamp(CELLS[0], CELLS[1]);
        let cells = (size / size.max_element() * longer).round().max(DVec2::ONE);
        let outline = corners.into_iter().map(|corner| corner - low).collect();
        let cells = [cells.x as usize, cells.y as usize];
        Self { plane: *plane, across, along, low, size, outline, cells }
    }

    /// Returns where a ray meets the face: the position on it, 0 to 1 along both directions, and the ray parameter.
    fn met(&self, eye: DVec3, direction: DVec3) -> Option<(DVec2, f64)> {
        let t = -self.plane.signed_distance(eye) / self.plane.normal.dot(direction);
        if !(t > 0.0 && t.is_finite()) {
            return None;
        }
        let from = eye + direction * t - self.plane.point;
        let at = DVec2::new(from.dot(self.across), from.dot(self.along)) - self.low;
        self.holds(at).then_some((at / self.size, t))
    }

    /// Returns whether the outline goes around a position an odd number of times. Bridges to holes count twice.
    fn holds(&self, at: DVec2) -> bool {
        let ends = self.outline.iter().zip(self.outline.iter().cycle().skip(1));
        let crosses = |(a, b): &(&DVec2, &DVec2)| {
            (a.y > at.y) != (b.y > at.y) && at.x < a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x)
        };
        ends.filter(crosses).count() % 2 == 1
    }

    fn cell(&self, place: DVec2) -> usize {
        let along = |at: f64, cells: usize| ((at * cells as f64) as usize).min(cells - 1);
        along(place.y, self.cells[1]) * self.cells[0] + along(place.x, self.cells[0])
    }
}

/// A piece of a see-through surface as a photo sees it.
#[derive(Debug, Clone)]
pub enum SeenPiece {
    /// The rectangle of an impostor.
    Turning(SeenImpostor),
    /// A planar face.
    Face {
        /// The face.
        grid: Arc<FaceGrid>,
        /// The photo's camera.
        camera: Pinhole,
        /// The photo's pose.
        pose: Pose,
    },
}

impl SeenPiece {
    /// Returns where a pixel meets the piece: the position on it, 0 to 1 along both directions, and the depth in world
    /// units; `None` beside it.
    pub fn met(&self, (x, y): (i32, i32)) -> Option<(DVec2, f64)> {
        match self {
            Self::Turning(seen) => seen.met((x, y)),
            Self::Face { grid, camera, pose } => {
                let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let direction = pose.rotation.transpose() * camera.ray_in_camera(px);
                grid.met(pose.center_in_world(), direction)
            }
        }
    }
}

/// How likely a photo shows the object, by place on a piece.
#[derive(Debug, Clone)]
pub enum PieceSilhouette {
    /// Of an impostor.
    Turning(Silhouette),
    /// Of a face: per cell the sum over pixels, and their number.
    Face(Arc<FaceGrid>, Vec<(f32, f32)>),
}

impl PieceSilhouette {
    /// Makes the silhouette of a piece without any pixels.
    pub fn new(seen: &SeenPiece) -> Self {
        match seen {
            SeenPiece::Turning(seen) => Self::Turning(Silhouette::new(seen)),
            SeenPiece::Face { grid, .. } => {
                Self::Face(grid.clone(), vec![(0.0, 0.0); grid.cells[0] * grid.cells[1]])
            }
        }
    }

    /// Adds a pixel: its position on the piece, and how likely it shows the object, 0 to 1.
    pub fn add(&mut self, place: DVec2, likely: f32) {
        match self {
            Self::Turning(silhouette) => silhouette.add(place, likely),
            Self::Face(grid, cells) => {
                let cell = &mut cells[grid.cell(place)];
                *cell = (cell.0 + likely, cell.1 + 1.0);
            }
        }
    }

    /// Returns what other photos tell of the same piece.
    pub fn expected_from<'a>(&self, others: impl Iterator<Item = &'a PieceSilhouette>) -> ExpectedPiece {
        match self {
            Self::Turning(silhouette) => {
                let turning = |other: &'a PieceSilhouette| match other {
                    Self::Turning(silhouette) => Some(silhouette),
                    Self::Face(..) => None,
                };
                ExpectedPiece::Turning(silhouette.expected_from(others.filter_map(turning)))
            }
            Self::Face(grid, cells) => {
                let mut sums = vec![(0.0f32, 0.0f32); cells.len()];
                for other in others {
                    let Self::Face(_, of_other) = other else { continue };
                    let blurred = box_sums(of_other, grid.cells, BLUR);
                    for (sum, (likely, count)) in sums.iter_mut().zip(blurred) {
                        if count > 0.0 {
                            *sum = (sum.0 + likely / count, sum.1 + 1.0);
                        }
                    }
                }
                let odds =
                    |(likely, photos): (f32, f32)| ((likely + RESERVE) / (photos - likely + RESERVE)).ln();
                ExpectedPiece::Face(grid.clone(), sums.into_iter().map(odds).collect())
            }
        }
    }
}

/// What photos tell of where an object is on a piece.
#[derive(Debug, Clone)]
pub enum ExpectedPiece {
    /// On the rectangle of an impostor.
    Turning(Expected),
    /// On a face: the logarithm of the odds by cell.
    Face(Arc<FaceGrid>, Vec<f32>),
}

impl ExpectedPiece {
    /// Returns the logarithm of the odds that the object is at a position on the piece.
    pub fn at(&self, place: DVec2) -> f32 {
        match self {
            Self::Turning(expected) => expected.at(place),
            Self::Face(grid, log_odds) => {
                let [width, height] = grid.cells;
                let between = Clamped::new(place * DVec2::new(width as f64, height as f64), grid.cells);
                between.mix(|x, y| log_odds[y * width + x])
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;

    /// A fence of 4 by 2 world units in the plane y = 0, 200 pixels from 10 units before it, seen from beside by `x`.
    fn seen_from(x: f64) -> SeenPiece {
        let outline = [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [0.0, 2.0]].map(|[x, z]| DVec3::new(x, 0.0, z));
        let plane = Plane { normal: DVec3::NEG_Y, point: DVec3::ZERO };
        let grid = Arc::new(FaceGrid::new(&plane, &outline, 200.0));
        let rotation = DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y).transpose();
        let pose = Pose { rotation, translation: rotation * -DVec3::new(x, -10.0, 1.0) };
        let camera = Pinhole { width: 400, height: 200, fx: 500.0, fy: 500.0, cx: 200.0, cy: 100.0 };
        SeenPiece::Face { grid, camera, pose }
    }

    /// The silhouette of palings of a quarter of a unit with as wide gaps between.
    fn palings(seen: &SeenPiece) -> PieceSilhouette {
        let mut silhouette = PieceSilhouette::new(seen);
        for (x, y) in (0..200).flat_map(|y| (0..400).map(move |x| (x, y))) {
            if let Some((place, _)) = seen.met((x, y)) {
                silhouette.add(place, if is_paling(seen, place) { 0.95 } else { 0.05 });
            }
        }
        silhouette
    }

    fn is_paling(seen: &SeenPiece, place: DVec2) -> bool {
        let SeenPiece::Face { grid, .. } = seen else { panic!("it is a face") };
        let at = grid.low + place * grid.size;
        let point = grid.plane.point + grid.across * at.x + grid.along * at.y;
        (point.x / 0.25).floor() as i64 % 2 == 0
    }

    #[test]
    fn a_ray_meets_a_face_within_its_outline_at_its_depth() {
        let seen = seen_from(2.0);
        let (_, depth) = seen.met((200, 100)).unwrap();
        assert!((depth - 10.0).abs() < 1e-9, "{depth}");
        // The fence is 200 by 100 pixels about the middle.
        let inside = [(101, 100), (298, 100), (200, 51), (200, 148)];
        let beside = [(98, 100), (301, 100), (200, 48), (200, 151)];
        assert!(inside.iter().all(|at| seen.met(*at).is_some()));
        assert!(beside.iter().all(|at| seen.met(*at).is_none()));
    }

    #[test]
    fn photos_tell_each_other_where_palings_are_point_by_point() {
        let here = seen_from(2.0);
        let others: Vec<PieceSilhouette> = [1.0, 3.5].map(|x| palings(&seen_from(x))).into();
        let expected = PieceSilhouette::new(&here).expected_from(others.iter());
        let (mut right, mut all) = (0, 0);
        for (x, y) in (60..140).flat_map(|y| (110..290).map(move |x| (x, y))) {
            let (place, _) = here.met((x, y)).unwrap();
            right += usize::from((expected.at(place) > 0.0) == is_paling(&here, place));
            all += 1;
        }
        // A paling is 12.5 pixels wide; at its edges cells hold both.
        assert!(right * 100 > all * 88, "{right} of {all}");
        let nothing = PieceSilhouette::new(&here).expected_from([].into_iter());
        assert_eq!(nothing.at(DVec2::splat(0.5)), 0.0);
    }
}
