//! The order in which a view draws see-through surfaces: from back to front, cut where they cross, by binary space
//! partitioning (Fuchs, Kedem & Naylor 1980).

use std::collections::BTreeMap;

use glam::DVec3;

use quadratura_base::geometry::Plane;

/// A convex part of a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// The index of the surface.
    pub surface: u32,
    /// The plane of the surface.
    pub plane: Plane,
    /// The corners, in world coordinates, in order about the piece.
    pub corners: Vec<DVec3>,
}

/// The distance from a plane within which a corner lies on it, as a share of the largest distance from the eye.
const ON_PLANE: f64 = 1e-9;

/// The distance from an edge within which a corner lies on it, as a share of the largest distance from the eye.
const SEAM: f64 = 1e-8;

/// The number of pieces that are tried as the one whose plane parts the others.
const TRIED: usize = 8;

/// Orders surfaces so that each piece is behind all that follow, as seen from `eye`, or beside them. Surfaces that cross
/// are cut along the line where they do. Of pieces in one plane those given last come last.
pub fn back_to_front(pieces: Vec<Piece>, eye: DVec3) -> Vec<Piece> {
    let corners = pieces.iter().flat_map(|piece| &piece.corners);
    let reach = corners.map(|corner| corner.distance(eye)).fold(0.0, f64::max);
    let mut ordered = Vec::with_capacity(pieces.len());
    order(pieces, eye, ON_PLANE * reach, &mut ordered);
    sew(&mut ordered, SEAM * reach);
    ordered
}

/// Gives every piece the corners of others of its surface that lie on its edges. Otherwise an edge of one piece beside two
/// shorter ones of others would be rounded to another line, and pixels there be drawn twice or not at all.
fn sew(pieces: &mut [Piece], on_edge: f64) {
    let mut corners: BTreeMap<u32, Vec<DVec3>> = BTreeMap::new();
    for piece in &*pieces {
        corners.entry(piece.surface).or_default().extend(&piece.corners);
    }
    for piece in pieces {
        let all = &corners[&piece.surface];
        let ends = piece.corners.iter().zip(piece.corners.iter().cycle().skip(1));
        piece.corners = ends.flat_map(|(a, b)| with_corners_between(*a, *b, all, on_edge)).collect();
    }
}

/// Returns the first end of an edge and the corners on it, in the edge's order.
fn with_corners_between(a: DVec3, b: DVec3, corners: &[DVec3], on_edge: f64) -> Vec<DVec3> {
    let along = b - a;
    let length = along.length();
    let is_between = |(place, corner): &(f64, DVec3)| {
        let off = (*corner - a - along * *place).length();
        off < on_edge && *place * length > on_edge && (1.0 - *place) * length > on_edge
    };
    let place = |corner: &DVec3| ((*corner - a).dot(along) / (length * length), *corner);
    let mut between: Vec<(f64, DVec3)> = corners.iter().map(place).filter(is_between).collect();
    between.sort_by(|a, b| a.0.total_cmp(&b.0));
    between.dedup();
    [a].into_iter().chain(between.into_iter().map(|(_, corner)| corner)).collect()
}

impl Piece {
    /// Returns the piece as triangles, none of which spans two of its edges that lie on one line.
    pub fn triangles(&self) -> Vec<[DVec3; 3]> {
        if let [a, b, c] = self.corners[..] {
            return vec![[a, b, c]];
        }
        let middle = self.corners.iter().sum::<DVec3>() / self.corners.len() as f64;
        let ends = self.corners.iter().zip(self.corners.iter().cycle().skip(1));
        ends.map(|(a, b)| [middle, *a, *b]).collect()
    }
}

fn order(pieces: Vec<Piece>, eye: DVec3, on_plane: f64, ordered: &mut Vec<Piece>) {
    if pieces.len() < 2 {
        ordered.extend(pieces);
        return;
    }
    let plane = parting(&pieces, on_plane);
    let is_front = |distance: f64| (distance > 0.0) == (plane.signed_distance(eye) > 0.0);
    let (mut behind, mut within, mut before) = (Vec::new(), Vec::new(), Vec::new());
    for piece in pieces {
        for (distance, part) in parts(piece, &plane, on_plane) {
            match distance {
                0.0 => within.push(part),
                distance if is_front(distance) => before.push(part),
                _ => behind.push(part),
            }
        }
    }
    order(behind, eye, on_plane, ordered);
    ordered.extend(within);
    order(before, eye, on_plane, ordered);
}

/// Returns the plane of the piece that cuts the fewest others, of some.
fn parting(pieces: &[Piece], on_plane: f64) -> Plane {
    let step = pieces.len().div_ceil(TRIED);
    let cuts = |plane: &Plane| {
        let is_cut = |piece: &&Piece| {
            let [low, high] = extent(piece, plane);
            low < -on_plane && high > on_plane
        };
        pieces.iter().filter(is_cut).count()
    };
    let tried = pieces.iter().step_by(step).map(|piece| piece.plane);
    tried.min_by_key(cuts).expect("there are pieces")
}

/// Returns the least and the largest signed distance of a piece's corners from a plane.
fn extent(piece: &Piece, plane: &Plane) -> [f64; 2] {
    let distances = piece.corners.iter().map(|corner| plane.signed_distance(*corner));
    distances.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], d| [low.min(d), high.max(d)])
}

/// Cuts a piece by a plane. Returns the parts, each with the signed distance of its farthest corner, 0 for a piece in the
/// plane.
fn parts(piece: Piece, plane: &Plane, on_plane: f64) -> Vec<(f64, Piece)> {
    let [low, high] = extent(&piece, plane);
    match (low < -on_plane, high > on_plane) {
        (false, false) => vec![(0.0, piece)],
        (true, false) => vec![(low, piece)],
        (false, true) => vec![(high, piece)],
        (true, true) => [(low, -1.0), (high, 1.0)]
            .map(|(distance, side)| {
                let corners = half(&piece.corners, |corner| side * plane.signed_distance(corner), on_plane);
                (distance, Piece { corners, ..piece.clone() })
            })
            .into(),
    }
}

/// Returns the part of a convex polygon where the distance is not negative.
fn half(corners: &[DVec3], distance: impl Fn(DVec3) -> f64, on_plane: f64) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(corners.len() + 1);
    for (i, &corner) in corners.iter().enumerate() {
        let next = corners[(i + 1) % corners.len()];
        let (here, there) = (distance(corner), distance(next));
        if here >= -on_plane {
            kept.push(corner);
        }
        if here.abs() > on_plane && there.abs() > on_plane && (here > 0.0) != (there > 0.0) {
            kept.push(crossing((corner, here), (next, there)));
        }
    }
    kept
}

/// Returns where an edge crosses a plane, from its ends and their distances: the same point for both surfaces that share
/// the edge, in whichever direction they have it.
fn crossing(a: (DVec3, f64), b: (DVec3, f64)) -> DVec3 {
    let is_first = a.0.to_array() < b.0.to_array();
    let ((from, here), (to, there)) = if is_first { (a, b) } else { (b, a) };
    from + (to - from) * (here / (here - there))
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::geometry::polygon::fit_plane;
    use quadratura_base::scene::synthetic::Rng;

    fn piece(surface: u32, corners: &[DVec3]) -> Piece {
        Piece { surface, plane: fit_plane(corners).unwrap(), corners: corners.to_vec() }
    }

    /// Returns where a ray from the origin passes through a convex piece.
    fn met(piece: &Piece, ray: DVec3) -> Option<f64> {
        let t = -piece.plane.signed_distance(DVec3::ZERO) / piece.plane.normal.dot(ray);
        let point = ray * t;
        let edges = piece.corners.iter().zip(piece.corners.iter().cycle().skip(1));
        let sides: Vec<f64> =
            edges.map(|(a, b)| (*b - *a).cross(point - *a).dot(piece.plane.normal)).collect();
        let inside = sides.iter().all(|side| *side > 0.0) || sides.iter().all(|side| *side < 0.0);
        (t > 0.0 && inside).then_some(t)
    }

    #[test]
    fn every_ray_passes_crossing_pieces_from_back_to_front_and_all_of_each_surface_once() {
        let mut rng = Rng::new(3);
        for _ in 0..20 {
            let triangle = |surface: u32, rng: &mut Rng| {
                let corner = |rng: &mut Rng| {
                    DVec3::new(rng.between(-5.0, 5.0), rng.between(-5.0, 5.0), rng.between(3.0, 12.0))
                };
                piece(surface, &[corner(rng), corner(rng), corner(rng)])
            };
            let all: Vec<Piece> = (0..30).map(|surface| triangle(surface, &mut rng)).collect();
            let ordered = back_to_front(all.clone(), DVec3::ZERO);
            assert!(ordered.len() > 40, "they cross: {}", ordered.len());
            for _ in 0..200 {
                let ray = DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), 1.0);
                let hits = |pieces: &[Piece]| -> Vec<(f64, u32)> {
                    pieces.iter().filter_map(|piece| Some((met(piece, ray)?, piece.surface))).collect()
                };
                let found = hits(&ordered);
                assert!(found.is_sorted_by(|a, b| a.0 >= b.0), "{found:?}");
                let mut expected = hits(&all);
                expected.sort_by(|a, b| b.0.total_cmp(&a.0));
                assert_eq!(found, expected);
            }
        }
    }

    #[test]
    fn of_pieces_in_one_plane_the_last_is_on_top_and_neither_is_cut() {
        let square = |surface: u32, at: f64| {
            let corner = |x: f64, y: f64| DVec3::new(at + x, y, 4.0);
            piece(surface, &[corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)])
        };
        let pieces = vec![square(0, 0.0), square(1, 0.5), square(2, 0.2)];
        assert_eq!(back_to_front(pieces.clone(), DVec3::ZERO), pieces);
    }

    #[test]
    fn pieces_of_one_surface_share_all_corners_on_their_edges() {
        let mut rng = Rng::new(8);
        let mut shared = 0;
        for _ in 0..10 {
            let triangle = |surface: u32, rng: &mut Rng| {
                let corner = |rng: &mut Rng| {
                    DVec3::new(rng.between(-5.0, 5.0), rng.between(-5.0, 5.0), rng.between(3.0, 12.0))
                };
                piece(surface, &[corner(rng), corner(rng), corner(rng)])
            };
            let ordered = back_to_front((0..12).map(|i| triangle(i, &mut rng)).collect(), DVec3::ZERO);
            for surface in 0..12 {
                let edges: Vec<(DVec3, DVec3)> = ordered
                    .iter()
                    .filter(|piece| piece.surface == surface)
                    .flat_map(Piece::triangles)
                    .flat_map(|[a, b, c]| [(a, b), (b, c), (c, a)])
                    .collect();
                for (a, b) in &edges {
                    let is_on = |p: &DVec3| {
                        let place = (*p - *a).dot(*b - *a) / (*b - *a).length_squared();
                        (*a + (*b - *a) * place).distance(*p) < 1e-9 && place > 1e-6 && place < 1.0 - 1e-6
                    };
                    assert!(!edges.iter().any(|(p, _)| is_on(p)), "a corner lies within an edge");
                    shared += usize::from(edges.contains(&(*b, *a)));
                }
            }
        }
        assert!(shared > 1000, "{shared} edges have a piece on either side");
    }

    #[test]
    fn two_triangles_that_share_an_edge_are_cut_at_the_same_point_of_it() {
        let [a, b, c, d] =
            [(0.0, 0.0), (1.0, 0.1), (1.0, 0.9), (0.1, 1.0)].map(|(x, y)| DVec3::new(x, y, 4.0));
        let wall = [DVec3::new(0.4, -9.0, 1.0), DVec3::new(0.5, 9.0, 1.0), DVec3::new(0.3, 0.0, 9.0)];
        let wall = piece(7, &wall).plane;
        let cut: Vec<Piece> = [[a, b, c], [c, d, a]]
            .iter()
            .flat_map(|corners| parts(piece(0, corners), &wall, 1e-9))
            .map(|(_, part)| part)
            .collect();
        assert_eq!(cut.len(), 4);
        let on_diagonal = |p: &&DVec3| (p.x - p.y * c.x / c.y).abs() < 1e-9 && **p != a && **p != c;
        let points: Vec<DVec3> =
            cut.iter().flat_map(|piece| piece.corners.iter().filter(on_diagonal)).copied().collect();
        assert!(points.len() == 4 && points.iter().all(|point| *point == points[0]), "{points:?}");
    }
}
