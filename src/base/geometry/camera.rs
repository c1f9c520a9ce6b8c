//! The pinhole camera model, which every photo has from import on, and camera poses.

use glam::{DMat3, DVec2, DVec3};

use super::PixelRect;

/// A pinhole camera without distortion. Units are pixels; pixel (0, 0) is the top-left one and its centre is (0.5,
/// 0.5), which is COLMAP's convention; x points right, y down, z forward.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Pinhole {
    /// The photo's width in pixels.
    pub width: u32,
    /// The photo's height in pixels.
    pub height: u32,
    /// The focal length along x in pixels.
    pub fx: f64,
    /// The focal length along y in pixels.
    pub fy: f64,
    /// The principal point's x in pixels, from the left edge of the image.
    pub cx: f64,
    /// The principal point's y in pixels, from the top edge of the image.
    pub cy: f64,
}

impl Pinhole {
    /// Returns the rectangle of all pixels of the photo.
    #[inline]
    pub fn rect(&self) -> PixelRect {
        PixelRect::of_size(self.width, self.height)
    }

    /// Projects a point of the camera frame to image coordinates in pixels; `None` where it is not in front (z <=
    /// 0).
    #[inline]
    pub fn image_from_camera(&self, point_in_camera: DVec3) -> Option<DVec2> {
        let DVec3 { x, y, z } = point_in_camera;
        (z > 0.0).then(|| DVec2::new(self.fx * x / z + self.cx, self.fy * y / z + self.cy))
    }

    /// Returns the ray through an image point (pixels), in the camera frame, scaled to z = 1.
    #[inline]
    pub fn ray_in_camera(&self, point_px: DVec2) -> DVec3 {
        DVec3::new((point_px.x - self.cx) / self.fx, (point_px.y - self.cy) / self.fy, 1.0)
    }

    /// Returns K by rows: `[[fx,0,cx],[0,fy,cy],[0,0,1]]`.
    #[inline]
    pub fn matrix_rows(&self) -> [[f64; 3]; 3] {
        [[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]]
    }
}

/// A camera pose as world to camera: `point_in_camera = rotation * point_in_world + translation`.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Pose {
    /// The rotation R, orthonormal with determinant 1.
    pub rotation: DMat3,
    /// The translation t, in world units.
    pub translation: DVec3,
}

impl Pose {
    /// Transforms a world point to the camera frame.
    #[inline]
    pub fn camera_from_world(&self, point_in_world: DVec3) -> DVec3 {
        self.rotation * point_in_world + self.translation
    }

    /// Transforms a point of the camera frame to the world.
    #[inline]
    pub fn world_from_camera(&self, point_in_camera: DVec3) -> DVec3 {
        self.rotation.transpose() * (point_in_camera - self.translation)
    }

    /// Returns the camera centre in the world: C = -R^T t.
    #[inline]
    pub fn center_in_world(&self) -> DVec3 {
        -(self.rotation.transpose() * self.translation)
    }

    /// Returns R by rows.
    #[inline]
    pub fn rotation_rows(&self) -> [[f64; 3]; 3] {
        let rows = self.rotation.transpose();
        [rows.x_axis.to_array(), rows.y_axis.to_array(), rows.z_axis.to_array()]
    }
}
