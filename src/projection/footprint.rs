//! The pixels of a photo that a flat surface covers: those whose centres lie within its projected outline.
//! This runs on the CPU, for a few surfaces at a time; the passes of the visibility sort do the same for all
//! of them.

use glam::{DVec2, DVec3};

use quadratura_base::geometry::clip::clipped_to_box;
use quadratura_base::geometry::spans::{ColumnRun, Spans};
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};

/// Computes the pixels within `area` (photo pixels; it may reach outside the photo) that a polygon covers.
/// `outline` is one ring in world coordinates, simple or weakly simple: holes are bridged by doubled edges,
/// which cancel out under the even-odd rule. A pixel centre on the common edge of two polygons belongs to one
/// of them only.
pub fn footprint(outline: &[DVec3], camera: &Pinhole, pose: &Pose, area: PixelRect) -> Spans {
    let in_camera: Vec<DVec3> = outline.iter().map(|&p| pose.camera_from_world(p)).collect();
    let low = DVec2::new(f64::from(area.x), f64::from(area.y));
    let high = DVec2::new(f64::from(area.right()), f64::from(area.bottom()));
    let clipped = clipped_to_box(&in_camera, camera, low, high);
    let ring: Vec<DVec2> = clipped.iter().filter_map(|&p| camera.image_from_camera(p)).collect();
    covered(&ring, area)
}

/// Computes the pixels of `area` whose centres lie within a ring (pixel coordinates), by the even-odd rule.
fn covered(ring: &[DVec2], area: PixelRect) -> Spans {
    let edges: Vec<(DVec2, DVec2)> = ring
        .iter()
        .zip(ring.iter().cycle().skip(1))
        .map(|(&a, &b)| if a.y <= b.y { (a, b) } else { (b, a) })
        .filter(|(a, b)| a.y < b.y)
        .collect();
    let Some(rows) = rows_of(&edges, area) else { return Spans::default() };
    let mut crossings: Vec<f64> = Vec::new();
    Spans::from_rows(rows, |y, out| {
        let centre = f64::from(y) + 0.5;
        crossings.clear();
        // Edges are half open: a corner exactly on the line counts with the edge below it.
        let crossed = edges.iter().filter(|(a, b)| a.y <= centre && centre < b.y);
        crossings.extend(crossed.map(|(a, b)| a.x + (centre - a.y) * ((b.x - a.x) / (b.y - a.y))));
        crossings.sort_by(f64::total_cmp);
        for pair in crossings.as_chunks::<2>().0 {
            push(out, first_at(pair[0]).max(area.x)..first_at(pair[1]).min(area.right()));
        }
    })
}

fn rows_of(edges: &[(DVec2, DVec2)], area: PixelRect) -> Option<std::ops::Range<i32>> {
    let top = edges.iter().map(|(a, _)| a.y).reduce(f64::min)?;
    let bottom = edges.iter().map(|(_, b)| b.y).reduce(f64::max)?;
    let (top, bottom) = (first_at(top).max(area.y), first_at(bottom).min(area.bottom()));
    (top < bottom).then_some(top..bottom)
}

/// Returns the first pixel whose centre is at or after `edge`.
fn first_at(edge: f64) -> i32 {
    (edge - 0.5).ceil() as i32
}

fn push(out: &mut Vec<ColumnRun>, run: ColumnRun) {
    if !run.is_empty() {
        out.push(run);
    }
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;

    const AREA: PixelRect = PixelRect { x: -4, y: -4, w: 40, h: 30 };

    fn camera() -> (Pinhole, Pose) {
        let camera = Pinhole { width: 32, height: 24, fx: 10.0, fy: 10.0, cx: 16.0, cy: 12.0 };
        (camera, Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO })
    }

    /// Converts a ring of image positions to points one metre away.
    fn at_one_metre(ring: &[(f64, f64)]) -> Vec<DVec3> {
        ring.iter().map(|(x, y)| DVec3::new((x - 16.0) / 10.0, (y - 12.0) / 10.0, 1.0)).collect()
    }

    fn of(ring: &[(f64, f64)]) -> Spans {
        let (camera, pose) = camera();
        footprint(&at_one_metre(ring), &camera, &pose, AREA)
    }

    #[test]
    fn a_rectangle_covers_the_pixels_whose_centres_it_holds() {
        let spans = of(&[(2.4, 3.0), (9.6, 3.0), (9.6, 7.4), (2.4, 7.4)]);
        assert_eq!(spans.bounds(), PixelRect { x: 2, y: 3, w: 8, h: 4 });
        assert_eq!(spans.count(), 32);
    }

    #[test]
    fn a_hole_that_is_bridged_is_not_covered() {
        let outer = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0), (0.0, 0.0)];
        let hole = [(3.0, 3.0), (3.0, 6.0), (6.0, 6.0), (6.0, 3.0), (3.0, 3.0)];
        let ring: Vec<_> = outer.into_iter().chain(hole).collect();
        let spans = of(&ring);
        assert_eq!(spans.count(), 100 - 9);
        assert_eq!(spans.row(4), [0..3, 6..10]);
    }

    #[test]
    fn two_halves_of_a_polygon_share_no_pixel_and_lose_none() {
        let cut = [(3.2, 0.0), (14.7, 20.0)];
        let left = of(&[(0.0, 0.0), cut[0], cut[1], (0.0, 20.0)]);
        let right = of(&[cut[0], (20.0, 0.0), (20.0, 20.0), cut[1]]);
        assert!(left.intersection(&right).is_empty());
        assert_eq!(left.count() + right.count(), 400);
    }

    #[test]
    fn of_a_floor_that_runs_behind_the_camera_the_part_in_front_is_covered_to_the_edge() {
        let (camera, pose) = camera();
        let floor =
            [(-50.0, -9.0), (50.0, -9.0), (50.0, 10.0), (-50.0, 10.0)].map(|(x, z)| DVec3::new(x, 1.0, z));
        let spans = footprint(&floor, &camera, &pose, AREA);
        // The far edge is at y = 12 + 10 / 10 = 13.
        assert_eq!(spans.bounds(), PixelRect { x: -4, y: 13, w: 40, h: 13 });
        assert_eq!(spans.count(), 40 * 13);
        let behind = floor.map(|p| p - DVec3::Z * 20.0);
        assert!(footprint(&behind, &camera, &pose, AREA).is_empty());
    }
}
