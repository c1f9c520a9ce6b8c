//! The exploded view of a photo's image layers: layer textures at different depths in the photo's view, ordered as in
//! the stack. Points move along the rays of the photo's pixels, so that from the photo's camera the layer textures
//! look like the photo however far apart they are.

use glam::{DVec2, DVec3};

use quadratura_base::geometry::{Pinhole, PixelRect, Pose};
use quadratura_view::flight::FrameLens;
use quadratura_view::navigation::Viewpoint;

/// The arrangement of a photo's layer textures in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stand {
    /// The photo's intrinsics, in pixels.
    pub camera: Pinhole,
    /// The photo's pose, world to camera.
    pub pose: Pose,
    /// The depth of the nearest layer textures, in world units.
    pub first: f64,
    /// The spacing from one order to the next, as a share of `first`.
    pub apart: f64,
}

/// The direction of the side view, in the photo's camera frame: from the right of the camera and above it.
const ASIDE: DVec3 = DVec3::new(1.0, -0.42, -0.86);

impl Stand {
    /// Arranges the layer textures so that the nearest one is `height` world units high.
    pub fn with_height(camera: Pinhole, pose: Pose, height: f64, apart: f64) -> Self {
        Self { camera, pose, first: height * camera.fy / f64::from(camera.height), apart }
    }

    /// Returns the depth of the layer textures of an order (0 nearest), in world units in front of the photo's
    /// camera.
    pub fn depth(&self, order: u32) -> f64 {
        self.first * (1.0 + self.apart * f64::from(order))
    }

    /// Returns the position of the photo pixel `px` on the layer texture with this `order`, in world coordinates.
    pub fn point(&self, order: u32, px: DVec2) -> DVec3 {
        self.pose.world_from_camera(self.camera.ray_in_camera(px) * self.depth(order))
    }

    /// Returns the corners of a rectangle (photo pixels) on a layer texture, in world coordinates, clockwise from its
    /// top left.
    pub fn corners(&self, order: u32, rect: PixelRect) -> [DVec3; 4] {
        let (left, top) = (f64::from(rect.x), f64::from(rect.y));
        let (right, bottom) = (f64::from(rect.right()), f64::from(rect.bottom()));
        [(left, top), (right, top), (right, bottom), (left, bottom)]
            .map(|(x, y)| self.point(order, DVec2::new(x, y)))
    }

    /// Intersects a ray with the layer texture of an order: returns the ray parameter along `direction`, and the
    /// photo pixel; `None` where the ray does not hit the layer texture's plane.
    pub fn meet(&self, order: u32, origin: DVec3, direction: DVec3) -> Option<(f64, DVec2)> {
        let (from, along) = (self.pose.camera_from_world(origin), self.pose.rotation * direction);
        let t = (self.depth(order) - from.z) / along.z;
        let point = from + along * t;
        (t.is_finite() && t > 0.0).then(|| Some((t, self.camera.image_from_camera(point)?)))?
    }

    /// Returns the indices of layer textures of these orders in drawing order for an eye: farther ones first, and of
    /// layer textures in one plane those deeper in the stack. Parallel planes occlude each other by their distance
    /// alone.
    pub fn from_behind(&self, orders: &[u32], eye: DVec3) -> Vec<usize> {
        let eye = self.pose.camera_from_world(eye).z;
        let mut indices: Vec<usize> = (0..orders.len()).collect();
        let away = |index: usize| (self.depth(orders[index]) - eye).abs();
        indices
            .sort_by(|a, b| away(*b).total_cmp(&away(*a)).then(orders[*b].cmp(&orders[*a])).then(b.cmp(a)));
        indices
    }

    /// Returns a viewpoint that sees all layer textures up to an order from the side, with `up` of the world upwards, in an
    /// image of this `width` in image heights.
    pub fn side_view(&self, last: u32, lens: FrameLens, up: DVec3, width: f64) -> Viewpoint {
        let whole = self.camera.rect();
        let marks = [self.corners(0, whole), self.corners(last, whole)].concat();
        let center = marks.iter().sum::<DVec3>() / marks.len() as f64;
        let radius = marks.iter().map(|mark| mark.distance(center)).fold(0.0, f64::max);
        let forward = self.pose.rotation.transpose() * -ASIDE.normalize();
        let mut view = Viewpoint::towards(center, radius, forward, up, lens);
        view.hold_within(&marks, width);
        view
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::{centred, look_at};

    fn stand() -> Stand {
        let pose = look_at(DVec3::new(3.0, -8.0, 2.0), DVec3::new(0.0, 0.0, 1.0));
        Stand::with_height(centred(640, 480, 500.0), pose, 4.0, 0.25)
    }

    #[test]
    fn from_the_photos_camera_the_sheets_lie_on_each_other_and_the_nearest_is_as_high_as_asked() {
        let stand = stand();
        let px = DVec2::new(100.0, 400.0);
        for order in [0, 3] {
            let seen = stand.pose.camera_from_world(stand.point(order, px));
            assert!((stand.camera.image_from_camera(seen).unwrap() - px).length() < 1e-9);
            assert!((seen.z - stand.depth(order)).abs() < 1e-9);
        }
        let whole = PixelRect::of_size(640, 480);
        let [top, _, _, bottom] = stand.corners(0, whole);
        assert!((top.distance(bottom) - 4.0).abs() < 1e-9);
    }

    #[test]
    fn a_ray_meets_a_sheet_at_the_pixel_that_it_was_sent_to() {
        let stand = stand();
        let (eye, px) = (DVec3::new(9.0, -3.0, 4.0), DVec2::new(222.0, 33.0));
        let target = stand.point(2, px);
        let (t, met) = stand.meet(2, eye, target - eye).unwrap();
        assert!((t - 1.0).abs() < 1e-9 && (met - px).length() < 1e-6);
        assert_eq!(stand.meet(2, eye, eye - target), None, "it is behind");
    }

    #[test]
    fn what_is_farther_from_the_eye_is_drawn_first_from_either_side() {
        let stand = stand();
        let orders = [0, 2, 1, 1];
        let before = stand.pose.center_in_world();
        assert_eq!(stand.from_behind(&orders, before), [1, 3, 2, 0]);
        let beyond = stand.pose.world_from_camera(DVec3::Z * stand.depth(9));
        assert_eq!(stand.from_behind(&orders, beyond), [0, 3, 2, 1]);
    }

    #[test]
    fn from_aside_all_sheets_are_in_the_picture() {
        let stand = stand();
        let view = stand.side_view(4, FrameLens::with_field_of_view(0.8), DVec3::Z, 1.0);
        let whole = PixelRect::of_size(640, 480);
        let mut widest = 0.0f64;
        for corner in [stand.corners(0, whole), stand.corners(4, whole)].concat() {
            let position = view.place(corner).unwrap();
            assert!(position.abs().max_element() <= 0.4501, "{position}");
            widest = widest.max(position.abs().max_element());
        }
        assert!(widest > 0.449, "as large as fits: {widest}");
    }
}
