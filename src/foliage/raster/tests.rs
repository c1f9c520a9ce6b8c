//! Tests of masks against a plain test of each sub-pixel, and in closed form.

use glam::{DVec2, DVec3};

use super::*;
use quadratura_base::scene::synthetic::Rng;

const BOUNDS: PixelRect = PixelRect { x: 0, y: 0, w: 24, h: 16 };

fn corners(points: [DVec2; 3], nearness: [f64; 3]) -> [ImageCorner; 3] {
    std::array::from_fn(|i| ImageCorner::new(points[i], nearness[i]).unwrap())
}

fn fragments(perspective: bool, corners: [ImageCorner; 3]) -> Vec<Fragment> {
    let mut all = Vec::new();
    rasterise(&Target { bounds: BOUNDS, perspective }, corners, None, |fragment| all.push(fragment.clone()));
    all
}

/// The middle of a sub-pixel.
fn middle(x: i32, y: i32, bit: usize) -> DVec2 {
    let [column, row] = [bit % 4, bit / 4].map(|b| (b as f64 + 0.5) / 4.0);
    DVec2::new(f64::from(x) + column, f64::from(y) + row)
}

/// Three points on the grid of corners, so that rounding changes none.
fn any_points(rng: &mut Rng) -> [DVec2; 3] {
    let mut value = |most: f64| (rng.between(-6.0, most + 6.0) * 1024.0).round() / 1024.0;
    std::array::from_fn(|_| DVec2::new(value(24.0), value(16.0)))
}

/// Twice the area of a triangle, exact for points on the grid.
fn area(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

#[test]
fn a_mask_has_the_sub_pixels_whose_middles_are_in_the_triangle() {
    let mut rng = Rng::new(3);
    let mut covered = 0u32;
    for case in 0..3000 {
        let points @ [a, b, c] = any_points(&mut rng);
        let mut masks = vec![0u16; BOUNDS.area() as usize];
        for fragment in fragments(case % 2 == 0, corners(points, [1.0, 2.0, 3.0])) {
            let mask = &mut masks[BOUNDS.offset(fragment.x, fragment.y)];
            assert!(*mask == 0 && fragment.mask != 0, "a pixel has one fragment");
            *mask = fragment.mask;
        }
        for ((x, y), mask) in BOUNDS.pixels().zip(masks) {
            covered += mask.count_ones();
            for bit in 0..16 {
                let p = middle(x, y, bit);
                let sides = [area(a, b, p), area(b, c, p), area(c, a, p)];
                let (least, most) =
                    sides.iter().fold((f64::MAX, f64::MIN), |(l, m), s| (l.min(*s), m.max(*s)));
                // On an edge either of two neighbours may have it, which the next test is about.
                if least != 0.0 && most != 0.0 {
                    let inside = least > 0.0 || most < 0.0;
                    assert_eq!(mask >> bit & 1 == 1, inside, "case {case}: {points:?} at {p}");
                }
            }
        }
    }
    assert!(covered > 100_000, "the triangles cover something: {covered}");
}

#[test]
fn triangles_around_a_point_cover_each_sub_pixel_once_even_where_edges_meet_middles() {
    let mut rng = Rng::new(5);
    for case in 0..500 {
        // Middles of sub-pixels are odd multiples of 1/8; half of the cases have all corners on such.
        let step = if case % 2 == 0 { 4.0 } else { 1024.0 };
        let mut on_grid = |low: f64, high: f64| (rng.between(low, high) * step).round() / step + 0.125;
        let hub = DVec2::new(on_grid(2.0, 20.0), on_grid(2.0, 13.0));
        let rim = [(0.0, 0.0), (23.0, 0.0), (23.0, 15.0), (0.0, 15.0)].map(|(x, y)| DVec2::new(x, y) + 0.125);
        let mut counts = [0u32; 24 * 16 * 16];
        for i in 0..4 {
            let points =
                if i % 2 == 0 { [hub, rim[i], rim[(i + 1) % 4]] } else { [rim[(i + 1) % 4], rim[i], hub] };
            for fragment in fragments(false, corners(points, [1.0; 3])) {
                let first = 16 * BOUNDS.offset(fragment.x, fragment.y);
                (0..16).filter(|bit| fragment.mask >> bit & 1 == 1).for_each(|bit| counts[first + bit] += 1);
            }
        }
        for ((x, y), counts) in BOUNDS.pixels().zip(counts.as_chunks::<16>().0) {
            for (bit, count) in counts.iter().enumerate() {
                let p = middle(x, y, bit) - 0.125;
                let inside = p.cmpgt(DVec2::ZERO).all() && p.cmplt(DVec2::new(23.0, 15.0)).all();
                assert!(*count <= 1 && (*count == 1 || !inside), "case {case}: {count} at {p}");
            }
        }
    }
}

#[test]
fn depths_and_weights_are_those_of_the_plane_with_and_without_perspective() {
    let mut rng = Rng::new(8);
    for case in 0..500 {
        let points = any_points(&mut rng);
        let depths: [f64; 3] = std::array::from_fn(|_| rng.between(1.0, 9.0));
        let perspective = case % 2 == 0;
        let near = depths.map(|z| if perspective { z.recip() } else { -z });
        let in_space = |i: usize| if perspective { points[i] * depths[i] } else { points[i] };
        for fragment in fragments(perspective, corners(points, near)) {
            let w = fragment.weights;
            // The point with these weights on the triangle in space has its image in the middle of what is covered.
            let (x, z) =
                (0..3).fold((DVec2::ZERO, 0.0), |(x, z), i| (x + w[i] * in_space(i), z + w[i] * depths[i]));
            let image = if perspective { x / z } else { x };
            let bits = (0..16).filter(|bit| fragment.mask >> bit & 1 == 1);
            let centre = bits.clone().map(|bit| middle(fragment.x, fragment.y, bit)).sum::<DVec2>()
                / f64::from(fragment.mask.count_ones());
            // Rounding of weights, which slivers magnify.
            assert!((w.element_sum() - 1.0).abs() < 1e-9 && image.distance(centre) < 1e-6, "case {case}");
            let depth = if perspective { fragment.middle.recip() } else { -fragment.middle };
            assert!((depth - z).abs() < 1e-6);
            let range = |low: f64, value: f64, high: f64| value >= low - 1e-6 && value <= high + 1e-6;
            let (low, high) = near.iter().fold((f64::MAX, f64::MIN), |(l, h), n| (l.min(*n), h.max(*n)));
            assert!(bits.into_iter().all(|bit| range(low, f64::from(fragment.nearness[bit]), high)));
        }
    }
}

#[test]
fn holes_are_looked_up_at_each_covered_sub_pixel() {
    let points = [DVec2::new(0.0, 0.0), DVec2::new(8.0, 0.0), DVec2::new(0.0, 8.0)];
    let mut kept = Vec::new();
    // What is left of x = 1 stays: the first weight is 1 - x/8 - y/8, the third y/8.
    let keeps = |w: DVec3| 8.0 * w.y < 1.0;
    let target = Target { bounds: BOUNDS, perspective: false };
    rasterise(&target, corners(points, [1.0; 3]), Some(&keeps), |fragment| kept.push(fragment.clone()));
    assert_eq!(
        kept.iter().map(|f| (f.x, f.y)).collect::<Vec<_>>(),
        (0..8).map(|y| (0, y)).collect::<Vec<_>>()
    );
    assert!(kept[..7].iter().all(|fragment| fragment.mask == 0xffff));
    let all = |_: DVec3| false;
    rasterise(&target, corners(points, [1.0; 3]), Some(&all), |_| panic!("everything is a hole"));
}

#[test]
fn what_has_no_area_or_is_out_of_the_bounds_or_too_far_away_has_no_fragments() {
    let line = [DVec2::new(1.0, 1.0), DVec2::new(5.0, 5.0), DVec2::new(9.0, 9.0)];
    assert!(fragments(true, corners(line, [1.0; 3])).is_empty());
    let beside = [DVec2::new(-9.0, 1.0), DVec2::new(-1.0, 5.0), DVec2::new(-5.0, 9.0)];
    assert!(fragments(true, corners(beside, [1.0; 3])).is_empty());
    assert!(ImageCorner::new(DVec2::new(REACH_PX * 1.01, 0.0), 1.0).is_none());
    assert!(ImageCorner::new(DVec2::new(f64::NAN, 0.0), 1.0).is_none());
    // As large as can be: edges still fit into integers.
    let large =
        [DVec2::new(-REACH_PX, -REACH_PX), DVec2::new(REACH_PX, -REACH_PX), DVec2::new(0.0, REACH_PX)];
    let all = fragments(true, corners(large, [1.0; 3]));
    assert!(all.len() == 24 * 16 && all.iter().all(|fragment| fragment.mask == 0xffff));
}

#[test]
fn the_shares_of_a_triangle_in_pixels_sum_to_all_of_it() {
    let points = [DVec2::new(1.5, 1.0), DVec2::new(22.0, 4.0), DVec2::new(6.0, 15.0)];
    for (perspective, nearness) in [(false, [3.0, 1.0, 2.0]), (true, [1.0; 3]), (true, [1.0, 0.7, 0.4])] {
        let corners = corners(points, nearness);
        let share = |fragment: &Fragment| {
            let covered = f64::from(fragment.mask.count_ones()) / 16.0;
            covered * share_in_pixel(perspective, &corners, fragment.middle)
        };
        let sum: f64 = fragments(perspective, corners).iter().map(share).sum();
        // Sub-pixels on the border count as whole ones or not at all.
        assert!((sum - 1.0).abs() < 0.02, "{perspective} {nearness:?}: {sum}");
    }
}
