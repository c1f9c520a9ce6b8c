//! Cutting an outline by a plane, and bridging its holes.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::flat::PlanePoints;
use super::outline::outlines;
use super::plane_fit::{extent, fit_plane, resolution};
use super::triangulate::{triangulate, triangulate_rings};
use crate::geometry::Plane;

/// A corner closer to the cutting plane than this share of the outline's extent counts as on it, so that a cut
/// leaves no thinner slivers.
const ON_PLANE: f64 = 1e-9;

/// Cuts a ring by a plane and returns the rings on its positive side and those on its negative side. They are
/// weakly simple, with bridged holes, wound like the ring, concave where it is, and several where the cut separates
/// it. Points of the ring keep their exact coordinates; points within 1e-9 of the extent from the plane count as on
/// it. A ring that lies in the plane as a whole is on the positive side. A ring without area gives no rings.
pub fn split_by_plane(ring: &[DVec3], plane: &Plane) -> (Vec<Vec<DVec3>>, Vec<Vec<DVec3>>) {
    let Some(own_plane) = fit_plane(ring) else { return Default::default() };
    let triangulation = triangulate(ring, &own_plane);
    let mut cut = Cut::new(ring, &triangulation.crossings, plane);
    for triangle in &triangulation.triangles {
        cut.add(triangle);
    }
    (cut.rings(&cut.positive), cut.rings(&cut.negative))
}

/// Merges an outer outline and its holes into one ring, connected by doubled edges that cross nothing. The result
/// is wound like `outer`; the holes may have either winding. Where the holes leave several separate areas, there
/// are several rings. The result is empty when the outline has no area.
pub fn bridge_holes(outer: &[DVec3], holes: &[Vec<DVec3>]) -> Vec<Vec<DVec3>> {
    let mut points = outer.to_vec();
    let mut rings: Vec<_> = std::iter::once(0..outer.len()).collect();
    for hole in holes {
        rings.push(points.len()..points.len() + hole.len());
        points.extend_from_slice(hole);
    }
    let Some(flat) = fit_plane(outer).and_then(|plane| PlanePoints::new(&points, &plane)) else {
        return Vec::new();
    };
    let triangulation = triangulate_rings(&flat, &rings);
    points.extend_from_slice(&triangulation.crossings);
    let triangles: Vec<Vec<u32>> = triangulation.triangles.iter().map(|t| t.to_vec()).collect();
    let placed = |ring: Vec<u32>| ring.into_iter().map(|i| points[i as usize]).collect();
    outlines(&triangles, |a, b| distance(&points, a, b)).into_iter().map(placed).collect()
}

fn distance(points: &[DVec3], a: u32, b: u32) -> f64 {
    points[a as usize].distance(points[b as usize])
}

/// A cut in progress: the ring's triangles, cut one by one.
struct Cut {
    points: Vec<DVec3>,
    /// The signed distance of each point from the plane, exactly zero for points that count as on it.
    distances: Vec<f64>,
    /// The points where the plane crosses an edge, by the edge's ends (lower index first), so that both triangles
    /// at the edge share one point.
    met: FxHashMap<[u32; 2], u32>,
    /// Convex polygons on the positive side, as indices into `points`.
    positive: Vec<Vec<u32>>,
    /// Convex polygons on the negative side, as indices into `points`.
    negative: Vec<Vec<u32>>,
    /// The index of the first point that the cut made.
    first_made: u32,
    extent: f64,
}

impl Cut {
    fn new(ring: &[DVec3], crossings: &[DVec3], plane: &Plane) -> Self {
        let points = [ring, crossings].concat();
        let extent = extent(ring);
        let limit = (ON_PLANE * extent).max(resolution(ring));
        let snapped = |p: &DVec3| Some(plane.signed_distance(*p)).filter(|d| d.abs() > limit).unwrap_or(0.0);
        Self {
            distances: points.iter().map(snapped).collect(),
            points,
            met: FxHashMap::default(),
            positive: Vec::new(),
            negative: Vec::new(),
            first_made: (ring.len() + crossings.len()) as u32,
            extent,
        }
    }

    /// Cuts a triangle and files its parts by side.
    fn add(&mut self, triangle: &[u32; 3]) {
        let [mut front, mut back] = [Vec::with_capacity(4), Vec::with_capacity(4)];
        for (i, &a) in triangle.iter().enumerate() {
            let b = triangle[(i + 1) % 3];
            let (da, db) = (self.distances[a as usize], self.distances[b as usize]);
            if da >= 0.0 {
                front.push(a);
            }
            if da <= 0.0 {
                back.push(a);
            }
            if da * db < 0.0 {
                let middle = self.meeting_point([a.min(b), a.max(b)]);
                front.push(middle);
                back.push(middle);
            }
        }
        // A triangle that only touches the plane would leave a point or an edge on the other side; a triangle in
        // the plane belongs to the positive side.
        let off = |polygon: &[u32], d: &[f64]| polygon.iter().any(|&i| d[i as usize] != 0.0);
        let is_flat = !off(triangle, &self.distances);
        if is_flat || off(&front, &self.distances) {
            self.positive.push(front);
        }
        if !is_flat && off(&back, &self.distances) {
            self.negative.push(back);
        }
    }

    /// Returns the index of the point where the plane crosses an edge.
    fn meeting_point(&mut self, edge: [u32; 2]) -> u32 {
        if let Some(&known) = self.met.get(&edge) {
            return known;
        }
        let [a, b] = edge.map(|i| self.points[i as usize]);
        let [da, db] = edge.map(|i| self.distances[i as usize]);
        let index = self.points.len() as u32;
        self.points.push(a + (b - a) * (da / (da - db)));
        self.distances.push(0.0);
        self.met.insert(edge, index);
        index
    }

    /// Joins the convex polygons of one side to rings.
    fn rings(&self, polygons: &[Vec<u32>]) -> Vec<Vec<DVec3>> {
        // Bridges prefer points of the ring over points of the cut, which can be left out of the result.
        let detour = |i: u32| if i < self.first_made { 0.0 } else { self.extent };
        let cost = |a, b| distance(&self.points, a, b) + detour(a) + detour(b);
        let placed = |ring: Vec<u32>| self.without_seams(&ring).map(|i| self.points[i as usize]).collect();
        outlines(polygons, cost).into_iter().map(placed).collect()
    }

    /// Leaves out the points that the cut made on edges between two triangles, where the ring runs straight on
    /// along the plane.
    fn without_seams<'a>(&'a self, ring: &'a [u32]) -> impl Iterator<Item = u32> + 'a {
        let n = ring.len();
        let on_plane = |i: u32| self.distances[i as usize] == 0.0;
        let at = |i: u32| self.points[i as usize];
        let is_seam = move |k: usize| {
            let (before, here, after) = (ring[(k + n - 1) % n], ring[k], ring[(k + 1) % n]);
            here >= self.first_made
                && on_plane(before)
                && on_plane(after)
                && (at(before) - at(here)).dot(at(after) - at(here)) < 0.0
        };
        (0..n).filter(move |&k| !is_seam(k)).map(|k| ring[k])
    }
}
