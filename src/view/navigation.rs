//! An interactive camera: it orbits around a point, flies through space, and moves from photo to photo.

use glam::{DMat3, DQuat, DVec2, DVec3};

use super::flight::{Aim, Flight, FrameLens, Keyframe, Speed};
use quadratura_base::geometry::{Pinhole, Pose};

/// The steepest elevation of a turntable camera's axis, in radians (1 degree from vertical); at the poles its
/// heading would be undefined.
const STEEPEST_RAD: f64 = 89.0 * std::f64::consts::PI / 180.0;

/// The least distance from its target that zooming leads to, as a share of the site's radius; each further
/// step would be imperceptible.
const NEAREST_SHARE: f64 = 1e-4;

/// The least distance of surfaces assumed for the speed of flying, as a share of the site's radius; otherwise
/// a camera would slow down in front of a wall and never pass it.
const SLOWEST_SHARE: f64 = 0.01;

/// Half the side of an image's inner square, in image heights: what fits into it does not touch the image's
/// border.
const INNER: f64 = 0.45;

/// The farthest a pivot may be from the camera, in radii of the site; a farther one is outside of all that is
/// visible of it.
const FARTHEST_SHARE: f64 = 4.0;
/// The least distance of a default pivot, as a share of the site's radius; orbiting around a nearer one would
/// be as fast as looking around.
const NEAREST_PIVOT_SHARE: f64 = 0.1;

/// An interactive camera: pose, lens, and the point that it orbits around.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewpoint {
    /// The pose, world to camera.
    pub pose: Pose,
    /// The field of view and the principal point.
    pub lens: FrameLens,
    /// The point that orbiting turns around, in world coordinates.
    pub pivot: DVec3,
}

/// The frame of a site in which a viewpoint moves: its up direction and its size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneFrame {
    /// The up direction, a unit vector in world coordinates.
    pub up: DVec3,
    /// The centre of the model, in world coordinates.
    pub center: DVec3,
    /// The radius of a ball around `center` that holds the model, in world units.
    pub radius: f64,
}

impl SceneFrame {
    /// Computes the frame of a model's points; a ball of one unit around the origin where there are none.
    pub fn new(points: &[DVec3], up: DVec3) -> Self {
        let (low, high) = points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), point| {
            (low.min(*point), high.max(*point))
        });
        if points.is_empty() {
            return Self { up, center: DVec3::ZERO, radius: 1.0 };
        }
        let center = (low + high) / 2.0;
        let radius = points.iter().map(|point| point.distance(center)).fold(0.0, f64::max);
        Self { up, center, radius: radius.max(f64::MIN_POSITIVE) }
    }
}

impl Viewpoint {
    /// Starts at a photo's camera; the pivot is the point of its axis at the depth of `near`.
    pub fn of_camera(camera: &Pinhole, pose: &Pose, near: DVec3) -> Self {
        let depth = pose.camera_from_world(near).z;
        let depth = if depth > 0.0 { depth } else { pose.center_in_world().distance(near).max(1e-9) };
        let pivot = pose.world_from_camera(DVec3::Z * depth);
        Self { pose: *pose, lens: FrameLens::from_camera(camera), pivot }
    }

    /// Looks along `forward` at a ball (world coordinates) that fills a square image; its centre is the
    /// pivot.
    pub fn towards(center: DVec3, radius: f64, forward: DVec3, up: DVec3, lens: FrameLens) -> Self {
        let mut view = Self { pose: facing(center, forward, up), lens, pivot: center };
        view.show(center, radius);
        view
    }

    /// Looks obliquely down from a distance at which the whole ball of the site fits into a square image.
    pub fn overview(scene_frame: &SceneFrame, lens: FrameLens) -> Self {
        let level = scene_frame.up.any_orthonormal_vector();
        let forward = (level - 0.5 * scene_frame.up).normalize();
        Self::towards(scene_frame.center, scene_frame.radius, forward, scene_frame.up, lens)
    }

    /// Returns the camera's position, in world coordinates.
    pub fn position(&self) -> DVec3 {
        self.pose.center_in_world()
    }

    /// Returns the intrinsics for images of this size, in pixels.
    pub fn camera(&self, width: u32, height: u32) -> Pinhole {
        self.lens.camera(width, height)
    }

    /// Returns the direction, in world coordinates and not of unit length, of the ray through a point of an
    /// image of `size_px`.
    pub fn ray(&self, point_px: DVec2, size_px: [u32; 2]) -> DVec3 {
        let camera = self.camera(size_px[0], size_px[1]);
        self.pose.rotation.transpose() * camera.ray_in_camera(point_px)
    }

    /// Projects a world point to the image, in image heights from its centre; `None` behind the camera.
    pub fn place(&self, point: DVec3) -> Option<DVec2> {
        let point = self.pose.camera_from_world(point);
        (point.z > 0.0).then(|| self.flat(point))
    }

    /// Projects the part of a world segment that is in front of the camera, as [`Self::place`] does; `None`
    /// where it is behind.
    pub fn segment(&self, from: DVec3, to: DVec3) -> Option<[DVec2; 2]> {
        let [mut from, mut to] = [from, to].map(|point| self.pose.camera_from_world(point));
        // The depth limit, as a share of the segment's length: lines through the camera's plane leave the
        // image long before.
        let least = 1e-6 * from.distance(to);
        if from.z.max(to.z) <= least {
            return None;
        }
        let clip =
            |inside: DVec3, outside: DVec3| inside.lerp(outside, (inside.z - least) / (inside.z - outside.z));
        if from.z < least {
            from = clip(to, from);
        } else if to.z < least {
            to = clip(from, to);
        }
        Some([self.flat(from), self.flat(to)])
    }

    fn flat(&self, point_in_camera: DVec3) -> DVec2 {
        let FrameLens { focal, shift } = self.lens;
        let DVec3 { x, y, z } = point_in_camera;
        DVec2::new(focal[0] * x / z + shift[0], focal[1] * y / z + shift[1])
    }

    /// Returns the world units that a pixel of an image of this height spans at the pivot.
    pub fn units_per_px(&self, height_px: f64) -> f64 {
        self.distance() / (self.lens.focal[1] * height_px)
    }

    /// Returns the distance of the pivot, in world units.
    pub fn distance(&self) -> f64 {
        self.position().distance(self.pivot)
    }

    /// Orbits around the pivot: `yaw_rad` around `up`, `pitch_rad` around the camera's x axis, where positive
    /// pitch moves the camera up and over. It stops short of the poles.
    pub fn orbit(&mut self, yaw_rad: f64, pitch_rad: f64, up: DVec3) {
        self.turn_around(self.pivot, yaw_rad, pitch_rad, up);
    }

    /// Moves an unsuitable pivot: one that is behind the camera, outside the image, or farther away than the
    /// site is large is replaced by a point on the camera's axis, at the distance of the site's centre.
    pub fn settle_pivot(&mut self, scene_frame: &SceneFrame) {
        let depth = self.pose.camera_from_world(self.pivot).z;
        let in_picture = self.place(self.pivot).is_some_and(|place| place.abs().max_element() <= 1.0);
        if in_picture && depth <= FARTHEST_SHARE * scene_frame.radius {
            return;
        }
        let away = self.position().distance(scene_frame.center);
        let depth = away.clamp(NEAREST_PIVOT_SHARE * scene_frame.radius, FARTHEST_SHARE * scene_frame.radius);
        self.pivot = self.pose.world_from_camera(DVec3::Z * depth);
    }

    /// Looks around from the same position: `yaw_rad` to the left, `pitch_rad` up.
    pub fn look(&mut self, yaw_rad: f64, pitch_rad: f64, up: DVec3) {
        let distance = self.distance();
        self.turn_around(self.position(), yaw_rad, -pitch_rad, up);
        self.pivot = self.pose.world_from_camera(DVec3::Z * distance);
    }

    fn turn_around(&mut self, fixed: DVec3, yaw_rad: f64, pitch_rad: f64, up: DVec3) {
        let forward = self.forward();
        let elevation = forward.dot(up).clamp(-1.0, 1.0).asin();
        let pitch = (elevation - pitch_rad).clamp(-STEEPEST_RAD, STEEPEST_RAD);
        // A photo may look more steeply than the turntable's limit; its pitch is then kept, never pulled
        // back.
        let pitch = if elevation.abs() > STEEPEST_RAD { elevation } else { pitch };
        let right = forward.cross(up).try_normalize().unwrap_or_else(|| self.right());
        let turn = DQuat::from_axis_angle(up, yaw_rad) * DQuat::from_axis_angle(right, pitch - elevation);
        let turn = DMat3::from_quat(turn);
        let position = fixed + turn * (self.position() - fixed);
        let rotation = orthonormal(self.pose.rotation * turn.transpose());
        self.pose = Pose { rotation, translation: -(rotation * position) };
    }

    /// Pans camera and pivot along the image's x and y, so that points at the pivot's distance follow the
    /// pointer; `by_px` is in pixels of an image of this height.
    pub fn pan(&mut self, by_px: DVec2, height_px: f64) {
        let units = self.units_per_px(height_px);
        // Across and along the image, because the lens may have pixels that are not square.
        let across = units * self.lens.focal[1] / self.lens.focal[0];
        self.fly(DVec3::new(-by_px.x * across, -by_px.y * units, 0.0));
    }

    /// Moves by a step in the camera's frame (x right, y down, z forward), in world units, together with the
    /// pivot.
    pub fn fly(&mut self, step_in_camera: DVec3) {
        self.pivot += self.pose.rotation.transpose() * step_in_camera;
        self.pose.translation -= step_in_camera;
    }

    /// Estimates the distance of the visible surfaces, in world units, for the speed of flying: the geometric
    /// mean along nine rays of the image's inner half, so that a thin object in front of the camera does not
    /// stop a flight. `first` returns the distance of the first surface along a ray of unit length; where
    /// there is none, the site's radius is used, which is also the maximum. The minimum is a hundredth of the
    /// radius.
    pub fn ahead(&self, scene_frame: &SceneFrame, first: impl Fn(DVec3, DVec3) -> Option<f64>) -> f64 {
        const THIRDS: [f64; 3] = [0.25, 0.5, 0.75];
        let (position, side) = (self.position(), 1000);
        let [slowest, most] = [scene_frame.radius * SLOWEST_SHARE, scene_frame.radius];
        let log = |x: f64, y: f64| {
            let ray = self.ray(DVec2::new(x, y) * f64::from(side), [side, side]).normalize_or_zero();
            first(position, ray).unwrap_or(most).clamp(slowest, most).ln()
        };
        let logs = THIRDS.into_iter().flat_map(|y| THIRDS.map(|x| log(x, y)));
        (logs.sum::<f64>() / 9.0).exp()
    }

    /// Zooms `factor` times nearer to `target` (world coordinates, under the pointer), which keeps its
    /// position in the image. The pivot moves to the depth of the target, so that the next orbit is around
    /// it.
    pub fn zoom(&mut self, target: DVec3, factor: f64, scene_frame: &SceneFrame) {
        let position = self.position();
        let nearest = scene_frame.radius * NEAREST_SHARE;
        let distance = position.distance(target);
        let wanted = distance / factor;
        if distance <= 0.0 || (wanted < nearest && factor > 1.0) {
            return;
        }
        let position = target + (position - target) * (wanted / distance);
        self.pose.translation = -(self.pose.rotation * position);
        let depth = self.pose.camera_from_world(target).z;
        if depth > 0.0 {
            self.pivot = self.pose.world_from_camera(DVec3::Z * depth);
        }
    }

    /// Moves back or forth, without turning, until a ball fills the image; the ball's centre becomes the
    /// pivot.
    pub fn show(&mut self, center: DVec3, radius: f64) {
        // The narrower field of view decides; images are seldom narrower than half their height.
        let half = (0.5 / self.lens.focal[0].max(self.lens.focal[1])).atan();
        let position = center - self.forward() * (radius / half.sin());
        self.pose.translation = -(self.pose.rotation * position);
        self.pivot = center;
    }

    /// Moves back or forth, without turning, until points (world coordinates) just fit into the image's inner
    /// square.
    pub fn hold(&mut self, points: &[DVec3]) {
        self.hold_within(points, 1.0);
    }

    /// Moves back or forth, without turning, until points (world coordinates) just fit into an image of this width,
    /// in image heights, with a margin.
    pub fn hold_within(&mut self, points: &[DVec3], width: f64) {
        let [focal_x, focal_y] = self.lens.focal;
        let needed = |point: &DVec3| {
            let DVec3 { x, y, z } = self.pose.camera_from_world(*point);
            (focal_x * x.abs() / width).max(focal_y * y.abs()) / INNER - z
        };
        let back = points.iter().map(needed).fold(f64::NEG_INFINITY, f64::max);
        if back.is_finite() {
            self.pose.translation += DVec3::Z * back;
        }
    }

    /// Rolls around its axis until the horizon is level.
    pub fn level(&mut self, up: DVec3) {
        let position = self.position();
        self.pose = facing(position, self.forward(), up);
    }

    /// Computes a smooth flight to another viewpoint in `seconds`, with gentle start and end; camera and lens
    /// change together. The flight does not include the pivot. Returns `None` where no such flight exists.
    pub fn flight_to(&self, there: &Self, seconds: f64, up: DVec3) -> Option<Flight> {
        let frame = |view: &Self, time_s| Keyframe {
            time_s,
            position: view.position(),
            aim: Aim::Rotation(DQuat::from_mat3(&view.pose.rotation.transpose())),
            lens: view.lens,
        };
        // A flight needs an image size, of which only the proportions relative to itself are used again.
        const ANY_SIZE: [u32; 2] = [1024, 1024];
        Flight::new(&[frame(self, 0.0), frame(there, seconds)], ANY_SIZE, Speed::Eased, up).ok()
    }

    fn forward(&self) -> DVec3 {
        self.pose.rotation.transpose() * DVec3::Z
    }

    fn right(&self) -> DVec3 {
        self.pose.rotation.transpose() * DVec3::X
    }
}

/// Returns the pose of a camera at `position` that looks along `forward`, with `up` upwards where the two are
/// not parallel.
fn facing(position: DVec3, forward: DVec3, up: DVec3) -> Pose {
    let right = forward.cross(up).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
    let rotation = DMat3::from_cols(right, forward.cross(right), forward).transpose();
    Pose { rotation, translation: -(rotation * position) }
}

/// Makes a rotation orthonormal again, because the rounding of many small turns would add up to a shear.
fn orthonormal(rotation: DMat3) -> DMat3 {
    DMat3::from_quat(DQuat::from_mat3(&rotation).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::{centred, look_at};

    const UP: DVec3 = DVec3::Z;

    fn view() -> Viewpoint {
        let pose = look_at(DVec3::new(3.0, -8.0, 2.0), DVec3::new(0.0, 0.0, 1.0));
        Viewpoint::of_camera(&centred(640, 480, 500.0), &pose, DVec3::new(0.0, 0.0, 1.0))
    }

    fn px(view: &Viewpoint, point: DVec3) -> DVec2 {
        view.camera(640, 480).image_from_camera(view.pose.camera_from_world(point)).unwrap()
    }

    fn scene_frame() -> SceneFrame {
        SceneFrame { up: UP, center: DVec3::ZERO, radius: 10.0 }
    }

    #[test]
    fn orbiting_keeps_the_pivot_where_it_is_in_the_picture_and_at_its_distance() {
        let (before, mut after) = (view(), view());
        for step in 0..1000 {
            after.orbit(0.05, 0.01 * (f64::from(step) * 0.1).sin(), UP);
        }
        assert!((px(&before, before.pivot) - px(&after, before.pivot)).length() < 1e-6);
        assert!((before.distance() - after.distance()).abs() < 1e-9);
        // A thousand turns leave a rotation.
        let rotation = after.pose.rotation;
        let error = rotation * rotation.transpose() - DMat3::IDENTITY;
        assert!(error.to_cols_array().iter().all(|entry| entry.abs() < 1e-12));
    }

    #[test]
    fn what_is_ahead_is_as_far_as_most_of_the_picture_and_never_nothing() {
        let (view, scene_frame) = (view(), scene_frame());
        let wall = |far: f64| view.ahead(&scene_frame, |_, _| Some(far));
        assert!((wall(4.0) - 4.0).abs() < 1e-12);
        assert!((wall(1e-9) - 0.1).abs() < 1e-12, "a hundredth of the radius");
        assert!((wall(1e9) - 10.0).abs() < 1e-9, "the radius");
        assert!((view.ahead(&scene_frame, |_, _| None) - 10.0).abs() < 1e-9);
        // A pole right in the middle, and a wall behind it.
        let forward = view.forward();
        let pole = |_, ray: DVec3| Some(if ray.dot(forward) > 1.0 - 1e-9 { 0.5 } else { 8.0 });
        assert!((view.ahead(&scene_frame, pole) - 8.0 * (0.5f64 / 8.0).powf(1.0 / 9.0)).abs() < 1e-9);
    }

    #[test]
    fn a_pivot_that_nobody_looks_at_gives_way_to_one_in_the_middle_of_the_picture() {
        let mut seen = view();
        let kept = seen;
        seen.settle_pivot(&scene_frame());
        assert_eq!(seen, kept);
        for pivot in [kept.position() - kept.forward(), kept.position() + kept.forward() * 1e4] {
            let mut lost = Viewpoint { pivot, ..kept };
            lost.settle_pivot(&scene_frame());
            assert!((px(&lost, lost.pivot) - DVec2::new(320.0, 240.0)).length() < 1e-6);
            assert!((lost.distance() - kept.position().length()).abs() < 1e-9, "as far as the middle");
            assert_eq!(lost.pose, kept.pose, "nothing jumps");
        }
    }

    #[test]
    fn orbiting_stops_short_of_the_poles() {
        for pitch in [20.0, -20.0] {
            let mut view = view();
            view.orbit(0.0, pitch, UP);
            let elevation = view.forward().dot(UP).asin().abs();
            assert!((elevation - STEEPEST_RAD).abs() < 1e-9, "{elevation}");
            assert!(view.right().dot(UP).abs() < 1e-9, "the horizon stays level");
        }
    }

    #[test]
    fn panning_lets_the_pivot_follow_the_pointer() {
        let mut after = view();
        let point = after.pivot;
        let before = px(&after, point);
        after.pan(DVec2::new(37.0, -21.0), 480.0);
        assert!((px(&after, point) - before - DVec2::new(37.0, -21.0)).length() < 1e-9);
    }

    #[test]
    fn zooming_keeps_what_is_under_the_pointer_in_its_place() {
        let mut after = view();
        let target = DVec3::new(-1.0, 0.5, 2.0);
        let before = px(&after, target);
        let distance = after.position().distance(target);
        after.zoom(target, 1.25, &scene_frame());
        assert!((px(&after, target) - before).length() < 1e-9);
        assert!((after.position().distance(target) - distance / 1.25).abs() < 1e-9);
    }

    #[test]
    fn zooming_never_reaches_what_it_zooms_to() {
        let mut after = view();
        let target = after.pivot;
        (0..500).for_each(|_| after.zoom(target, 1.5, &scene_frame()));
        assert!(after.position().distance(target) >= 10.0 * NEAREST_SHARE);
        after.zoom(target, 0.5, &scene_frame());
        assert!(after.position().distance(target) > 10.0 * NEAREST_SHARE, "and comes back");
    }

    #[test]
    fn looking_around_keeps_the_place_and_flying_the_direction() {
        let (before, mut after) = (view(), view());
        after.look(0.3, 0.1, UP);
        assert!((before.position() - after.position()).length() < 1e-9);
        assert!((after.forward().dot(UP).asin() - before.forward().dot(UP).asin() - 0.1).abs() < 1e-9);
        let looked = after;
        after.fly(DVec3::new(0.5, 0.0, 2.0));
        assert_eq!(looked.pose.rotation, after.pose.rotation);
        assert!((looked.distance() - after.distance()).abs() < 1e-9);
        let step = looked.pose.rotation * (after.position() - looked.position());
        assert!((step - DVec3::new(0.5, 0.0, 2.0)).length() < 1e-9);
    }

    #[test]
    fn a_photo_that_looks_straight_down_is_turned_and_not_tilted() {
        let rotation = DMat3::from_cols(DVec3::X, -DVec3::Y, -DVec3::Z);
        let pose = Pose { rotation, translation: DVec3::new(0.0, 0.0, 5.0) };
        let mut view = Viewpoint::of_camera(&centred(64, 64, 50.0), &pose, DVec3::ZERO);
        view.orbit(0.2, 0.3, UP);
        assert!((view.forward() + UP).length() < 1e-9);
    }

    #[test]
    fn what_is_shown_fits_into_the_picture() {
        let mut view = view();
        let (center, radius) = (DVec3::new(4.0, 4.0, 0.0), 3.0);
        view.show(center, radius);
        assert_eq!(view.pivot, center);
        let highest = center + view.pose.rotation.transpose() * DVec3::new(0.0, -radius, 0.0);
        assert!((0.0..240.0).contains(&px(&view, highest).y));
        let overview = Viewpoint::overview(&scene_frame(), view.lens);
        assert!(overview.position().z > 0.0 && overview.right().dot(UP).abs() < 1e-9);
    }

    #[test]
    fn a_point_is_placed_as_the_camera_sees_it_and_a_segment_ends_before_the_camera() {
        let view = view();
        let point = DVec3::new(-1.0, 0.5, 2.0);
        let placed = view.place(point).unwrap() * 480.0 + DVec2::new(320.0, 240.0);
        assert!((placed - px(&view, point)).length() < 1e-9);
        let behind = view.position() - view.forward() * 2.0;
        assert_eq!(view.place(behind), None);
        let [from, to] = view.segment(point, behind + DVec3::X).unwrap();
        assert!((from - view.place(point).unwrap()).length() < 1e-12 && to.is_finite());
        assert_eq!(view.segment(behind, behind - view.forward()), None);
    }

    #[test]
    fn a_flight_starts_here_and_ends_there() {
        let (here, mut there) = (view(), view());
        there.orbit(1.0, 0.2, UP);
        let flight = here.flight_to(&there, 0.6, UP).unwrap();
        let ((_, start), (_, end)) = (flight.at(0.0), flight.at(0.6));
        assert!((start.center_in_world() - here.position()).length() < 1e-9);
        assert!((end.center_in_world() - there.position()).length() < 1e-9);
    }
}
