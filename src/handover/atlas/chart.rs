//! Charts: faces of one plane that touch, in the axes of this plane.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use quadratura_base::geometry::Plane;
use quadratura_base::geometry::polygon::{PlaneFrame, is_planar};

/// The least cosine between the normals of faces of one chart. With the test that their corners lie in one plane it only keeps apart
/// faces that look to opposite sides.
const SAME_SIDE: f64 = 0.99;

/// The largest cosine between a wall's normal and the world's up direction; the charts of walls are upright.
const STEEP: f64 = 0.7;

/// A face that gets a place in the atlas.
#[derive(Debug, Clone, PartialEq)]
pub struct ChartFace {
    /// The outline in the world: one ring, holes bridged.
    pub ring: Vec<DVec3>,
    /// Its plane, whose normal looks to the side that is textured.
    pub plane: Plane,
    /// Faces with different numbers are never in one chart.
    pub group: u32,
}

/// Faces in their plane.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// The faces, as indices into the list that the charts were made from; ascending.
    pub faces: Vec<usize>,
    /// The axes of the plane: `u` to the right and `v` up, seen from the textured side.
    pub frame: PlaneFrame,
    /// The smallest coordinates of the outlines in this frame, in units of the world.
    pub low: DVec2,
    /// The largest coordinates, likewise.
    pub high: DVec2,
}

impl Chart {
    /// Returns width and height in units of the world.
    pub fn size(&self) -> DVec2 {
        self.high - self.low
    }

    /// Makes a chart of faces. `up` is the world's unit up direction.
    pub fn new(faces: &[ChartFace], members: Vec<usize>, up: DVec3) -> Self {
        let frame = frame(faces, &members, up);
        let points = || members.iter().flat_map(|&face| &faces[face].ring).map(|&point| frame.flat(point));
        let low = points().fold(DVec2::INFINITY, DVec2::min);
        let high = points().fold(DVec2::NEG_INFINITY, DVec2::max);
        Self { faces: members, frame, low, high }
    }
}

/// Gathers faces to charts, in the order of their first faces: those that share an edge and lie in one plane, with
/// one textured side. `up` is the world's unit up direction.
pub fn charts(faces: &[ChartFace], up: DVec3) -> Vec<Chart> {
    let mut parents: Vec<usize> = (0..faces.len()).collect();
    for [a, b] in neighbours(faces) {
        let [a, b] = [root(&mut parents, a), root(&mut parents, b)];
        if a != b && in_one_plane(&faces[a], &faces[b]) {
            parents[a.max(b)] = a.min(b);
        }
    }
    let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for face in 0..faces.len() {
        members.entry(root(&mut parents, face)).or_default().push(face);
    }
    members.into_values().map(|members| Chart::new(faces, members, up)).collect()
}

/// Returns the pairs of faces of one group that share an edge, in their order.
fn neighbours(faces: &[ChartFace]) -> Vec<[usize; 2]> {
    // Adding zero turns -0.0 into 0.0.
    let key = |point: DVec3| point.to_array().map(|x| (x + 0.0).to_bits());
    let mut on_edge: BTreeMap<_, Vec<usize>> = BTreeMap::new();
    for (index, face) in faces.iter().enumerate() {
        for (i, &from) in face.ring.iter().enumerate() {
            let [a, b] = [from, face.ring[(i + 1) % face.ring.len()]].map(key);
            on_edge.entry((face.group, a.min(b), a.max(b))).or_default().push(index);
        }
    }
    let mut pairs: Vec<[usize; 2]> = on_edge
        .into_values()
        .flat_map(|faces| faces.windows(2).map(|pair| [pair[0], pair[1]]).collect::<Vec<_>>())
        .filter(|[a, b]| a != b)
        .collect();
    pairs.sort_unstable();
    pairs
}

/// Returns the face that stands for all of its chart, and shortens the way to it.
fn root(parents: &mut [usize], mut face: usize) -> usize {
    while parents[face] != face {
        parents[face] = parents[parents[face]];
        face = parents[face];
    }
    face
}

/// Returns whether each of two faces lies in the other's plane and looks to the same side.
fn in_one_plane(a: &ChartFace, b: &ChartFace) -> bool {
    a.plane.normal.dot(b.plane.normal) >= SAME_SIDE
        && is_planar(&a.ring, &b.plane)
        && is_planar(&b.ring, &a.plane)
        && is_planar(&a.ring, &a.plane)
}

/// Returns the axes of a chart: of walls the world's up direction points up, of others the longest edge to the right.
fn frame(faces: &[ChartFace], members: &[usize], up: DVec3) -> PlaneFrame {
    let Plane { normal, point } = faces[members[0]].plane;
    let upright = up.reject_from_normalized(normal).try_normalize();
    let upright = upright.filter(|_| normal.dot(up).abs() <= STEEP);
    let v = upright.unwrap_or_else(|| normal.cross(longest_edge(faces, members, normal)));
    PlaneFrame { origin: point, u: v.cross(normal), v }
}

/// Returns the unit direction of the longest edge, within the plane; of equally long ones the first.
fn longest_edge(faces: &[ChartFace], members: &[usize], normal: DVec3) -> DVec3 {
    let mut longest = DVec3::ZERO;
    for &face in members {
        let ring = &faces[face].ring;
        for (i, &from) in ring.iter().enumerate() {
            let edge = (ring[(i + 1) % ring.len()] - from).reject_from_normalized(normal);
            // Rounding must not decide between edges of one length.
            if edge.length() > longest.length() * (1.0 + 1e-9) {
                longest = edge;
            }
        }
    }
    longest.try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector())
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::geometry::polygon::fit_plane;

    fn face(corners: &[[f64; 3]], group: u32) -> ChartFace {
        let ring: Vec<DVec3> = corners.iter().copied().map(DVec3::from).collect();
        let plane = fit_plane(&ring).unwrap();
        ChartFace { ring, plane, group }
    }

    /// A wall in the plane y = 0 that is seen from the front, from `x` to `x + 2`.
    fn wall(x: f64, group: u32) -> ChartFace {
        face(&[[x, 0., 0.], [x + 2., 0., 0.], [x + 2., 0., 3.], [x, 0., 3.]], group)
    }

    #[test]
    fn walls_that_touch_are_one_chart_and_those_round_the_corner_another() {
        let corner = face(&[[4., 0., 0.], [4., 5., 0.], [4., 5., 3.], [4., 0., 3.]], 0);
        let faces = [wall(0.0, 0), wall(2.0, 0), corner, wall(7.0, 0), wall(9.0, 1)];
        let found = charts(&faces, DVec3::Z);
        let members: Vec<_> = found.iter().map(|chart| chart.faces.clone()).collect();
        assert_eq!(members, [vec![0, 1], vec![2], vec![3], vec![4]]);
        assert!((found[0].size() - DVec2::new(4.0, 3.0)).length() < 1e-12);
    }

    #[test]
    fn a_wall_is_upright_and_reads_from_left_to_right_as_seen_from_its_side() {
        let chart = &charts(&[wall(0.0, 0)], DVec3::Z)[0];
        assert!((chart.frame.v - DVec3::Z).length() < 1e-12 && (chart.frame.u - DVec3::X).length() < 1e-12);
        let back = ChartFace {
            plane: Plane { normal: -wall(0.0, 0).plane.normal, ..wall(0.0, 0).plane },
            ..wall(0.0, 0)
        };
        assert!((charts(&[back], DVec3::Z)[0].frame.u + DVec3::X).length() < 1e-12);
    }

    #[test]
    fn a_floor_lies_along_its_longest_edge() {
        let (s, c) = 0.3f64.sin_cos();
        let at = |x: f64, y: f64| [c * x - s * y, s * x + c * y, 0.0];
        let chart = &charts(&[face(&[at(0., 0.), at(9., 0.), at(9., 2.), at(0., 2.)], 0)], DVec3::Z)[0];
        assert!((chart.size() - DVec2::new(9.0, 2.0)).length() < 1e-9, "{:?}", chart.size());
    }

    #[test]
    fn both_sides_of_a_sheet_are_two_charts() {
        let front = wall(0.0, 0);
        let mut ring = front.ring.clone();
        ring.reverse();
        let back = ChartFace { plane: fit_plane(&ring).unwrap(), ring, group: 0 };
        assert_eq!(charts(&[front, back], DVec3::Z).len(), 2);
    }
}
