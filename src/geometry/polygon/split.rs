//! Cutting an outline by a plane, and bridging holes.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::flat::Flat;
use super::outline::outlines;
use super::plane_fit::{extent, fit_plane, resolution};
use super::triangulate::{triangulate, triangulate_rings};
use crate::geometry::Plane;

/// A corner closer to the cutting plane than this share of the outline's extent lies on it: a cut
/// leaves no slivers thinner than that.
const ON_PLANE: f64 = 1e-9;

/// Cuts a ring by a plane. Gives the rings on the plane's positive side and those on its negative
/// side: weakly simple, holes bridged, wound like the ring, concave where it is, several where the
/// cut separates it. Points of the ring keep their exact coordinates; a
/// point within 1e-9 of the extent of the plane counts as on it. A ring that lies in the plane as
/// a whole is on its positive side. A ring without area gives nothing.
pub fn split_by_plane(ring: &[DVec3], plane: &Plane) -> (Vec<Vec<DVec3>>, Vec<Vec<DVec3>>) {
    let Some(own_plane) = fit_plane(ring) else { return Default::default() };
    let triangulation = triangulate(ring, &own_plane);
    let mut cut = Cut::new(ring, &triangulation.crossings, plane);
    for triangle in &triangulation.triangles {
        cut.add(triangle);
    }
    (cut.rings(&cut.positive), cut.rings(&cut.negative))
}

/// One ring of an outer outline and its holes, each joined to the others by doubled edges that
/// cross nothing. The result runs around the outer outline like `outer` does; the holes may be
/// given either way round. Where the holes leave several separate areas, there are several rings.
/// Empty when the outline has no area.
pub fn bridge_holes(outer: &[DVec3], holes: &[Vec<DVec3>]) -> Vec<Vec<DVec3>> {
    let mut points = outer.to_vec();
    let mut rings: Vec<_> = std::iter::once(0..outer.len()).collect();
    for hole in holes {
        rings.push(points.len()..points.len() + hole.len());
        points.extend_from_slice(hole);
    }
    let Some(flat) = fit_plane(outer).and_then(|plane| Flat::new(&points, &plane)) else { return Vec::new() };
    let triangulation = triangulate_rings(&flat, &rings);
    points.extend_from_slice(&triangulation.crossings);
    let triangles: Vec<Vec<u32>> = triangulation.triangles.iter().map(|t| t.to_vec()).collect();
    let placed = |ring: Vec<u32>| ring.into_iter().map(|i| points[i as usize]).collect();
    outlines(&triangles, |a, b| distance(&points, a, b)).into_iter().map(placed).collect()
}

fn distance(points: &[DVec3], a: u32, b: u32) -> f64 {
    points[a as usize].distance(points[b as usize])
}

/// The triangles of a ring, cut one by one.
struct Cut {
    points: Vec<DVec3>,
    /// Signed distance of each point from the plane; exactly zero for those that lie on it.
    distances: Vec<f64>,
    /// Where the plane meets an edge, by the edge's ends (lower index first): both neighbours of
    /// the edge get the very same point.
    met: FxHashMap<[u32; 2], u32>,
    /// Convex polygons, as indices into `points`.
    positive: Vec<Vec<u32>>,
    negative: Vec<Vec<u32>>,
    /// From here on, points were made by the cut.
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
        // A triangle that only touches the plane leaves a point or an edge on the other side; one
        // that lies in it is on the positive side.
        let off = |polygon: &[u32], d: &[f64]| polygon.iter().any(|&i| d[i as usize] != 0.0);
        let is_flat = !off(triangle, &self.distances);
        if is_flat || off(&front, &self.distances) {
            self.positive.push(front);
        }
        if !is_flat && off(&back, &self.distances) {
            self.negative.push(back);
        }
    }

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

    fn rings(&self, polygons: &[Vec<u32>]) -> Vec<Vec<DVec3>> {
        // A bridge from a point of the ring needs no point of the cut, which could be left out.
        let detour = |i: u32| if i < self.first_made { 0.0 } else { self.extent };
        let cost = |a, b| distance(&self.points, a, b) + detour(a) + detour(b);
        let placed = |ring: Vec<u32>| self.without_seams(&ring).map(|i| self.points[i as usize]).collect();
        outlines(polygons, cost).into_iter().map(placed).collect()
    }

    /// Leaves out the points that the cut made on edges between two triangles: the ring passes
    /// them straight on, along the plane.
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
