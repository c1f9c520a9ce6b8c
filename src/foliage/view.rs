//! Views of plants: perspective cameras and parallel projections, and what of the space they see.

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::bounds::Ball;
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};

/// How points of the view's frame (x right, y down, z away from the viewer) become image points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// A pinhole camera in the origin.
    Perspective {
        /// The intrinsics.
        camera: Pinhole,
        /// What is nearer than this is cut off, in the unit of the view's frame; above 0.
        near: f64,
    },
    /// All rays are parallel to z.
    Parallel {
        /// The number of pixels across.
        width: u32,
        /// The number of pixels down.
        height: u32,
        /// Pixels for a unit of the view's frame.
        scale: f64,
        /// The image point of x = y = 0, in pixels.
        centre_px: DVec2,
    },
}

/// A view of a plant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// The projection.
    pub projection: Projection,
    /// The map from the plant's frame to the view's.
    pub view_from_plant: DAffine3,
    /// The rotation from the view's frame to that of the light: the plant's, or the world's.
    pub light_from_view: DMat3,
}

/// The share of a camera's distance to the far end of the plant that is cut off in front of the camera. It only keeps
/// numbers finite: nobody puts a camera that near to a leaf.
const NEAR: f64 = 1e-5;

impl View {
    /// Makes the view of a camera in the plant's frame, which cuts off next to nothing of what is within `ball`.
    pub fn perspective(camera: Pinhole, pose: &Pose, ball: &Ball) -> Self {
        let view_from_plant = DAffine3::from_mat3_translation(pose.rotation, pose.translation);
        let far = view_from_plant.transform_point3(ball.middle).length() + ball.radius;
        let near = (NEAR * far).max(f64::MIN_POSITIVE);
        let light_from_view = pose.rotation.transpose();
        Self { projection: Projection::Perspective { camera, near }, view_from_plant, light_from_view }
    }

    /// Makes the view of a camera in the world of a tree whose plant is within `ball` in its own frame; its light is that of
    /// the world.
    pub fn of_tree(camera: Pinhole, pose: &Pose, world_from_plant: &DAffine3, ball: &Ball) -> Self {
        let view_from_world = DAffine3::from_mat3_translation(pose.rotation, pose.translation);
        let view_from_plant = view_from_world * *world_from_plant;
        let ball = ball.mapped(&view_from_plant);
        let near = (NEAR * (ball.middle.length() + ball.radius)).max(f64::MIN_POSITIVE);
        let light_from_view = pose.rotation.transpose();
        Self { projection: Projection::Perspective { camera, near }, view_from_plant, light_from_view }
    }

    /// Returns the rectangle of all pixels.
    pub fn rect(&self) -> PixelRect {
        match self.projection {
            Projection::Perspective { camera, .. } => camera.rect(),
            Projection::Parallel { width, height, .. } => PixelRect::of_size(width, height),
        }
    }
}

impl Projection {
    /// Projects a point that is not cut off: its image point in pixels, and how near it is: 1/z of a perspective view, -z of
    /// a parallel one. Both are linear across the image of a plane, and larger is nearer.
    #[inline]
    pub fn image_from_view(&self, point: DVec3) -> (DVec2, f64) {
        match self {
            Self::Perspective { camera, .. } => {
                let nearness = point.z.recip();
                let x = camera.fx * point.x * nearness + camera.cx;
                (DVec2::new(x, camera.fy * point.y * nearness + camera.cy), nearness)
            }
            Self::Parallel { scale, centre_px, .. } => (*scale * point.truncate() + *centre_px, -point.z),
        }
    }

    /// Returns the point of the view's frame at an image point in pixels and a nearness: the inverse of
    /// [`Self::image_from_view`].
    #[inline]
    pub fn view_from_image(&self, point_px: DVec2, nearness: f64) -> DVec3 {
        let z = self.depth(nearness);
        match self {
            Self::Perspective { camera: c, .. } => {
                DVec3::new(z * (point_px.x - c.cx) / c.fx, z * (point_px.y - c.cy) / c.fy, z)
            }
            Self::Parallel { scale, centre_px, .. } => ((point_px - *centre_px) / *scale).extend(z),
        }
    }

    /// Returns the depth z of a nearness.
    pub fn depth(&self, nearness: f64) -> f64 {
        if self.is_perspective() { nearness.recip() } else { -nearness }
    }

    /// Returns true for perspective views.
    #[inline]
    pub fn is_perspective(&self) -> bool {
        matches!(self, Self::Perspective { .. })
    }

    /// Returns true where a point has an image: it is not cut off.
    #[inline]
    pub fn is_ahead(&self, point: DVec3) -> bool {
        match self {
            Self::Perspective { near, .. } => point.z >= *near,
            Self::Parallel { .. } => true,
        }
    }

    /// Returns the direction from a point to the viewer, of any length.
    pub fn towards_viewer(&self, point: DVec3) -> DVec3 {
        if self.is_perspective() { -point } else { -DVec3::Z }
    }

    /// Returns the half spaces that hold what is seen in a rectangle of pixels: `normal . p >= offset` with normals of
    /// length 1; four sides, and for perspective views the near plane.
    pub fn half_spaces(&self, rect: &PixelRect) -> Vec<HalfSpace> {
        let (low, high) = (
            DVec2::new(f64::from(rect.x), f64::from(rect.y)),
            DVec2::new(f64::from(rect.right()), f64::from(rect.bottom())),
        );
        match self {
            Self::Perspective { camera: c, near } => {
                let sides = [
                    DVec3::new(c.fx, 0.0, c.cx - low.x),
                    DVec3::new(-c.fx, 0.0, high.x - c.cx),
                    DVec3::new(0.0, c.fy, c.cy - low.y),
                    DVec3::new(0.0, -c.fy, high.y - c.cy),
                ];
                let sides = sides.map(|side| HalfSpace { normal: side.normalize(), offset: 0.0 });
                [HalfSpace { normal: DVec3::Z, offset: *near }].into_iter().chain(sides).collect()
            }
            Self::Parallel { scale, centre_px, .. } => {
                let (low, high) = ((low - *centre_px) / *scale, (high - *centre_px) / *scale);
                let side = |normal: DVec3, offset: f64| HalfSpace { normal, offset };
                vec![
                    side(DVec3::X, low.x),
                    side(-DVec3::X, -high.x),
                    side(DVec3::Y, low.y),
                    side(-DVec3::Y, -high.y),
                ]
            }
        }
    }
}

/// Returns whether a camera may see some of a ball in its frame.
pub fn sees(camera: &Pinhole, ball: &Ball) -> bool {
    let projection = Projection::Perspective { camera: *camera, near: 0.0 };
    projection.half_spaces(&camera.rect()).iter().all(|half_space| half_space.touches(ball))
}

/// The points with `normal . p >= offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfSpace {
    /// The normal, of length 1.
    pub normal: DVec3,
    /// The distance of the plane from the origin, along the normal.
    pub offset: f64,
}

impl HalfSpace {
    /// Returns how far inside a point is; negative outside.
    #[inline]
    pub fn inside(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    /// Returns true when some of the ball is inside.
    #[inline]
    pub fn touches(&self, ball: &Ball) -> bool {
        self.inside(ball.middle) >= -ball.radius
    }

    /// Returns true when all of the ball is inside.
    #[inline]
    pub fn holds(&self, ball: &Ball) -> bool {
        self.inside(ball.middle) >= ball.radius
    }
}

/// Returns the map of normals that belongs to a map of points: its inverse transpose up to a positive factor, which also
/// exists where the map is singular.
pub fn normal_map(map: &DMat3) -> DMat3 {
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = *map;
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    if map.determinant() < 0.0 { -cofactors } else { cofactors }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::{centred, look_at};

    #[test]
    fn what_the_half_spaces_of_a_rectangle_hold_is_what_is_seen_in_it() {
        let rect = PixelRect::from_edges(10, 20, 30, 60);
        let camera = centred(80, 60, 70.0);
        let parallel =
            Projection::Parallel { width: 80, height: 60, scale: 7.0, centre_px: DVec2::new(40.0, 30.0) };
        for projection in [Projection::Perspective { camera, near: 0.5 }, parallel] {
            let planes = projection.half_spaces(&rect);
            for i in 0..4000 {
                let step = |k: i32, n: i32| f64::from(i / k % n) / f64::from(n) - 0.5;
                let point = DVec3::new(step(1, 20) * 12.0, step(20, 20) * 12.0, 5.01 + step(400, 10) * 10.0);
                let inside = planes.iter().all(|plane| plane.inside(point) >= 0.0);
                let (px, nearness) = projection.image_from_view(point);
                let seen = projection.is_ahead(point)
                    && (10.0..=30.0).contains(&px.x)
                    && (20.0..=60.0).contains(&px.y);
                assert_eq!(inside, seen, "{point} at {px}");
                assert!((projection.depth(nearness) - point.z).abs() < 1e-12);
                assert!(projection.view_from_image(px, nearness).abs_diff_eq(point, 1e-12));
            }
        }
    }

    #[test]
    fn normals_stay_perpendicular_under_any_map_and_keep_their_side_in_a_mirror() {
        let map = DMat3::from_cols_array(&[1.0, 0.2, 0.0, -0.4, 2.0, 0.3, 0.1, 0.0, -0.7]);
        let (u, v) = (DVec3::new(1.0, 0.5, 0.2), DVec3::new(-0.3, 1.0, 0.9));
        let normal = normal_map(&map) * u.cross(v);
        assert!(normal.dot(map * u).abs() < 1e-12 && normal.dot(map * v).abs() < 1e-12);
        assert!(normal.dot(map * u.cross(v)) > 0.0);
    }

    #[test]
    fn a_camera_in_the_plant_cuts_off_next_to_nothing() {
        let ball = Ball { middle: DVec3::ZERO, radius: 4.0 };
        let pose = look_at(DVec3::new(0.1, 0.0, 0.0), DVec3::new(1.0, 0.0, 0.0));
        let view = View::perspective(centred(8, 8, 8.0), &pose, &ball);
        let Projection::Perspective { near, .. } = view.projection else { unreachable!() };
        assert!(near > 0.0 && near < 1e-4);
    }
}
