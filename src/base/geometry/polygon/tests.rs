//! Closed forms and properties of triangulation, bridging and cutting together.

use std::f64::consts::TAU;

use glam::{DQuat, DVec2, DVec3};
use proptest::prelude::*;

use super::*;
use crate::geometry::Plane;

fn flat(points: &[[f64; 2]]) -> Vec<DVec3> {
    points.iter().map(|&[x, y]| DVec3::new(x, y, 0.0)).collect()
}

fn triangles_of(ring: &[DVec3]) -> Triangulation {
    triangulate(ring, &fit_plane(ring).unwrap())
}

fn corners(ring: &[DVec3], t: &Triangulation) -> Vec<[DVec3; 3]> {
    let points = [ring, &t.crossings].concat();
    t.triangles.iter().map(|t| t.map(|i| points[i as usize])).collect()
}

fn area_vector([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a) / 2.0
}

fn area(ring: &[DVec3]) -> f64 {
    newell_normal(ring).length() / 2.0
}

/// Makes a square with a square hole, bridged from corner to corner.
fn square_with_hole() -> Vec<DVec3> {
    flat(&[
        [0., 0.],
        [4., 0.],
        [4., 4.],
        [0., 4.],
        [0., 0.],
        [1., 1.],
        [1., 3.],
        [3., 3.],
        [3., 1.],
        [1., 1.],
    ])
}

/// Checks that no triangle is flipped, and that together they have the ring's area.
fn check_triangles(ring: &[DVec3]) -> Result<(), TestCaseError> {
    let t = triangles_of(ring);
    let normal = newell_normal(ring) / 2.0;
    let areas: Vec<f64> =
        corners(ring, &t).into_iter().map(|c| area_vector(c).dot(normal.normalize())).collect();
    prop_assert_eq!(t.flaw, None);
    prop_assert_eq!(t.triangles.len(), ring.len() - 2, "Euler: {:?}", ring);
    prop_assert!(areas.iter().all(|&a| a > 0.0), "{:?}", areas);
    let sum: f64 = areas.iter().sum();
    prop_assert!((sum - normal.length()).abs() < 1e-6 * normal.length(), "{} {}", sum, normal.length());
    Ok(())
}

#[test]
fn a_square_is_two_triangles_wound_like_it() {
    let square = flat(&[[0., 0.], [1., 0.], [1., 1.], [0., 1.]]);
    assert_eq!(triangles_of(&square).triangles, [[0, 1, 2], [0, 2, 3]]);
    let turned: Vec<DVec3> = square.into_iter().rev().collect();
    assert!(corners(&turned, &triangles_of(&turned)).iter().all(|&c| area_vector(c).z < 0.0));
}

#[test]
fn a_bridged_hole_stays_a_hole() {
    let ring = square_with_hole();
    check_triangles(&ring).unwrap();
    let sum: f64 = corners(&ring, &triangles_of(&ring)).into_iter().map(|c| area_vector(c).z).sum();
    assert_eq!(sum, 12.0);
}

#[test]
fn a_hole_wound_the_wrong_way_is_still_a_hole() {
    let ring = flat(&[
        [0., 0.],
        [4., 0.],
        [4., 4.],
        [0., 4.],
        [0., 0.],
        [1., 1.],
        [3., 1.],
        [3., 3.],
        [1., 3.],
        [1., 1.],
    ]);
    let sum: f64 = corners(&ring, &triangles_of(&ring)).into_iter().map(|c| area_vector(c).z).sum();
    assert_eq!(sum, 12.0);
}

#[test]
fn corners_in_the_middle_of_an_edge_belong_to_a_triangle() {
    let ring = flat(&[[0., 0.], [1., 0.], [2., 0.], [2., 1.], [2., 2.], [1., 2.], [0., 2.], [0., 1.]]);
    check_triangles(&ring).unwrap();
}

#[test]
fn points_on_a_line_and_repeated_points_have_no_triangles() {
    let plane = Plane { normal: DVec3::Z, point: DVec3::ZERO };
    let line = flat(&[[0., 0.], [1., 0.], [2., 0.], [5., 0.]]);
    assert_eq!(triangulate(&line, &plane).flaw, Some(OutlineFlaw::NoArea));
    assert_eq!(triangulate(&[DVec3::ONE; 5], &plane).flaw, Some(OutlineFlaw::TooFewPoints));
    assert_eq!(triangulate(&line[..2], &plane).flaw, Some(OutlineFlaw::TooFewPoints));
    let there_and_back = flat(&[[0., 0.], [1., 0.], [1., 1.], [1., 0.]]);
    assert_eq!(triangulate(&there_and_back, &plane).flaw, Some(OutlineFlaw::NoArea));
}

#[test]
fn a_point_given_twice_in_a_row_changes_nothing() {
    let ring = flat(&[[0., 0.], [1., 0.], [1., 0.], [1., 1.], [0., 1.], [0., 0.]]);
    let t = triangles_of(&ring);
    assert_eq!((t.flaw, t.triangles.len()), (None, 2));
}

#[test]
fn an_outline_that_crosses_itself_is_split_at_the_crossing() {
    let bow = flat(&[[0., 0.], [3., 3.], [3., 0.], [0., 2.]]);
    let t = triangles_of(&bow);
    assert_eq!(t.flaw, Some(OutlineFlaw::SelfCrossing));
    assert_eq!(t.crossings.len(), 1);
    assert!((t.crossings[0] - DVec3::new(1.2, 1.2, 0.0)).length() < 1e-7, "on the grid");
    let sum: f64 = corners(&bow, &t).into_iter().map(|c| area_vector(c).length()).sum();
    assert!((sum - (1.2 + 2.7)).abs() < 1e-7, "{sum}");
}

#[test]
fn a_hole_that_touches_an_edge_crosses_nothing() {
    // The hole's corner lies on the outline's edge x + 3 y = 4, which no binary number hits exactly.
    let third = 1.0 / 3.0;
    let outer = flat(&[[0., 0.], [4., 0.], [1., 1.], [0., 4. * third]]);
    let hole = flat(&[[2.5, 0.5], [2.0, 0.25], [2.75, 0.25]]);
    for ring in bridge_holes(&outer, &[hole]) {
        assert_ne!(triangles_of(&ring).flaw, Some(OutlineFlaw::SelfCrossing));
    }
}

#[test]
fn a_concave_ring_falls_into_several_pieces() {
    let comb = flat(&[
        [0., 0.],
        [5., 0.],
        [5., 3.],
        [4., 3.],
        [4., 1.],
        [3., 1.],
        [3., 3.],
        [2., 3.],
        [2., 1.],
        [1., 1.],
        [1., 3.],
        [0., 3.],
    ]);
    let plane = Plane { normal: DVec3::Y, point: DVec3::new(0.0, 2.0, 0.0) };
    let (above, below) = split_by_plane(&comb, &plane);
    assert_eq!(above.iter().map(|r| area(r)).collect::<Vec<_>>(), [1.0, 1.0, 1.0]);
    assert!(above.iter().all(|r| r.len() == 4));
    assert_eq!(below.len(), 1);
    assert_eq!(area(&below[0]), 8.0);
    assert_eq!(below[0].len(), 12, "no points but corners: {below:?}");
}

#[test]
fn a_cut_beside_a_hole_keeps_it_and_a_cut_through_it_opens_it() {
    let ring = square_with_hole();
    let cut = |x: f64| split_by_plane(&ring, &Plane { normal: DVec3::X, point: DVec3::X * x });
    let (right, left) = cut(0.5);
    assert_eq!((right.len(), left.len()), (1, 1));
    assert_eq!((area(&right[0]), area(&left[0]), left[0].len()), (10.0, 2.0, 4));
    assert_eq!(right[0].len(), 10, "outer corners, hole's corners, and the bridge's ends once more");
    let (right, left) = cut(2.0);
    assert_eq!((right.len(), left.len()), (1, 1));
    assert_eq!((area(&right[0]), area(&left[0])), (6.0, 6.0));
    assert_eq!((right[0].len(), left[0].len()), (8, 8));
}

#[test]
fn a_cut_along_an_edge_gives_one_side_only() {
    let square = flat(&[[0., 0.], [1., 0.], [1., 1.], [0., 1.]]);
    let (front, back) = split_by_plane(&square, &Plane { normal: DVec3::X, point: DVec3::ZERO });
    assert_eq!((front, back.len()), (vec![square.clone()], 0));
    let (front, back) = split_by_plane(&square, &Plane { normal: DVec3::Z, point: DVec3::ZERO });
    assert_eq!((front, back.len()), (vec![square], 0));
}

#[test]
fn a_cut_through_two_corners_makes_no_new_point() {
    let square = flat(&[[0., 0.], [1., 0.], [1., 1.], [0., 1.]]);
    let diagonal = Plane { normal: DVec3::new(0.8, -0.6, 0.0), point: DVec3::ZERO };
    let (front, back) = split_by_plane(&square, &diagonal);
    assert_eq!((front[0].len(), back[0].len()), (4, 3));
    let diagonal = Plane { normal: DVec3::new(1.0, -1.0, 0.0).normalize(), point: DVec3::ZERO };
    let (front, back) = split_by_plane(&square, &diagonal);
    assert_eq!((front[0].len(), back[0].len()), (3, 3));
}

#[test]
fn holes_are_bridged_by_doubled_edges() {
    let outer = flat(&[[0., 0.], [9., 0.], [9., 9.], [0., 9.]]);
    let hole = |x: f64, y: f64| flat(&[[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0]]);
    let rings = bridge_holes(&outer, &[hole(1., 1.), hole(4., 4.), hole(7., 2.)]);
    assert_eq!(rings.len(), 1);
    assert_eq!(rings[0].len(), 4 + 3 * 4 + 3 * 2);
    assert!((area(&rings[0]) - 78.0).abs() < 1e-12);
    check_triangles(&rings[0]).unwrap();
}

#[test]
fn squares_side_by_side_get_one_outline_and_points_inside_leave_no_trace() {
    // A 4 x 4 grid of squares without its middle four: a hole; the corners of the outer row remain.
    let at = |x: u32, y: u32| y * 5 + x;
    let positions: Vec<DVec3> =
        (0..25).map(|i| DVec3::new(f64::from(i % 5), f64::from(i / 5), 0.0)).collect();
    let square = |x, y| vec![at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
    let all: Vec<Vec<u32>> = (0..16).map(|i| square(i % 4, i / 4)).collect();
    let distance = |a: u32, b: u32| positions[a as usize].distance(positions[b as usize]);
    assert_eq!(outlines(&all, distance)[0].len(), 16);
    let is_middle = |s: &Vec<u32>| [at(1, 1), at(2, 1), at(1, 2), at(2, 2)].contains(&s[0]);
    let frame: Vec<Vec<u32>> = all.into_iter().filter(|s| !is_middle(s)).collect();
    let rings = outlines(&frame, distance);
    assert_eq!(rings.len(), 1);
    assert_eq!(rings[0].len(), 16 + 8 + 2);
}

#[test]
fn a_hole_in_a_fine_grid_is_bridged_once_and_no_branch_is_left() {
    // 30 x 30 squares without one: the bridge passes inner points, and all other branches are removed.
    let positions: Vec<DVec3> =
        (0..961).map(|i| DVec3::new(f64::from(i % 31), f64::from(i / 31), 0.0)).collect();
    let square = |i: u32| {
        let at = i / 30 * 31 + i % 30;
        vec![at, at + 1, at + 32, at + 31]
    };
    let squares: Vec<Vec<u32>> = (0..900).filter(|&i| i != 15 * 30 + 4).map(square).collect();
    let distance = |a: u32, b: u32| positions[a as usize].distance(positions[b as usize]);
    let rings = outlines(&squares, distance);
    assert_eq!(rings.len(), 1);
    let points: Vec<DVec3> = rings[0].iter().map(|&i| positions[i as usize]).collect();
    assert_eq!(area(&points), 899.0);
    assert!(points.len() >= 120 + 4 + 2 * 4, "{}", points.len());
    check_triangles(&points).unwrap();
}

/// Makes a star-shaped outline around the origin, with bridged star-shaped holes.
fn star(radii: &[f64], centre: DVec2, size: f64) -> Vec<DVec3> {
    let corner = |(i, &r): (usize, &f64)| {
        let at = centre + DVec2::from_angle(TAU * i as f64 / radii.len() as f64) * (r * size);
        at.extend(0.0)
    };
    radii.iter().enumerate().map(corner).collect()
}

/// Makes rings in random planes, some with holes, some far away; all are at least weakly simple.
fn rings() -> impl Strategy<Value = Vec<DVec3>> {
    let radii = |n| prop::collection::vec(0.5..1.0f64, n);
    let turn = prop::array::uniform4(0.1..1.0f64);
    (radii(3..14), radii(3..8), radii(3..8), 0..3usize, turn, prop::bool::ANY).prop_map(
        |(outer, first, second, holes, turn, far)| {
            let outer = star(&outer, DVec2::ZERO, 10.0);
            // A star with three corners may miss its centre's surroundings by little; holes are small.
            let holes = [star(&first, DVec2::new(0.4, 0.3), 0.3), star(&second, DVec2::new(-0.5, -0.2), 0.4)]
                [..holes]
                .to_vec();
            let ring = bridge_holes(&outer, &holes).swap_remove(0);
            let rotation = DQuat::from_array(turn).normalize();
            let origin = if far { DVec3::new(5e6, -5e6, 300.0) } else { DVec3::ZERO };
            ring.into_iter().map(|p| rotation * p + origin).collect()
        },
    )
}

/// Returns true when a point is inside the flattened ring by the even-odd rule.
fn even_odd(ring: &[DVec3], at: DVec2) -> bool {
    let n = ring.len();
    let met = |i: &usize| {
        let (a, b) = (ring[*i].truncate(), ring[(i + 1) % n].truncate());
        (a.y > at.y) != (b.y > at.y) && ((b - a).perp_dot(at - a) > 0.0) == (b.y > a.y)
    };
    (0..n).filter(met).count() % 2 == 1
}

fn contains([a, b, c]: [DVec3; 3], at: DVec2) -> bool {
    let side = |a: DVec3, b: DVec3| (b - a).truncate().perp_dot(at - a.truncate());
    let sides = [side(a, b), side(b, c), side(c, a)];
    sides.iter().all(|&s| s > 0.0) || sides.iter().all(|&s| s < 0.0)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..Default::default() })]

    #[test]
    fn triangles_fill_their_ring(ring in rings()) {
        check_triangles(&ring)?;
    }

    #[test]
    fn cut_pieces_add_up_and_keep_to_their_side(
        ring in rings(),
        normal in prop::array::uniform3(-1.0..1.0f64),
        through in 0..100usize,
        shift in prop_oneof![Just(0.0), -5.0..5.0f64],
    ) {
        let normal = DVec3::from_array(normal).try_normalize().unwrap_or(DVec3::X);
        let plane = Plane { normal, point: ring[through % ring.len()] + normal * shift };
        let (front, back) = split_by_plane(&ring, &plane);
        let whole = newell_normal(&ring);
        let sum: DVec3 = front.iter().chain(&back).map(|r| newell_normal(r)).sum();
        prop_assert!((sum - whole).length() < 1e-6 * whole.length(), "{} {}", sum, whole);
        for (pieces, sign) in [(&front, 1.0), (&back, -1.0)] {
            for piece in pieces {
                prop_assert!(newell_normal(piece).dot(whole) > 0.0, "wound like the face: {:?}", piece);
                prop_assert!(piece.iter().all(|&p| sign * plane.signed_distance(p) > -1e-7));
                for p in piece {
                    prop_assert!(ring.contains(p) || plane.signed_distance(*p).abs() < 1e-7);
                }
                if area(piece) > 1e-6 * whole.length() {
                    let t = triangles_of(piece);
                    prop_assert_ne!(t.flaw, Some(OutlineFlaw::SelfCrossing), "{:?}", piece);
                    prop_assert!(!t.triangles.is_empty());
                }
            }
        }
    }

    #[test]
    fn scribbles_are_filled_by_the_even_odd_rule(
        points in prop::collection::vec((-50..50i32, -50..50i32), 3..18),
        probes in prop::collection::vec((-50.0..50.0f64, -50.0..50.0f64), 40),
    ) {
        // Whole coordinates make touching corners, edges upon edges and triple crossings common.
        let ring: Vec<DVec3> = points.iter().map(|&(x, y)| DVec3::new(x.into(), y.into(), 0.0)).collect();
        let plane = Plane { normal: DVec3::Z, point: ring[0] };
        let t = triangulate(&ring, &plane);
        if !matches!(t.flaw, Some(OutlineFlaw::NoArea | OutlineFlaw::Tangled | OutlineFlaw::TooFewPoints)) {
            for (x, y) in probes {
                let hits = corners(&ring, &t).into_iter().filter(|&c| contains(c, DVec2::new(x, y))).count();
                prop_assert_eq!(hits, usize::from(even_odd(&ring, DVec2::new(x, y))), "at {} {}", x, y);
            }
        }
    }

    #[test]
    fn nothing_panics_on_any_numbers(
        points in prop::collection::vec(prop::array::uniform3(prop::num::f64::ANY), 0..9),
    ) {
        let ring: Vec<DVec3> = points.into_iter().map(DVec3::from_array).collect();
        let plane = fit_plane(&ring).unwrap_or(Plane { normal: DVec3::Z, point: DVec3::ZERO });
        triangulate(&ring, &plane);
        split_by_plane(&ring, &plane);
    }
}
