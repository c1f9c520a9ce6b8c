//! Self-intersecting outlines, split at their crossings.
//!
//! Constraints that split each other inside a floating-point triangulation were tried first: about one scribble in
//! ten thousand came out wrong or panicked, because a rounded crossing lies beside both edges. Here the outline is
//! snapped to an integer grid, on which the resulting contours do not cross at all.

use std::ops::Range;

use glam::DVec2;
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::{IntOverlayOptions, Overlay, ShapeType};
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::core::solver::Solver;
use i_overlay::i_float::int::point::IntPoint;
use rustc_hash::FxHashMap;

use super::flat::PlanePoints;
use super::triangulate::ring_edges;

/// Grid steps per unit of extent: 2 nm on a 4 m wall. Sums of two grid coordinates fit into 31 bits.
const GRID: f64 = (1 << 28) as f64;

/// The most edges of a self-intersecting outline that is split: the search for crossings takes quadratic time.
const LONGEST: usize = 5000;

/// The most crossings per edge of an outline; an outline with more is a tangle that cannot be intended.
const CROSSINGS_PER_POINT: usize = 8;

/// The even-odd inside of an outline, bounded by edges that do not cross.
#[derive(Default)]
pub(super) struct Uncrossed {
    /// Distinct points in the units of [`PlanePoints`], exactly on the grid.
    pub points: Vec<DVec2>,
    /// For each point, the index of the outline's first point there; `None` for a crossing.
    pub outline_point: Vec<Option<u32>>,
    /// Edges as pairs of indices into `points`.
    pub edges: Vec<[usize; 2]>,
}

/// Splits the rings' edges at their crossings; `None` when the outline is too long or crosses itself too often.
pub(super) fn uncross(flat: &PlanePoints, rings: &[Range<usize>]) -> Option<Uncrossed> {
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
    /// Appends a grid point and returns its index.
    fn add(&mut self, point: IntPoint, grid: &[IntPoint]) -> usize {
        self.points.push(DVec2::new(point.x.into(), point.y.into()) / GRID);
        let same = grid.iter().position(|&p| p == point);
        self.outline_point.push(same.or_else(|| touched(grid, point)).map(|i| i as u32));
        self.points.len() - 1
    }
}

/// Rounds a flat point to the grid.
fn on_grid(point: DVec2) -> IntPoint {
    IntPoint::new((point.x * GRID).round() as i32, (point.y * GRID).round() as i32)
}

/// Returns the outline's corner within two grid steps of a crossing: a corner that touches an edge lies beside it
/// after rounding, so the crossing next to it is that corner.
fn touched(grid: &[IntPoint], crossing: IntPoint) -> Option<usize> {
    let beside = |p: &IntPoint| (p.x - crossing.x).abs() <= 2 && (p.y - crossing.y).abs() <= 2;
    grid.iter().position(beside)
}

/// Returns the contours of the rings' even-odd inside, which neither cross nor touch along edges.
fn simple_contours(grid: &[IntPoint], rings: &[Range<usize>]) -> impl Iterator<Item = Vec<IntPoint>> {
    let mut overlay =
        Overlay::new_custom(grid.len(), IntOverlayOptions::keep_all_points(), Solver::default());
    for ring in rings {
        overlay.add_contour(&grid[ring.clone()], ShapeType::Subject);
    }
    overlay.overlay(OverlayRule::Subject, FillRule::EvenOdd).into_iter().flatten()
}

/// Returns true when the rings have more than [`LONGEST`] edges or too many crossings.
fn is_tangled(flat: &PlanePoints, rings: &[Range<usize>]) -> bool {
    let points = &flat.points;
    let edges: Vec<[DVec2; 2]> = rings.iter().flat_map(ring_edges).map(|e| e.map(|i| points[i])).collect();
    if edges.len() > LONGEST {
        return true;
    }
    let most = CROSSINGS_PER_POINT * edges.len();
    let pairs = (1..edges.len()).flat_map(|i| (0..i).map(move |k| (i, k)));
    pairs.filter(|&(i, k)| cross(edges[i], edges[k])).nth(most).is_some()
}

/// Returns true when two segments cross properly; touching does not count.
fn cross([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> bool {
    let side = |a: DVec2, b: DVec2, p: DVec2| (b - a).perp_dot(p - a);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}
