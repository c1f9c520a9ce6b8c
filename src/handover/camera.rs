//! A photo's camera as other programs get it, and the numbers that describe it there.

use glam::{DMat3, DVec3};

use quadratura_base::geometry::{Pinhole, Pose};

/// The width of the film in millimetres. Any constant gives the same picture; 36 is what programs show by default.
pub const FILM_WIDTH_MM: f64 = 36.0;

/// An undistorted photo with its camera.
#[derive(Debug, Clone, PartialEq)]
pub struct HandoverCamera {
    /// The photo's name in the project.
    pub name: String,
    /// The path of its undistorted picture, relative to the folder of the export, with `/`.
    pub file: String,
    /// The size and K in pixels.
    pub camera: Pinhole,
    /// The pose, from the world less the origin to the camera.
    pub pose: Pose,
}

/// A camera's lens as Blender has it, with the sensor fit *Horizontal* and a sensor width of [`FILM_WIDTH_MM`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlenderLens {
    /// The focal length in millimetres.
    pub lens: f64,
    /// The shift in widths of the sensor, to the right and up.
    pub shift: [f64; 2],
    /// The pixel aspect of the scene, x and y; neither is below 1, where Blender clamps.
    pub pixel_aspect: [f64; 2],
}

impl HandoverCamera {
    /// Returns the centre of projection, in the world less the origin.
    pub fn center(&self) -> DVec3 {
        self.pose.center_in_world()
    }

    /// Returns the transform from a camera that looks along -z with y up (OpenGL's axes, also of Blender, USD and glTF) to the
    /// world less the origin, by rows.
    pub fn world_from_gl_camera(&self) -> [[f64; 4]; 4] {
        world_from_gl_camera(&self.pose)
    }
}

/// Returns the pose in the world less `origin`.
pub fn less_origin(pose: &Pose, origin: DVec3) -> Pose {
    Pose { rotation: pose.rotation, translation: pose.camera_from_world(origin) }
}

/// Returns the transform from a camera that looks along -z with y up to the world of `pose`, by rows:
/// `[Rᵀ diag(1, -1, -1), C]`.
pub fn world_from_gl_camera(pose: &Pose) -> [[f64; 4]; 4] {
    let axes = pose.rotation.transpose() * DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0));
    let center = pose.center_in_world();
    let row = |i: usize| [axes.x_axis[i], axes.y_axis[i], axes.z_axis[i], center[i]];
    [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
}

/// Returns the camera's lens as Blender has it. With a = fx / fy: lens = fx s / W, shift = ((W/2 - cx) / W, (cy - H/2) a / W); pixels
/// are a high where they are 1 wide, so that the wider side of the aspect is never below 1.
pub fn blender_lens(camera: &Pinhole) -> BlenderLens {
    let (width, height) = (f64::from(camera.width), f64::from(camera.height));
    let aspect = camera.fx / camera.fy;
    BlenderLens {
        lens: camera.fx * FILM_WIDTH_MM / width,
        shift: [(width / 2.0 - camera.cx) / width, (camera.cy - height / 2.0) * aspect / width],
        pixel_aspect: if aspect >= 1.0 { [1.0, aspect] } else { [1.0 / aspect, 1.0] },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec2, EulerRot};
    use quadratura_base::geometry::PixelRect;

    /// Where Blender draws a point, computed as its manual describes the camera, independent of K: the sensor is as wide as
    /// the picture; the view plane is moved by the shift in widths; the picture's height in sensor widths follows from
    /// the resolution and the pixel aspect.
    fn drawn_by_blender(
        lens: &BlenderLens,
        rect: PixelRect,
        world_from_camera: [[f64; 4]; 4],
        point: DVec3,
    ) -> DVec2 {
        let axis = |j: usize| DVec3::from_array([0, 1, 2].map(|i| world_from_camera[i][j]));
        let local = point - axis(3);
        let [x, y, z] = [0, 1, 2].map(|j| local.dot(axis(j)));
        let (width, height) = (f64::from(rect.w), f64::from(rect.h));
        let [pixel_x, pixel_y] = lens.pixel_aspect;
        let height_in_widths = height * pixel_y / (width * pixel_x);
        // In widths of the sensor from its middle, x right, y up.
        let on_sensor = DVec2::new(x, y) / -z * lens.lens / FILM_WIDTH_MM - DVec2::from_array(lens.shift);
        DVec2::new((on_sensor.x + 0.5) * width, (0.5 - on_sensor.y / height_in_widths) * height)
    }

    #[test]
    fn blenders_camera_draws_every_point_where_the_photo_shows_it() {
        let mut state = 7u64;
        let mut random = |low: f64, high: f64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            low + (high - low) * (state >> 11) as f64 / (1u64 << 53) as f64
        };
        for _ in 0..200 {
            let (width, height) = (random(200.0, 4000.0) as u32, random(200.0, 4000.0) as u32);
            let fx = random(0.5, 3.0) * f64::from(width);
            let camera = Pinhole {
                width,
                height,
                fx,
                fy: fx / random(0.5, 2.0),
                cx: random(-0.2, 1.2) * f64::from(width),
                cy: random(-0.2, 1.2) * f64::from(height),
            };
            let turn =
                DQuat::from_euler(EulerRot::XYZ, random(-3.0, 3.0), random(-1.5, 1.5), random(-3.0, 3.0));
            let pose = Pose {
                rotation: DMat3::from_quat(turn),
                translation: DVec3::new(random(-9.0, 9.0), random(-9.0, 9.0), random(-9.0, 9.0)),
            };
            let point =
                pose.world_from_camera(DVec3::new(random(-4.0, 4.0), random(-4.0, 4.0), random(1.0, 30.0)));
            let expected = camera.image_from_camera(pose.camera_from_world(point)).unwrap();
            let drawn =
                drawn_by_blender(&blender_lens(&camera), camera.rect(), world_from_gl_camera(&pose), point);
            // Rounding of f64 alone.
            assert!(drawn.distance(expected) < 1e-7, "{drawn} {expected}");
            assert!(blender_lens(&camera).pixel_aspect.iter().all(|side| *side >= 1.0));
        }
    }

    #[test]
    fn a_pose_less_the_origin_shows_the_moved_point_in_the_same_place() {
        let pose = Pose { rotation: DMat3::from_rotation_y(0.3), translation: DVec3::new(1.0, 2.0, 3.0) };
        let (origin, point) = (DVec3::new(1e5, -2e5, 40.0), DVec3::new(100_010.0, -200_020.0, 43.0));
        let moved = less_origin(&pose, origin).camera_from_world(point - origin);
        // f64 has 1e-11 at 2e5.
        assert!(moved.distance(pose.camera_from_world(point)) < 1e-9);
    }
}
