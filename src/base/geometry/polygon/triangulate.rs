//! Triangulation of outlines: constrained Delaunay triangulation in their plane.

use std::ops::Range;

use glam::{DVec2, DVec3};
use spade::handles::{FixedFaceHandle, FixedVertexHandle, InnerTag, PossiblyOuterTag};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation as _};

use super::crossing::uncross;
use super::flat::{PlanePoints, signed_area};
use crate::geometry::Plane;

/// A defect of an outline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum OutlineFlaw {
    /// The outline has fewer than three different points.
    TooFewPoints,
    /// The points lie on a line, or the lobes cancel out; there are no triangles.
    NoArea,
    /// The outline crosses itself; its crossings became additional points.
    SelfCrossing,
    /// The outline crosses itself too often, or is too long, and was left without triangles.
    Tangled,
}

/// The result of [`triangulate`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Triangulation {
    /// Triangles as indices into the ring, wound like it; indices from the ring's length on refer to `crossings`.
    pub triangles: Vec<[u32; 3]>,
    /// The points where the outline crosses itself.
    pub crossings: Vec<DVec3>,
    /// The outline's defect, if any.
    pub flaw: Option<OutlineFlaw>,
}

impl Triangulation {
    /// Makes an empty triangulation with a defect.
    fn flawed(flaw: OutlineFlaw) -> Self {
        Self { flaw: Some(flaw), ..Self::default() }
    }
}

/// Triangulates a ring in `plane`, its own (see [`super::fit_plane`]). Holes are bridged. The inside is what an odd
/// number of outline edges separates from the outside, where a bridge counts twice. No points are added except
/// where the outline crosses itself. The function never fails; defects are in [`Triangulation::flaw`].
pub fn triangulate(ring: &[DVec3], plane: &Plane) -> Triangulation {
    if ring.len() < 3 {
        return Triangulation::flawed(OutlineFlaw::TooFewPoints);
    }
    let Some(flat) = PlanePoints::new(ring, plane) else {
        return Triangulation::flawed(OutlineFlaw::TooFewPoints);
    };
    if signed_area(flat.points.iter().copied()).abs() <= flat.resolution {
        return Triangulation::flawed(OutlineFlaw::NoArea);
    }
    if is_strictly_convex(&flat.points) {
        return Triangulation { triangles: fan(ring.len() as u32), ..Default::default() };
    }
    triangulate_rings(&flat, std::slice::from_ref(&(0..ring.len())))
}

/// The most points of an outline, more than any real face has. Points are inserted one by one, each located by
/// walking from the one before: a scribble of a million points would take minutes.
const MOST_POINTS: usize = 100_000;

/// Triangulates several rings at once (an outer outline and its holes), given as ranges of points; see
/// [`triangulate`].
pub(super) fn triangulate_rings(flat: &PlanePoints, rings: &[Range<usize>]) -> Triangulation {
    if flat.points.len() > MOST_POINTS {
        return Triangulation::flawed(OutlineFlaw::Tangled);
    }
    match without_crossings(&flat.points, rings.iter().flat_map(ring_edges)) {
        Some(triangles) => {
            let flaw = triangles.is_empty().then_some(OutlineFlaw::NoArea);
            Triangulation { triangles, crossings: Vec::new(), flaw }
        }
        None => with_crossings(flat, rings),
    }
}

/// Returns the edges of a ring as pairs of point indices.
pub(super) fn ring_edges(ring: &Range<usize>) -> impl Iterator<Item = [usize; 2]> + use<> {
    let (start, end) = (ring.start, ring.end);
    (start..end).map(move |i| [i, if i + 1 == end { start } else { i + 1 }])
}

/// Returns the triangles of a convex ring, all around its first point.
fn fan(corners: u32) -> Vec<[u32; 3]> {
    (1..corners - 1).map(|i| [0, i, i + 1]).collect()
}

/// Returns true when every corner clearly turns left and the ring goes round once. Most faces of most models are
/// such quads and need no triangulation.
fn is_strictly_convex(ring: &[DVec2]) -> bool {
    let n = ring.len();
    let edge = |i: usize| ring[(i + 1) % n] - ring[i % n];
    // Straighter corners take the general path, which handles points on a line.
    let turns_left =
        |a: DVec2, b: DVec2| a.perp_dot(b) > 1e-9 * (a.length_squared() * b.length_squared()).sqrt();
    let rises = |e: DVec2| e.y > 0.0 || (e.y == 0.0 && e.x > 0.0);
    let all_left = (0..n).all(|i| turns_left(edge(i), edge(i + 1)));
    // A ring that goes round once rises and falls once; a five-pointed star does so twice.
    all_left && (0..n).filter(|&i| rises(edge(i)) != rises(edge(i + 1))).count() == 2
}

/// The number of times that the outline runs along an edge of the triangulation.
#[derive(Debug, Clone, Copy, Default)]
struct Uses(u32);

type Cdt = ConstrainedDelaunayTriangulation<Point2<f64>, (), Uses>;

/// A triangulation with the vertex of each point, and the first point of each vertex.
struct Sites {
    cdt: Cdt,
    vertex_of_point: Vec<FixedVertexHandle>,
    point_of_vertex: Vec<u32>,
}

impl Sites {
    /// Inserts all points; `None` when a coordinate is NaN.
    fn insert(points: &[DVec2]) -> Option<Self> {
        let mut sites = Self { cdt: Cdt::new(), vertex_of_point: Vec::new(), point_of_vertex: Vec::new() };
        for (i, &point) in points.iter().enumerate() {
            let vertex = sites.cdt.insert(spade_point(point)).ok()?;
            if vertex.index() == sites.point_of_vertex.len() {
                sites.point_of_vertex.push(i as u32);
            }
            sites.vertex_of_point.push(vertex);
        }
        Some(sites)
    }

    fn vertices(&self, edge: [usize; 2]) -> [FixedVertexHandle; 2] {
        edge.map(|i| self.vertex_of_point[i])
    }
}

/// Converts a point for spade, which rejects nonzero coordinates below 1e-43; at unit extent these are zero.
fn spade_point(point: DVec2) -> Point2<f64> {
    let flushed = |x: f64| if x.abs() < 1e-40 { 0.0 } else { x };
    Point2::new(flushed(point.x), flushed(point.y))
}

/// Returns the triangles inside the outline; `None` when it crosses itself.
fn without_crossings(points: &[DVec2], edges: impl Iterator<Item = [usize; 2]>) -> Option<Vec<[u32; 3]>> {
    let mut sites = Sites::insert(points)?;
    for edge in edges {
        let [from, to] = sites.vertices(edge);
        if from == to {
            continue;
        }
        let pieces = sites.cdt.try_add_constraint(from, to);
        if pieces.is_empty() {
            return None;
        }
        for piece in pieces {
            sites.cdt.undirected_edge_data_mut(piece.as_undirected()).data_mut().0 += 1;
        }
    }
    Some(inside(&sites))
}

/// Returns the triangles inside, by flooding from outside and counting the outline edges that are crossed.
fn inside(sites: &Sites) -> Vec<[u32; 3]> {
    let cdt = &sites.cdt;
    let outer = cdt.outer_face().fix();
    let mut odd = vec![None; cdt.num_all_faces()];
    odd[outer.index()] = Some(false);
    // The outer face has no list of three edges, so the flood starts from the hull.
    let mut open: Vec<(FixedFaceHandle<PossiblyOuterTag>, bool)> = Vec::new();
    for edge in cdt.convex_hull() {
        let inner = if edge.face().is_outer() { edge.rev() } else { edge };
        open.push((inner.face().fix(), inner.as_undirected().data().data().0 % 2 == 1));
    }
    let mut triangles = Vec::new();
    while let Some((face, is_odd)) = open.pop() {
        if odd[face.index()].is_some() {
            continue;
        }
        odd[face.index()] = Some(is_odd);
        let Some(inner) = cdt.face(face).as_inner() else { continue };
        if is_odd {
            triangles.push((inner.fix(), inner.vertices().map(|v| sites.point_of_vertex[v.fix().index()])));
        }
        for edge in inner.adjacent_edges() {
            let crossed = edge.as_undirected().data().data().0 % 2 == 1;
            open.push((edge.rev().face().fix(), is_odd != crossed));
        }
    }
    triangles.sort_unstable_by_key(|(face, _): &(FixedFaceHandle<InnerTag>, _)| face.index());
    triangles.into_iter().map(|(_, corners)| corners).collect()
}

/// Triangulates an outline that crosses itself.
fn with_crossings(flat: &PlanePoints, rings: &[Range<usize>]) -> Triangulation {
    let Some(uncrossed) = uncross(flat, rings) else { return Triangulation::flawed(OutlineFlaw::Tangled) };
    let simple = without_crossings(&uncrossed.points, uncrossed.edges.iter().copied());
    let mut crossings = Vec::new();
    let mut index_of = Vec::new();
    for (&point, known) in uncrossed.points.iter().zip(&uncrossed.outline_point) {
        let next = (flat.points.len() + crossings.len()) as u32;
        crossings.extend(known.is_none().then(|| flat.raised(point)));
        index_of.push(known.unwrap_or(next));
    }
    let named = simple.unwrap_or_default().into_iter().map(|corners| corners.map(|i| index_of[i as usize]));
    let triangles: Vec<_> = named.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    let crossed = (!crossings.is_empty()).then_some(OutlineFlaw::SelfCrossing);
    let flaw = if triangles.is_empty() { Some(OutlineFlaw::NoArea) } else { crossed };
    Triangulation { triangles, crossings, flaw }
}
