//! Freehand shapes as pixel sets: the stroke of a round brush and the area that a lasso encloses. A pixel belongs
//! to a shape when its centre does. Coordinates are in pixels of the picture, with (0, 0) its top-left corner.

use glam::DVec2;

use super::{PixelRect, Spans};

/// Returns the pixels of `within` at most `radius_px` away from a polyline; a line of one point gives a disc.
pub fn brushed(line: &[DVec2], radius_px: f64, within: PixelRect) -> Spans {
    match line {
        [] => Spans::default(),
        [alone] => swept([*alone, *alone], radius_px, within),
        line => line.windows(2).fold(Spans::default(), |brushed, ends| {
            brushed.union(&swept([ends[0], ends[1]], radius_px, within))
        }),
    }
}

/// Returns the pixels that a disc covers while it moves along a segment. The shape is convex, so each row has one
/// run.
fn swept(ends: [DVec2; 2], radius_px: f64, within: PixelRect) -> Spans {
    let low = ends[0].y.min(ends[1].y) - radius_px;
    let high = ends[0].y.max(ends[1].y) + radius_px;
    let rows = first_centre(low).max(within.y)..(first_centre(high) + 1).min(within.bottom());
    Spans::from_rows(rows.start..rows.end.max(rows.start), |y, out| {
        if let Some([left, right]) = reach(ends, radius_px, f64::from(y) + 0.5) {
            let run = first_centre(left).max(within.x)..(last_centre(right) + 1).min(within.right());
            out.push(run);
        }
    })
}

/// Returns the leftmost and rightmost x of the swept disc at height `y`: the extremes over the discs at both ends
/// and the rectangle between them; `None` where the shape does not reach `y`.
fn reach(ends: [DVec2; 2], radius_px: f64, y: f64) -> Option<[f64; 2]> {
    let across = (ends[1] - ends[0]).normalize_or_zero().perp() * radius_px;
    let corners = [ends[0] + across, ends[1] + across, ends[1] - across, ends[0] - across];
    let discs = ends.into_iter().flat_map(|middle| {
        let half = (radius_px * radius_px - (y - middle.y) * (y - middle.y)).max(-1.0);
        let half = (half >= 0.0).then(|| half.sqrt());
        half.into_iter().flat_map(move |half| [middle.x - half, middle.x + half])
    });
    let sides = (0..4).filter_map(|at| {
        let (from, to) = (corners[at], corners[(at + 1) % 4]);
        let passes = (from.y <= y) != (to.y <= y);
        passes.then(|| from.x + (y - from.y) / (to.y - from.y) * (to.x - from.x))
    });
    discs.chain(sides).fold(None, |reach, x| {
        let [left, right] = reach.unwrap_or([x, x]);
        Some([f64::min(left, x), f64::max(right, x)])
    })
}

/// Returns the pixels of `within` that a closed line encloses, by the nonzero rule: a lasso that crosses itself
/// near its start, or that runs around twice, still selects all of its inside.
pub fn enclosed(line: &[DVec2], within: PixelRect) -> Spans {
    let mut crossings: Vec<Vec<(f64, i32)>> = vec![Vec::new(); within.h as usize];
    for (at, from) in line.iter().enumerate() {
        let to = line[(at + 1) % line.len()];
        let (upper, lower, turn) = if from.y <= to.y { (*from, to, 1) } else { (to, *from, -1) };
        let rows = first_centre(upper.y).max(within.y)..first_centre(lower.y).min(within.bottom());
        for y in rows {
            let share = (f64::from(y) + 0.5 - upper.y) / (lower.y - upper.y);
            crossings[(y - within.y) as usize].push((upper.x + share * (lower.x - upper.x), turn));
        }
    }
    Spans::from_rows(within.y..within.bottom(), |y, out| {
        let row = &mut crossings[(y - within.y) as usize];
        row.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut turns = 0;
        for pair in row.windows(2) {
            turns += pair[0].1;
            if turns != 0 {
                let run = first_centre(pair[0].0)..first_centre(pair[1].0);
                out.push(run.start.max(within.x)..run.end.min(within.right()));
            }
        }
    })
}

/// Returns the first pixel whose centre is at or after `x`.
fn first_centre(x: f64) -> i32 {
    (x - 0.5).ceil() as i32
}

/// Returns the last pixel whose centre is at or before `x`.
fn last_centre(x: f64) -> i32 {
    (x - 0.5).floor() as i32
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::scene::synthetic::Rng;

    const PICTURE: PixelRect = PixelRect::of_size(400, 300);

    fn point(rng: &mut Rng) -> DVec2 {
        DVec2::new(rng.between(60.0, 340.0), rng.between(60.0, 240.0))
    }

    fn distance(ends: [DVec2; 2], point: DVec2) -> f64 {
        let along = ends[1] - ends[0];
        let share = ((point - ends[0]).dot(along) / along.length_squared().max(1e-300)).clamp(0.0, 1.0);
        point.distance(ends[0] + along * share)
    }

    #[test]
    fn a_brush_covers_the_pixels_whose_centres_it_reaches_and_no_other() {
        let mut rng = Rng::new(5);
        for _ in 0..20 {
            let ends = [point(&mut rng), point(&mut rng)];
            let radius = rng.between(0.4, 50.0);
            let drawn = brushed(&ends, radius, PICTURE);
            let close = Spans::of_pixels(PICTURE, |x, y| {
                distance(ends, DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)) <= radius
            });
            // Rounding decides for centres exactly on the rim.
            let differing = drawn.minus(&close).count() + close.minus(&drawn).count();
            assert!(differing <= 1, "{ends:?}, {radius}: {differing}");
        }
    }

    #[test]
    fn the_area_of_a_stroke_is_that_of_its_disc_and_its_way() {
        let ends = [DVec2::new(80.3, 90.7), DVec2::new(300.0, 200.0)];
        let (radius, length) = (31.0, ends[0].distance(ends[1]));
        let drawn = brushed(&ends, radius, PICTURE).count() as f64;
        let exact = PI * radius * radius + 2.0 * radius * length;
        // Centres on a rim are in or out by chance: the error is about the root of the rim's length, rarely three
        // times that.
        let rim = 2.0 * PI * radius + 2.0 * length;
        assert!((drawn - exact).abs() < 3.0 * rim.sqrt(), "{drawn}, {exact}");
    }

    #[test]
    fn a_dab_of_less_than_a_pixel_draws_the_pixel_under_it() {
        let drawn = brushed(&[DVec2::new(17.4, 9.6)], 0.5, PICTURE);
        assert!(drawn.count() == 1 && drawn.holds(17, 9));
        assert!(brushed(&[], 9.0, PICTURE).is_empty());
    }

    #[test]
    fn what_is_drawn_ends_at_the_pictures_border() {
        let outside = [DVec2::new(-90.0, 20.0), DVec2::new(30.0, -70.0), DVec2::new(500.0, 400.0)];
        for drawn in [brushed(&outside, 60.0, PICTURE), enclosed(&outside, PICTURE)] {
            assert!(!drawn.is_empty());
            assert_eq!(drawn.bounds().intersection(&PICTURE), drawn.bounds());
        }
        assert!(brushed(&[DVec2::new(900.0, 900.0)], 9.0, PICTURE).is_empty());
    }

    #[test]
    fn a_lasso_holds_the_area_of_its_polygon() {
        let corners = 97;
        let corner = |at: i32| DVec2::from_angle(2.0 * PI * f64::from(at) / f64::from(corners));
        let ring: Vec<DVec2> = (0..corners).map(|at| DVec2::new(200.2, 150.9) + 90.0 * corner(at)).collect();
        let exact = 0.5 * f64::from(corners) * 8100.0 * (2.0 * PI / f64::from(corners)).sin();
        let drawn = enclosed(&ring, PICTURE).count() as f64;
        assert!((drawn - exact).abs() < 3.0 * (2.0 * PI * 90.0_f64).sqrt(), "{drawn}, {exact}");
        let mut reversed = ring.clone();
        reversed.reverse();
        assert_eq!(enclosed(&reversed, PICTURE), enclosed(&ring, PICTURE));
    }

    #[test]
    fn a_lasso_that_goes_around_twice_or_crosses_its_beginning_has_no_hole() {
        let square = |by: f64| {
            [(40.0, 40.0), (90.0, 40.0), (90.0, 90.0), (40.0, 90.0)]
                .map(|(x, y)| DVec2::new(x + by, y + by))
                .to_vec()
        };
        let (first, second) = (square(0.0), square(20.0));
        let twice: Vec<DVec2> =
            first.iter().chain(&first[..1]).chain(&second).chain(&second[..1]).copied().collect();
        let both = enclosed(&first, PICTURE).union(&enclosed(&second, PICTURE));
        let drawn = enclosed(&twice, PICTURE);
        assert!(both.minus(&drawn).is_empty());
        assert!(drawn.holds(75, 75), "where both are");
        assert_eq!(enclosed(&first, PICTURE).count(), 2500);
        assert!(enclosed(&first[..2], PICTURE).is_empty() && enclosed(&[], PICTURE).is_empty());
    }
}
