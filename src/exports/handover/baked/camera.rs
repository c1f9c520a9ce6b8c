//! The view of a chart: from straight in front, as good as from infinitely far away.

use glam::{DMat3, DVec2, DVec3};

use super::parts::middle_of;
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};
use quadratura_handover::atlas::chart::Chart;

/// The distance of the viewpoint, in longer sides of the chart: directions to it differ by 0.3 degrees at most from the normal, and
/// f32 still places texels to a hundredth.
const DISTANCE: f64 = 100.0;

/// Returns camera and pose that see the part `part` of a chart's texels, of which pixel (0, 0) is at its upper left corner. A pinhole that
/// looks straight at a plane shows it without perspective.
pub(super) fn camera_of_chart(chart: &Chart, density: f64, part: PixelRect) -> (Pinhole, Pose) {
    let frame = middle_of(chart);
    let normal = frame.u.cross(frame.v);
    let distance = DISTANCE * chart.size().max_element();
    let eye = frame.origin + normal * distance;
    let rotation = DMat3::from_cols(frame.u, -frame.v, -normal).transpose();
    let pose = Pose { rotation, translation: -(rotation * eye) };
    let middle: DVec2 = 0.5 * chart.size() * density;
    let (fx, fy) = (density * distance, density * distance);
    let (cx, cy) = (middle.x - f64::from(part.x), middle.y - f64::from(part.y));
    (Pinhole { width: part.w, height: part.h, fx, fy, cx, cy }, pose)
}

/// Returns where a point of the world is in the texels of a chart.
pub(super) fn texel_of(chart: &Chart, density: f64, point: DVec3) -> DVec2 {
    let place = chart.frame.flat(point);
    DVec2::new(place.x - chart.low.x, chart.high.y - place.y) * density
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::geometry::polygon::fit_plane;
    use quadratura_handover::atlas::chart::{ChartFace, charts};

    #[test]
    fn the_camera_sees_points_of_the_plane_where_the_chart_has_them() {
        let far = DVec3::new(500.0, -300.0, 20.0);
        let corners = [[0., 0., 0.], [4., 3., 0.], [4., 3., 7.], [0., 0., 5.]];
        let ring: Vec<DVec3> = corners.map(|corner| far + DVec3::from(corner)).to_vec();
        let plane = fit_plane(&ring).unwrap();
        let chart = &charts(&[ChartFace { ring: ring.clone(), plane, group: 0 }], DVec3::Z)[0];
        let part = PixelRect { x: 64, y: 32, w: 512, h: 300 };
        let (camera, pose) = camera_of_chart(chart, 80.0, part);
        for point in ring {
            let seen = camera.image_from_camera(pose.camera_from_world(point)).unwrap();
            let texel = texel_of(chart, 80.0, point) - DVec2::new(64.0, 32.0);
            assert!((seen - texel).length() < 1e-6, "{seen} and {texel}");
        }
    }
}
