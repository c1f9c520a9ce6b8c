//! Faces whose edges are dragged along their plane.

use glam::{DVec2, DVec3};

use quadratura_base::geometry::polygon::newell_normal;

/// The sine of the least angle to a neighbouring edge along which a corner slides: 20 degrees. Along flatter ones it would leave far.
const LEAST_SINE: f64 = 0.34;

/// Returns a ring with the edge that begins at corner `edge` moved within the ring's plane, so that its line passes `to`. Its ends slide
/// along the neighbouring edges, or straight aside where these run nearly alike. `None` for the bridge to a hole, and where the
/// ring would cross itself or turn inside out.
pub fn with_edge_through(ring: &[DVec3], normal: DVec3, edge: usize, to: DVec3) -> Option<Vec<DVec3>> {
    let count = ring.len();
    if edge >= count || is_bridge(ring, edge) {
        return None;
    }
    let (before, after) = ((edge + count - 1) % count, (edge + 1) % count);
    let (from, end) = (ring[edge], ring[after]);
    let aside = (end - from).try_normalize()?.cross(normal);
    let by = (to - from).dot(aside);
    let slid = |corner: DVec3, neighbour: DVec3, bridges: bool| {
        let along = (corner - neighbour).normalize_or_zero();
        let sine = along.dot(aside);
        if bridges || sine.abs() < LEAST_SINE { corner + aside * by } else { corner + along * (by / sine) }
    };
    let new_from = slid(from, ring[before], is_bridge(ring, before));
    let new_end = slid(end, ring[(after + 1) % count], is_bridge(ring, after));
    // The ends of bridges are corners that repeat.
    let moved = |corner: &DVec3| match *corner {
        it if it == from => new_from,
        it if it == end => new_end,
        it => it,
    };
    let moved: Vec<DVec3> = ring.iter().map(moved).collect();
    let touched = [before, edge, after];
    let keeps = |at: usize| {
        let side = |ring: &[DVec3]| ring[(at + 1) % count] - ring[at];
        is_bridge(ring, at) || side(ring).dot(side(&moved)) > 0.0
    };
    let stays = newell_normal(&moved).dot(normal) > 0.0
        && touched.into_iter().all(keeps)
        && crossings(&moved, normal, &touched) <= crossings(ring, normal, &touched);
    stays.then_some(moved)
}

/// Returns whether an edge is walked back elsewhere: it leads to a hole and is no edge of the face.
pub fn is_bridge(ring: &[DVec3], edge: usize) -> bool {
    let next = |at: usize| ring[(at + 1) % ring.len()];
    (0..ring.len()).any(|other| ring[other] == next(edge) && next(other) == ring[edge])
}

/// Returns how often some edges of a ring cross others.
fn crossings(ring: &[DVec3], normal: DVec3, edges: &[usize]) -> usize {
    let (u, v) = normal.any_orthonormal_pair();
    let flat: Vec<DVec2> = ring.iter().map(|corner| DVec2::new(corner.dot(u), corner.dot(v))).collect();
    let ends = |at: usize| (flat[at], flat[(at + 1) % flat.len()]);
    let crosses = |a: usize, b: usize| {
        let ((p, q), (r, s)) = (ends(a), ends(b));
        let side = |from: DVec2, to: DVec2, at: DVec2| (to - from).perp_dot(at - from);
        side(p, q, r) * side(p, q, s) < 0.0 && side(r, s, p) * side(r, s, q) < 0.0
    };
    edges.iter().flat_map(|a| (0..flat.len()).map(move |b| (*a, b))).filter(|(a, b)| crosses(*a, *b)).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Vec<DVec3> {
        [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)].map(|(x, y)| DVec3::new(x, y, 1.0)).to_vec()
    }

    #[test]
    fn an_edge_is_moved_in_its_plane_and_neighbours_grow() {
        let moved = with_edge_through(&square(), DVec3::Z, 1, DVec3::new(6.0, 9.0, 5.0)).unwrap();
        assert_eq!(moved[1..3], [DVec3::new(6.0, 0.0, 1.0), DVec3::new(6.0, 4.0, 1.0)]);
        assert_eq!([moved[0], moved[3]], [square()[0], square()[3]]);
    }

    #[test]
    fn ends_slide_along_slanted_neighbours() {
        let gable = [(0.0, 0.0), (4.0, 0.0), (3.0, 2.0), (1.0, 2.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let moved = with_edge_through(&gable, DVec3::Z, 2, DVec3::new(2.0, 3.0, 0.0)).unwrap();
        assert!(moved[2].distance(DVec3::new(2.5, 3.0, 0.0)) < 1e-12, "{moved:?}");
        assert!(moved[3].distance(DVec3::new(1.5, 3.0, 0.0)) < 1e-12, "{moved:?}");
        let beyond = with_edge_through(&gable, DVec3::Z, 2, DVec3::new(2.0, 5.0, 0.0));
        assert_eq!(beyond, None, "the edge would turn round beyond the gable's tip");
    }

    #[test]
    fn a_face_never_turns_inside_out_and_bridges_are_no_edges() {
        assert_eq!(with_edge_through(&square(), DVec3::Z, 1, DVec3::new(-1.0, 0.0, 1.0)), None);
        let hole = [(1.0, 1.0), (1.0, 2.0), (2.0, 2.0), (2.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
        let ring = quadratura_base::geometry::polygon::bridge_holes(&square(), &[hole.to_vec()]).remove(0);
        let bridges = (0..ring.len()).filter(|edge| is_bridge(&ring, *edge)).count();
        assert_eq!((ring.len(), bridges), (10, 2));
        for edge in 0..ring.len() {
            let aside = ring[edge] + 0.1 * (ring[(edge + 1) % ring.len()] - ring[edge]).cross(DVec3::Z);
            let moved = with_edge_through(&ring, DVec3::Z, edge, aside);
            assert_eq!(moved.is_none(), is_bridge(&ring, edge), "{edge}");
        }
        let crossing = ring.iter().position(|corner| *corner == hole[0]).unwrap();
        assert!(with_edge_through(&ring, DVec3::Z, crossing, DVec3::new(-1.0, -1.0, 1.0)).is_none());
    }
}
