//! The pinhole camera that every photo has from import on, and its pose.

use glam::{DMat3, DVec2, DVec3};

use super::PixelRect;

/// A pinhole camera without distortion. Units: pixels; pixel (0,0) is the top-left pixel and its
/// centre is (0.5, 0.5) (COLMAP's convention); x right, y down, z forward.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pinhole {
    /// Size of the photo in pixels.
    pub width: u32,
    /// Size of the photo in pixels.
    pub height: u32,
    /// Focal lengths in pixels.
    pub fx: f64,
    /// Focal lengths in pixels.
    pub fy: f64,
    /// Principal point in pixels, from the corner of the top-left pixel.
    pub cx: f64,
    /// Principal point in pixels, from the corner of the top-left pixel.
    pub cy: f64,
}

impl Pinhole {
    /// All pixels of the photo.
    pub fn rect(&self) -> PixelRect {
        PixelRect::of_size(self.width, self.height)
    }

    /// Pixel coordinates of a point in the camera frame; `None` where it is not in front (z <= 0).
    pub fn image_from_camera(&self, point_in_camera: DVec3) -> Option<DVec2> {
        let DVec3 { x, y, z } = point_in_camera;
        (z > 0.0).then(|| DVec2::new(self.fx * x / z + self.cx, self.fy * y / z + self.cy))
    }

    /// The ray through an image point, in the camera frame, scaled to z = 1.
    pub fn ray_in_camera(&self, point_px: DVec2) -> DVec3 {
        DVec3::new((point_px.x - self.cx) / self.fx, (point_px.y - self.cy) / self.fy, 1.0)
    }

    /// K, in the usual row order `[[fx,0,cx],[0,fy,cy],[0,0,1]]`.
    pub fn matrix_rows(&self) -> [[f64; 3]; 3] {
        [[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]]
    }
}

/// World to camera: `point_in_camera = rotation * point_in_world + translation`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// R, orthonormal with determinant 1.
    pub rotation: DMat3,
    /// t.
    pub translation: DVec3,
}

impl Pose {
    /// Takes a world point into the camera frame.
    pub fn camera_from_world(&self, point_in_world: DVec3) -> DVec3 {
        self.rotation * point_in_world + self.translation
    }

    /// Takes a camera-frame point into the world.
    pub fn world_from_camera(&self, point_in_camera: DVec3) -> DVec3 {
        self.rotation.transpose() * (point_in_camera - self.translation)
    }

    /// Where the camera stands, in the world: C = -R^T t.
    pub fn center_in_world(&self) -> DVec3 {
        -(self.rotation.transpose() * self.translation)
    }

    /// R, in row order.
    pub fn rotation_rows(&self) -> [[f64; 3]; 3] {
        let rows = self.rotation.transpose();
        [rows.x_axis.to_array(), rows.y_axis.to_array(), rows.z_axis.to_array()]
    }
}
