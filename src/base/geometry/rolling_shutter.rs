//! The motion of a camera whose sensor is read row by row while it moves.

use glam::{DMat3, DQuat, DVec2, DVec3};

/// How a camera moved while it took a photo. With the time `tau` from -1 at the first row to 1 at the last one, a point P of the
/// camera's frame at the middle row is at `exp(tau rotation) (P - tau motion)` in the frame of a row. The convention is Metashape's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RollingShutter {
    /// The rotation, as an axis times an angle in radians.
    pub rotation: DVec3,
    /// The motion in the camera's frame, in world units.
    pub motion: DVec3,
    /// The distance along the axis at which what the photo shows is taken to be, in world units, where nothing else is known.
    pub depth: f64,
}

/// The steps in which the row of a point is found; each gains the digits by which the motion is smaller than the photo.
const STEPS: usize = 30;

impl RollingShutter {
    /// Returns the time of a row of a photo with this height, both in pixels.
    fn time(row: f64, height: f64) -> f64 {
        2.0 * row / height - 1.0
    }

    fn turn(&self, time: f64) -> DMat3 {
        DMat3::from_quat(DQuat::from_scaled_axis(self.rotation * time))
    }

    /// Projects a point of the camera's frame at the middle row: `project` is the projection of a camera at rest to pixels of a
    /// photo with this height. `None` where it is, or where the row of the point cannot be found.
    pub fn image_of(
        &self,
        point: DVec3,
        height: f64,
        project: impl Fn(DVec3) -> Option<DVec2>,
    ) -> Option<DVec2> {
        let mut at = project(point)?;
        for _ in 0..STEPS {
            let time = Self::time(at.y, height);
            let next = project(self.turn(time) * (point - self.motion * time))?;
            let step = (next - at).length();
            at = next;
            // Rounding in a photo of 65,535 pixels.
            if step < 1e-9 {
                return Some(at);
            }
        }
        None
    }

    /// Returns the ray (scaled to z = 1) in the camera's frame at the middle row through what a row shows along `ray` at
    /// [`RollingShutter::depth`]; `None` where that lies behind the camera. `row` and `height` are in pixels.
    pub fn ray_at_rest(&self, ray: DVec3, row: f64, height: f64) -> Option<DVec3> {
        let time = Self::time(row, height);
        let turned = self.turn(time).transpose() * ray;
        let moved = self.motion * time;
        let along = (self.depth - moved.z) / turned.z;
        let point = turned * along + moved;
        (turned.z > 0.0 && along > 0.0).then(|| point / point.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pinhole;

    const CAMERA: Pinhole = Pinhole { width: 640, height: 480, fx: 500.0, fy: 505.0, cx: 330.0, cy: 235.0 };

    #[test]
    fn the_row_at_which_a_point_appears_is_the_time_of_its_pose() {
        let shutter = RollingShutter {
            rotation: DVec3::new(0.01, -0.02, 0.005),
            motion: DVec3::new(0.1, 0.05, -0.02),
            depth: 8.0,
        };
        let point = DVec3::new(1.5, -2.0, 8.0);
        let at = shutter.image_of(point, 480.0, |point| CAMERA.image_from_camera(point)).unwrap();
        let time = 2.0 * at.y / 480.0 - 1.0;
        let turn = DMat3::from_quat(DQuat::from_scaled_axis(shutter.rotation * time));
        let expected = CAMERA.image_from_camera(turn * (point - shutter.motion * time)).unwrap();
        assert!(at.distance(expected) < 1e-7 && at.distance(CAMERA.image_from_camera(point).unwrap()) > 2.0);
        let back = shutter.ray_at_rest(CAMERA.ray_in_camera(at), at.y, 480.0).unwrap();
        assert!((back * 8.0).distance(point) < 1e-9, "{back}");
    }

    #[test]
    fn a_camera_at_rest_shows_what_its_pose_says() {
        let still = RollingShutter { rotation: DVec3::ZERO, motion: DVec3::ZERO, depth: 1.0 };
        let point = DVec3::new(0.5, 0.25, 2.0);
        let project = |point| CAMERA.image_from_camera(point);
        assert_eq!(still.image_of(point, 480.0, project), project(point));
        assert_eq!(still.ray_at_rest(DVec3::new(0.1, 0.2, 1.0), 7.0, 480.0), Some(DVec3::new(0.1, 0.2, 1.0)));
        assert_eq!(still.ray_at_rest(-DVec3::Z, 7.0, 480.0), None);
    }
}
