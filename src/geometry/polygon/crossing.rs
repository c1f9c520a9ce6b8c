//! Outlines that cross themselves, taken apart at their crossings.
//!
//! Constraints that split each other inside a floating-point triangulation were tried first: about
//! one scribble in ten thousand came out wrong or panicked, because a rounded crossing lies beside both
//! edges. Here the outline is put on a grid of whole numbers, where what comes out crosses nothing.

use std::ops::Range;

use glam::DVec2;
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::{IntOverlayOptions, Overlay, ShapeType};
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::core::solver::Solver;
use i_overlay::i_float::int::point::IntPoint;
use rustc_hash::FxHashMap;

use super::flat::Flat;
use super::triangulate::ring_edges;

/// Grid steps per unit of extent: 2 nm on a 4 m wall. The sums of the grid stay within 31 bits.
const GRID: f64 = (1 << 28) as f64;

/// Longer outlines that cross themselves are left alone: looking for crossings takes the square of
/// their length.
const LONGEST: usize = 5000;

/// An outline may cross itself this many times per point; more is a tangle that nobody drew.
const CROSSINGS_PER_POINT: usize = 8;

/// The even-odd inside of an outline, bounded by edges that cross nothing.
#[derive(Default)]
pub(super) struct Uncrossed {
    /// In the units of [`Flat`], exactly on the grid, all different.
    pub points: Vec<DVec2>,
    /// For each point, the first point of the outline there; `None` for a crossing.
    pub outline_point: Vec<Option<u32>>,
    /// Pairs of points.
    pub edges: Vec<[usize; 2]>,
}

/// `None` when the outline is too long or crosses itself too often.
pub(super) fn uncross(flat: &Flat, rings: &[Range<usize>]) -> Option<Uncrossed> {
    if is_tangled(flat, rings) {
        return None;
    }
    let grid: Vec<IntPoint> = flat.points.iter().map(|p| on_grid(*p)).collect();
    let mut result = Uncrossed::default();
    let mut index_of: FxHashMap<IntPoint, usize> = FxHashMap::default();
    for contour in simple_contours(&grid, rings) {
        let mut indices = Vec::with_capacity(contour.len());
        for point in contour {
            indices.push(*index_of.entry(point).or_insert_with(|| result.add(point, &grid)));
        }
        result.edges.extend(ring_edges(&(0..indices.len())).map(|edge| edge.map(|i| indices[i])));
    }
    Some(result)
}

impl Uncrossed {
    fn add(&mut self, point: IntPoint, grid: &[IntPoint]) -> usize {
        self.points.push(DVec2::new(point.x.into(), point.y.into()) / GRID);
        let same = grid.iter().position(|&p| p == point);
        self.outline_point.push(same.or_else(|| touched(grid, point)).map(|i| i as u32));
        self.points.len() - 1
    }
}

fn on_grid(point: DVec2) -> IntPoint {
    IntPoint::new((point.x * GRID).round() as i32, (point.y * GRID).round() as i32)
}

/// A corner that touches an edge lies beside it by rounding: the crossing next to it is the corner.
fn touched(grid: &[IntPoint], crossing: IntPoint) -> Option<usize> {
    let beside = |p: &IntPoint| (p.x - crossing.x).abs() <= 2 && (p.y - crossing.y).abs() <= 2;
    grid.iter().position(beside)
}

fn simple_contours(grid: &[IntPoint], rings: &[Range<usize>]) -> impl Iterator<Item = Vec<IntPoint>> {
    let mut overlay =
        Overlay::new_custom(grid.len(), IntOverlayOptions::keep_all_points(), Solver::default());
    for ring in rings {
        overlay.add_contour(&grid[ring.clone()], ShapeType::Subject);
    }
    overlay.overlay(OverlayRule::Subject, FillRule::EvenOdd).into_iter().flatten()
}

fn is_tangled(flat: &Flat, rings: &[Range<usize>]) -> bool {
    let points = &flat.points;
    let edges: Vec<[DVec2; 2]> = rings.iter().flat_map(ring_edges).map(|e| e.map(|i| points[i])).collect();
    if edges.len() > LONGEST {
        return true;
    }
    let most = CROSSINGS_PER_POINT * edges.len();
    let pairs = (1..edges.len()).flat_map(|i| (0..i).map(move |k| (i, k)));
    pairs.filter(|&(i, k)| cross(edges[i], edges[k])).nth(most).is_some()
}

fn cross([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> bool {
    let side = |a: DVec2, b: DVec2, p: DVec2| (b - a).perp_dot(p - a);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}
