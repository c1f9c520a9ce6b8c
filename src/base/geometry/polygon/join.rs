//! Joins triangles of a mesh back into the polygons that they were made from.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::outline::outlines;

/// Neighbours that bend less than this (tan 0.25 degrees) belong to one face. A round tower of 256 facets bends 1.4
/// degrees at each, so its facets stay separate faces.
const BEND: f64 = 0.004_36;

/// Joins triangles that share edges and lie in one plane into weakly simple rings with bridged holes; all others
/// are returned as they are. Results are in the order of their first triangles. `noise` is the rounding error of a
/// coordinate, in the positions' unit.
pub fn join_coplanar(triangles: &[[u32; 3]], positions: &[DVec3], noise: f64) -> Vec<Vec<u32>> {
    let soup = Soup::new(triangles, positions, noise);
    let mut seeds: Vec<u32> = (0..triangles.len() as u32).collect();
    // Large triangles give the most accurate plane.
    seeds.sort_by(|&a, &b| soup.double_area(b).total_cmp(&soup.double_area(a)).then(a.cmp(&b)));
    let mut taken = vec![false; triangles.len()];
    let mut faces: Vec<(u32, Vec<u32>)> = Vec::new();
    for seed in seeds {
        if !taken[seed as usize] {
            let region = soup.grown(seed, &mut taken);
            let first = region.iter().copied().min().unwrap_or(seed);
            faces.extend(soup.rings(&region).into_iter().map(|ring| (first, ring)));
        }
    }
    faces.sort_by_key(|&(first, _)| first);
    faces.into_iter().map(|(_, ring)| ring).collect()
}

/// Returns the outlines of triangles that are known to make one face, or the triangles themselves where these have
/// no outline.
pub fn join_all(triangles: &[[u32; 3]], positions: &[DVec3]) -> Vec<Vec<u32>> {
    if let [single] = triangles {
        return vec![single.to_vec()];
    }
    let polygons: Vec<Vec<u32>> = triangles.iter().map(|t| t.to_vec()).collect();
    let length = |a: u32, b: u32| positions[a as usize].distance(positions[b as usize]);
    let rings = outlines(&polygons, length);
    if rings.is_empty() { polygons } else { rings }
}

/// Triangles with their normals and an index of their directed edges.
struct Soup<'a> {
    triangles: &'a [[u32; 3]],
    positions: &'a [DVec3],
    noise: f64,
    /// Each triangle's normal, scaled to twice its area.
    normals: Vec<DVec3>,
    /// The only triangle with this directed edge, or [`SEVERAL`].
    by_edge: FxHashMap<[u32; 2], u32>,
}

/// Marks a directed edge that several triangles use.
const SEVERAL: u32 = u32::MAX;

impl<'a> Soup<'a> {
    fn new(triangles: &'a [[u32; 3]], positions: &'a [DVec3], noise: f64) -> Self {
        let mut by_edge = FxHashMap::default();
        by_edge.reserve(triangles.len() * 3);
        for (i, &[a, b, c]) in triangles.iter().enumerate() {
            for edge in [[a, b], [b, c], [c, a]] {
                by_edge.entry(edge).and_modify(|owner| *owner = SEVERAL).or_insert(i as u32);
            }
        }
        let normal = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| positions[i as usize]);
            (b - a).cross(c - a)
        };
        let normals = triangles.iter().map(normal).collect();
        Self { triangles, positions, noise, normals, by_edge }
    }

    fn double_area(&self, triangle: u32) -> f64 {
        self.normals[triangle as usize].length()
    }

    fn sole_owner(&self, edge: [u32; 2]) -> Option<u32> {
        self.by_edge.get(&edge).copied().filter(|&owner| owner != SEVERAL)
    }

    /// Grows a region of one plane from a seed triangle across shared edges, and marks its triangles as taken.
    fn grown(&self, seed: u32, taken: &mut [bool]) -> Vec<u32> {
        taken[seed as usize] = true;
        let mut region = vec![seed];
        let normal = self.normals[seed as usize].normalize_or_zero();
        let origin = self.positions[self.triangles[seed as usize][0] as usize];
        let mut next = 0;
        while next < region.len() {
            let [a, b, c] = self.triangles[region[next] as usize];
            next += 1;
            for edge in [[a, b], [b, c], [c, a]] {
                let own = self.sole_owner(edge);
                let neighbour = own.and_then(|_| self.sole_owner([edge[1], edge[0]]));
                let Some(neighbour) = neighbour.filter(|&t| !taken[t as usize]) else { continue };
                if self.continues(neighbour, edge, normal, origin) {
                    taken[neighbour as usize] = true;
                    region.push(neighbour);
                }
            }
        }
        region
    }

    /// Returns true when the triangle's corner opposite `edge` lies in the plane. The tolerance grows with the
    /// corner's distance from the edge, because slivers have no usable normal.
    fn continues(&self, triangle: u32, edge: [u32; 2], normal: DVec3, origin: DVec3) -> bool {
        let corners = self.triangles[triangle as usize];
        let Some(&apex) = corners.iter().find(|corner| !edge.contains(corner)) else { return false };
        let [a, b, apex] = [edge[0], edge[1], apex].map(|i| self.positions[i as usize]);
        let along = (b - a).normalize_or_zero();
        let beside = apex - a;
        let reach = (beside - along * beside.dot(along)).length();
        let off = normal.dot(apex - origin).abs();
        off <= BEND * reach + self.noise && self.normals[triangle as usize].dot(normal) >= 0.0
    }

    /// Returns the outlines of a region.
    fn rings(&self, region: &[u32]) -> Vec<Vec<u32>> {
        let mut region = region.to_vec();
        region.sort_unstable();
        let triangles: Vec<[u32; 3]> = region.iter().map(|&t| self.triangles[t as usize]).collect();
        join_all(&triangles, self.positions)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of squares, each cut into two triangles, bent by `bend_rad` between them.
    fn strip(squares: u32, bend_rad: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let (mut at, mut heading) = (DVec3::ZERO, 0.0f64);
        let mut positions = vec![at, at + DVec3::Y];
        let mut triangles = Vec::new();
        for i in 0..squares {
            at += DVec3::new(heading.cos(), 0.0, heading.sin());
            heading += bend_rad;
            positions.extend([at, at + DVec3::Y]);
            let [a, d, b, c] = [2 * i, 2 * i + 1, 2 * i + 2, 2 * i + 3];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        (positions, triangles)
    }

    #[test]
    fn a_flat_strip_is_one_face_and_keeps_its_corners() {
        let (positions, triangles) = strip(5, 0.0);
        let faces = join_coplanar(&triangles, &positions, 1e-7);
        assert_eq!(faces.len(), 1);
        assert_eq!(faces[0].len(), 12);
    }

    #[test]
    fn facets_of_a_round_tower_stay_faces() {
        let (positions, triangles) = strip(20, std::f64::consts::TAU / 256.0);
        let faces = join_coplanar(&triangles, &positions, 1e-7);
        assert_eq!(faces.iter().map(Vec::len).collect::<Vec<_>>(), [4; 20]);
        assert_eq!(faces[3][0], 6, "in file order");
    }

    #[test]
    fn a_triangle_without_area_between_two_others_does_not_part_them() {
        // The middle of the long edge is a corner of the lower triangles only.
        let positions =
            [[0., 0.], [2., 0.], [2., 2.], [1., 0.], [1., -1.]].map(|[x, y]| DVec3::new(x, y, 0.0));
        let triangles = [[0, 1, 2], [0, 3, 1], [0, 4, 3], [3, 4, 1]];
        let faces = join_coplanar(&triangles, &positions, 1e-7);
        assert_eq!(faces.len(), 1);
        assert_eq!(faces[0].len(), 4);
    }

    #[test]
    fn a_sheet_folded_back_onto_itself_is_two_faces() {
        let positions = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0.2, 0.5, 0.0]].map(DVec3::from_array);
        assert_eq!(join_coplanar(&[[0, 1, 2], [2, 1, 3]], &positions, 1e-7).len(), 2);
    }
}
