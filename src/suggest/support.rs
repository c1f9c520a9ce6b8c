//! What points say about the places of a plane: how far each is from points on it, and whether rays pass there.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use quadratura_base::raster::robust::upper_median;

use super::chart::PlaneChart;
use super::planes::{PlaneKind, PlaneOfPoints};
use super::points::NormalisedPoint;
use super::view::WorkingPhoto;

/// The distance from its points beyond which a plane is not believed, as a share of the points' distance from their observers.
pub const REACH: f64 = 0.6;

/// The same of the ground, on which few points lie and nothing else is below the cameras.
const REACH_OF_GROUND: f64 = 2.5;

/// The side of a cell, as a share of that distance.
const CELL: f64 = 0.02;

/// How much more a point on the plane counts than a ray that passes through.
const POINT_WEIGHT: f32 = 2.5;

/// What points say about the places of a plane.
#[derive(Debug, Clone)]
pub struct PlaneSupport {
    /// The median distance of the points from their observers.
    pub away: f64,
    reach: f32,
    chart: PlaneChart,
    /// For each cell the distance from the nearest point, as a share of `away`; upwards it counts half.
    distance: Vec<f32>,
    /// For each cell how surely rays pass through, 0 to 1.
    violation: Vec<f32>,
}

impl PlaneSupport {
    /// Collects what points say about a plane.
    pub fn new(plane: &PlaneOfPoints, points: &[NormalisedPoint], views: &[WorkingPhoto], up: DVec3) -> Self {
        let members = || plane.members.iter().map(|i| &points[*i as usize]);
        let away = upper_median(&mut members().map(|point| point.away).collect::<Vec<_>>());
        let seen_from =
            |place: &DVec3| views.iter().map(|view| view.eye.distance(*place)).fold(f64::INFINITY, f64::min);
        let away = away.or_else(|| upper_median(&mut plane.places.iter().map(seen_from).collect::<Vec<_>>()));
        let away = away.unwrap_or(1.0);
        let reach = if plane.kind == PlaneKind::Ground { REACH_OF_GROUND } else { REACH };
        let places = || members().map(|point| point.at).chain(plane.places.iter().copied());
        let chart = PlaneChart::around(&plane.plane, up, places(), reach * away, CELL * away);
        let distance = distances(&chart, places(), away);
        let violation = violations(plane, &chart, points, views);
        Self { away, reach: reach as f32, chart, distance, violation }
    }

    /// Returns distance and violation at a point of the plane; `None` where the plane is not believed.
    #[inline]
    pub fn at(&self, point: DVec3) -> Option<(f32, f32)> {
        let index = self.chart.index(point)?;
        let distance = self.distance[index];
        (distance <= self.reach).then(|| (distance, self.violation[index]))
    }
}

/// Sweeps the distance from points over the cells, until nothing changes.
fn distances(chart: &PlaneChart, points: impl Iterator<Item = DVec3>, away: f64) -> Vec<f32> {
    let [columns, rows] = chart.size;
    let mut distance = vec![f32::INFINITY; chart.count()];
    points.filter_map(|point| chart.index(point)).for_each(|index| distance[index] = 0.0);
    let step = (chart.cell / away) as f32;
    let rise = if chart.rises { 0.5 } else { 1.0 };
    let cost = |dx: isize, dy: isize| {
        let up = if dy > 0 { rise } else { 1.0 };
        step * (dx as f32).hypot(dy as f32 * up)
    };
    for _ in 0..2 {
        for (dys, order) in [([-1isize, 0], false), ([1, 0], true)] {
            for row in 0..rows {
                let y = if order { rows - 1 - row } else { row };
                for column in (0..columns).chain((0..columns).rev()) {
                    let own = y * columns + column;
                    for (dx, dy) in dys.iter().flat_map(|dy| [-1isize, 0, 1].map(|dx| (dx, *dy))) {
                        let (x, from) = (column.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
                        if x < columns && from < rows {
                            distance[own] = distance[own].min(distance[from * columns + x] + cost(-dx, -dy));
                        }
                    }
                }
            }
        }
    }
    distance
}

/// Returns where a ray passes through a plane from the front and ends well behind it.
pub fn passes(
    eye: DVec3,
    point: &NormalisedPoint,
    plane: &quadratura_base::geometry::Plane,
    margin: f64,
) -> Option<DVec3> {
    let (from, to) = (plane.signed_distance(eye), plane.signed_distance(point.at));
    if from <= 0.0 || to >= 0.0 {
        return None;
    }
    let t = from / (from - to);
    let behind = (1.0 - t) * eye.distance(point.at);
    (behind > (3.0 * point.sigma).max(margin * point.away)).then(|| eye.lerp(point.at, t))
}

/// Votes of rays against those of points.
fn violations(
    plane: &PlaneOfPoints,
    chart: &PlaneChart,
    points: &[NormalisedPoint],
    views: &[WorkingPhoto],
) -> Vec<f32> {
    let mut votes = vec![0.0f32; chart.count()];
    for point in plane.members.iter().map(|i| &points[*i as usize]) {
        if let Some(index) = chart.index(point.at) {
            votes[index] -= POINT_WEIGHT;
        }
    }
    for point in points.iter().filter(|point| point.is_tracked) {
        for observer in &point.observers {
            let at = passes(views[*observer as usize].eye, point, &plane.plane, 0.01);
            if let Some(index) = at.and_then(|at| chart.index(at)) {
                votes[index] += 1.0;
            }
        }
    }
    let clipped: Vec<f32> = votes.into_iter().map(|vote| vote.clamp(0.0, 1.0)).collect();
    blurred(&clipped, chart.size, 1.5)
}

/// Blurs by a Gaussian of a standard deviation in cells.
pub fn blurred(values: &[f32], [columns, rows]: [usize; 2], sigma: f32) -> Vec<f32> {
    let reach = (2.5 * sigma).ceil() as isize;
    let kernel: Vec<f32> = (-reach..=reach).map(|k| (-0.5 * (k as f32 / sigma).powi(2)).exp()).collect();
    let sum: f32 = kernel.iter().sum();
    let pass =
        |from: &[f32], stride: usize, count: usize, place: &(dyn Fn(usize) -> usize + Sync)| -> Vec<f32> {
            (0..from.len())
                .into_par_iter()
                .map(|at| {
                    let own = place(at);
                    let base = at - own * stride;
                    let tap = |(k, weight): (isize, &f32)| {
                        let other = own.saturating_add_signed(k).min(count - 1);
                        weight * from[base + other * stride]
                    };
                    (-reach..=reach).zip(&kernel).map(tap).sum::<f32>() / sum
                })
                .collect()
        };
    let across = pass(values, 1, columns, &|at| at % columns);
    pass(&across, columns, rows, &|at| at / columns)
}

/// Returns the middle of a pixel.
#[inline]
pub fn middle(x: usize, y: usize) -> DVec2 {
    DVec2::new(x as f64 + 0.5, y as f64 + 0.5)
}
