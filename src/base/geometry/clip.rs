//! Clipping of polygons and segments in a camera's frame to a box of its image.

use glam::{DVec2, DVec3};

use super::Pinhole;

/// Clips a polygon (camera frame) to what projects into the box `low_px..high_px`; the result is empty where
/// nothing does. Parts behind the camera are removed without a near plane: the box's sides are half spaces through
/// the camera centre, applied one after the other (Sutherland and Hodgman 1974). Parts of a concave polygon may
/// stay connected by edges along the box.
pub fn clipped_to_box(polygon: &[DVec3], camera: &Pinhole, low_px: DVec2, high_px: DVec2) -> Vec<DVec3> {
    sides(camera, low_px, high_px).iter().fold(polygon.to_vec(), |polygon, side| clipped_by(&polygon, *side))
}

/// Clips a segment (camera frame) to what projects into the box `low_px..high_px`; `None` where nothing does. Both
/// ends of the result are in front of the camera.
pub fn segment_in_box(
    ends: [DVec3; 2],
    camera: &Pinhole,
    low_px: DVec2,
    high_px: DVec2,
) -> Option<[DVec3; 2]> {
    let [from, to] = ends;
    // A rounding error in front of the camera: the apex of the four half spaces would count as inside otherwise.
    let least = 1e-9 * from.distance(to);
    let ahead = |p: DVec3| p.z - least;
    let distances = sides(camera, low_px, high_px).map(|side| [side.dot(from), side.dot(to)]);
    let (mut enter, mut leave) = (0.0f64, 1.0f64);
    for [at_from, at_to] in distances.into_iter().chain([[ahead(from), ahead(to)]]) {
        let crossing = at_from / (at_from - at_to);
        match (at_from >= 0.0, at_to >= 0.0) {
            (true, true) => (),
            (false, false) => return None,
            (true, false) => leave = leave.min(crossing),
            (false, true) => enter = enter.max(crossing),
        }
    }
    (enter < leave).then(|| [from.lerp(to, enter), from.lerp(to, leave)])
}

/// Returns the four half spaces through the camera centre that project into a box: `side . p >= 0`.
fn sides(camera: &Pinhole, low_px: DVec2, high_px: DVec2) -> [DVec3; 4] {
    [
        DVec3::new(camera.fx, 0.0, camera.cx - low_px.x),
        DVec3::new(-camera.fx, 0.0, high_px.x - camera.cx),
        DVec3::new(0.0, camera.fy, camera.cy - low_px.y),
        DVec3::new(0.0, -camera.fy, high_px.y - camera.cy),
    ]
}

/// Clips a polygon to the half space `side . p >= 0`.
fn clipped_by(polygon: &[DVec3], side: DVec3) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, &p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (dp, dq) = (side.dot(p), side.dot(q));
        if dp >= 0.0 {
            kept.push(p);
        }
        if (dp > 0.0 && dq < 0.0) || (dp < 0.0 && dq > 0.0) {
            kept.push(p + (q - p) * (dp / (dp - dq)));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAMERA: Pinhole = Pinhole { width: 100, height: 80, fx: 50.0, fy: 40.0, cx: 45.0, cy: 30.0 };

    #[test]
    fn a_polygon_larger_than_the_box_is_cut_to_its_corners() {
        let wall = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)].map(|(x, y)| DVec3::new(x, y, 2.0));
        let (low, high) = (DVec2::new(10.0, 20.0), DVec2::new(30.0, 50.0));
        let clipped = clipped_to_box(&wall, &CAMERA, low, high);
        let px: Vec<DVec2> = clipped.iter().map(|p| CAMERA.image_from_camera(*p).unwrap()).collect();
        for corner in [low, high, DVec2::new(low.x, high.y), DVec2::new(high.x, low.y)] {
            assert!(px.iter().any(|p| p.distance(corner) < 1e-9), "{corner} is not in {px:?}");
        }
        assert_eq!(px.len(), 4);
    }

    #[test]
    fn of_a_ground_that_reaches_behind_the_camera_only_what_is_in_front_is_left() {
        let ground = [(-5.0, -7.0), (5.0, -7.0), (5.0, 7.0), (-5.0, 7.0)].map(|(x, z)| DVec3::new(x, 1.0, z));
        let clipped = clipped_to_box(&ground, &CAMERA, DVec2::ZERO, DVec2::new(100.0, 80.0));
        assert!(clipped.len() >= 3 && clipped.iter().all(|p| p.z > 0.0), "{clipped:?}");
        let behind = ground.map(|p| p - DVec3::Z * 20.0);
        assert!(clipped_to_box(&behind, &CAMERA, DVec2::ZERO, DVec2::new(100.0, 80.0)).is_empty());
    }

    #[test]
    fn of_a_segment_that_passes_the_camera_what_the_box_shows_is_left() {
        let (low, high) = (DVec2::ZERO, DVec2::new(100.0, 80.0));
        let inside = |ends| segment_in_box(ends, &CAMERA, low, high);
        let px = |p: DVec3| CAMERA.image_from_camera(p).unwrap();
        let across = inside([DVec3::new(-9.0, 0.0, 2.0), DVec3::new(9.0, 0.0, 2.0)]).unwrap();
        assert!(px(across[0]).distance(DVec2::new(0.0, 30.0)) < 1e-9, "{across:?}");
        assert!(px(across[1]).distance(DVec2::new(100.0, 30.0)) < 1e-9, "{across:?}");
        let along = inside([DVec3::new(0.0, 1.0, -5.0), DVec3::new(0.0, 1.0, 5.0)]).unwrap();
        assert!(px(along[0]).distance(DVec2::new(45.0, 80.0)) < 1e-9, "{along:?}");
        assert_eq!(along[1].z, 5.0);
        assert!(inside([DVec3::new(0.0, 0.0, -5.0), DVec3::new(0.0, 0.0, -1.0)]).is_none(), "behind");
        assert!(inside([DVec3::new(9.0, 0.0, 2.0), DVec3::new(9.0, 1.0, 2.0)]).is_none(), "beside");
    }
}
