//! A face that is suggested: a polygon on a plane, with the raster that it was outlined on.

use std::ops::Range;

use glam::{DVec2, DVec3};

use quadratura_base::geometry::Plane;

use super::chart::PlaneChart;
use super::planes::PlaneKind;
use super::support::middle;
use super::view::WorkingPhoto;

/// A suggested face in normalised coordinates.
#[derive(Debug, Clone)]
pub struct NormalisedFace {
    /// The index of its plane among the candidates.
    pub number: usize,
    /// How the plane lies.
    pub kind: PlaneKind,
    /// The plane; the normal is the front.
    pub plane: Plane,
    /// The corners, counter-clockwise seen from the front, with bridged holes.
    pub ring: Vec<DVec3>,
    /// The raster on the plane.
    pub chart: PlaneChart,
    /// The cells that the polygon covers.
    pub covers: Vec<bool>,
    /// The mean number of photos that show it.
    pub seen: f64,
    /// The mean number of photos that see through it.
    pub passed: f64,
}

impl NormalisedFace {
    /// Makes a face of a ring on a raster of its plane.
    pub fn new(number: usize, kind: PlaneKind, plane: Plane, ring: Vec<DVec3>, chart: &PlaneChart) -> Self {
        let covers = covered(&ring, chart);
        Self { number, kind, plane, ring, chart: chart.clone(), covers, seen: 0.0, passed: 0.0 }
    }

    /// Returns whether a point of the plane is on the face.
    #[inline]
    pub fn holds(&self, point: DVec3) -> bool {
        self.chart.index(point).is_some_and(|index| self.covers[index])
    }

    /// Returns the columns and rows of a photo within which the face may be.
    fn bounds(&self, view: &WorkingPhoto) -> (Range<usize>, Range<usize>) {
        let [w, h] = view.size();
        let corner = |point: &DVec3| view.camera().image_from_camera(view.pose.camera_from_world(*point));
        let Some(corners) = self.ring.iter().map(corner).collect::<Option<Vec<DVec2>>>() else {
            // It reaches behind the camera.
            return (0..w, 0..h);
        };
        let low = corners.iter().copied().fold(DVec2::INFINITY, DVec2::min).max(DVec2::ZERO);
        let high = corners.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max).ceil();
        let end = |high: f64, side: usize| (high.max(0.0) as usize).min(side);
        ((low.x as usize).min(w)..end(high.x, w), (low.y as usize).min(h)..end(high.y, h))
    }

    /// Calls `visit` with each pixel of a photo in which the face is, and its inverse depth there.
    pub fn pixels(&self, view: &WorkingPhoto, mut visit: impl FnMut(usize, f64)) {
        let w = view.size()[0];
        let (columns, rows) = self.bounds(view);
        let depth = view.inverse_depth(&self.plane);
        for (y, x) in rows.flat_map(|y| columns.clone().map(move |x| (y, x))) {
            let inverse = depth.at(x, y);
            if inverse > 1e-4 && self.holds(view.eye + view.ray(middle(x, y)) / inverse) {
                visit(y * w + x, inverse);
            }
        }
    }
}

/// Returns the cells of a raster whose middles a ring encloses, by the even-odd rule; bridges are walked twice and count nothing.
pub fn covered(ring: &[DVec3], chart: &PlaneChart) -> Vec<bool> {
    let [columns, rows] = chart.size;
    let mut covers = vec![false; chart.count()];
    let flat: Vec<DVec2> = ring.iter().map(|corner| chart.place(*corner)).collect();
    for row in 0..rows {
        let y = row as f64 + 0.5;
        let edges = flat.iter().zip(flat.iter().cycle().skip(1));
        let crossed = edges.filter(|(a, b)| (a.y <= y) != (b.y <= y));
        let mut at: Vec<f64> = crossed.map(|(a, b)| a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y)).collect();
        at.sort_by(f64::total_cmp);
        for pair in at.chunks_exact(2) {
            let cell = |x: f64| ((x - 0.5).ceil().max(0.0) as usize).min(columns);
            covers[row * columns..][cell(pair[0])..cell(pair[1])].fill(true);
        }
    }
    covers
}
