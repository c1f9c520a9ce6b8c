//! Views from the sun, in which the shadows that trees cast on what a camera sees are found: the farther away, the coarser
//! (Engel, *Cascaded Shadow Maps*, 2006).

use glam::{DMat3, DVec2, DVec3};

use super::bounds::Ball;
use super::cast::SUN_TANGENT;
use quadratura_base::geometry::{Pinhole, Pose};

/// The most views from the sun for one picture.
pub const MOST_SUN_VIEWS: usize = 3;

/// The ratio of the depths at which the part of a picture that a view from the sun serves ends and begins.
const DEPTH_RATIO: f64 = 4.0;
/// The share of the depths of a part over which the next one takes over; as in `shaders/shadows.wgsl`.
pub const TAKES_OVER: f64 = 0.15;
/// How far away the sun is, in widths of its view: so far that its rays are parallel to less than a fifteenth of its own width.
const SUN_WIDTHS: f64 = 1000.0;
/// The same in lengths along its rays, from what is nearest to it to what is farthest.
const SUN_LENGTHS: f64 = 8.0;
/// Pixels at each side of a view from the sun that are beside what it serves, for filters.
const MARGIN_PX: f64 = 16.0;
/// The least side of a pixel: as a share of the camera's pixel where a part begins, and of the radius of the widest penumbra. Finer
/// ones show nothing more, and cost more.
const LEAST_PIXEL: [f64; 2] = [0.75, 0.25];
/// The least height of the sun for which penumbras are as wide as its rays are long, as the sine of its angle.
const LOWEST_SUN: f64 = 0.2;
/// Pixels of views from the sun have sizes of a ladder with so many rungs an octave, and lie on a grid in the world: while the
/// camera moves, most shadows are drawn from the same pixels.
const RUNGS: f64 = 4.0;

/// What there is to cast shadows and to catch them.
#[derive(Debug, Clone, Copy)]
pub struct SunScene<'a> {
    /// Balls around the trees that cast shadows, in the world.
    pub casters: &'a [Ball],
    /// The corners of the faces, in the world.
    pub corners: &'a [DVec3],
    /// The direction to the sun in the world, of length 1.
    pub towards_sun: DVec3,
    /// What is up in the world, of length 1.
    pub up: DVec3,
}

/// A view from the sun, far away: a pinhole camera, whose rays are as good as parallel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunView {
    /// The camera: a square picture.
    pub camera: Pinhole,
    /// Its pose.
    pub pose: Pose,
    /// The depths of what is nearest to the sun and of what is farthest.
    pub depths: [f64; 2],
    /// It serves the points at depths below this in the camera that sees the shadows; those of the view before are that one's.
    pub until: f64,
    /// The side of a pixel, in world units.
    pub pixel: f64,
    /// What it has to show.
    pub extent: Extent,
    /// The radius of the widest penumbra, that of the tip of a tree on level ground, in world units.
    pub penumbra: f64,
}

impl SunView {
    /// Returns whether it shows all that another one has to show, from the same sun.
    pub fn holds(&self, other: &Self) -> bool {
        // Its middle is rounded to pixels.
        let half = self.pixel * (0.5 * f64::from(self.camera.width) - MARGIN_PX + 1.0);
        let middle = -self.pose.translation.truncate();
        let Extent { low, high } = other.extent;
        self.pose.rotation == other.pose.rotation
            && low.cmpge(middle - half).all()
            && high.cmple(middle + half).all()
    }

    /// Returns whether it is drawn as another one.
    pub fn is_drawn_as(&self, other: &Self) -> bool {
        Self { until: other.until, extent: other.extent, ..*self } == *other
    }
}

/// Returns the views from the sun for what a camera sees, each `side` pixels wide, from near to far, with `room` on each side, as a
/// share of what they have to show. There are none where no shadow falls on what it sees.
///
/// The depths at which shadows may fall, from z to z', are divided into up to three parts, each as many times as deep as the one
/// before. A view shows of its part what has a tree between itself and the sun.
pub fn sun_views(camera: &Pinhole, pose: &Pose, scene: &SunScene<'_>, side: u32, room: f64) -> Vec<SunView> {
    let frame = SunFrame::new(scene);
    let Some([nearest, farthest]) = frame.depths_of_shadows(pose, scene) else { return Vec::new() };
    let count = ((farthest / nearest).log(DEPTH_RATIO).ceil() as usize).clamp(1, MOST_SUN_VIEWS);
    let border = |index: usize| nearest * (farthest / nearest).powf(index as f64 / count as f64);
    let view = |index: usize| {
        let from = if index == 0 { 0.0 } else { (1.0 - TAKES_OVER) * border(index) };
        let until = border(index + 1);
        let seen = frame.around_part(camera, pose, [from, until]);
        let least = LEAST_PIXEL[0] * border(index) / camera.fx.min(camera.fy);
        frame.view(seen, until, least, side, room)
    };
    (0..count).map(view).collect()
}

/// A rectangle across the sun's rays, in world units along the sun's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    low: DVec2,
    high: DVec2,
}

impl Extent {
    const NOTHING: Self = Self { low: DVec2::INFINITY, high: DVec2::NEG_INFINITY };

    fn with(self, point: DVec2, radius: f64) -> Self {
        Self { low: self.low.min(point - radius), high: self.high.max(point + radius) }
    }

    /// Returns the same with room around it, as a share of its longer side.
    fn with_room(self, room: f64) -> Self {
        let room = room * (self.high - self.low).max_element();
        Self { low: self.low - room, high: self.high + room }
    }

    /// Returns what is in both; a point where nothing is.
    fn and_within(self, other: &Self) -> Self {
        let low = self.low.max(other.low).min(other.high);
        Self { low, high: self.high.min(other.high).max(low) }
    }
}

/// The sun's axes, and the extent of everything along them.
struct SunFrame {
    /// Rows: right, down, away from the sun.
    sun_from_world: DMat3,
    /// The trees that cast shadows.
    casters: Extent,
    /// The smallest and the largest coordinate away from the sun.
    away: [f64; 2],
    /// The largest coordinate away from the sun of a face: no shadow falls farther away.
    floor: f64,
    /// The radius of the widest penumbra.
    penumbra: f64,
}

impl SunFrame {
    fn new(scene: &SunScene<'_>) -> Self {
        let right = scene.towards_sun.any_orthonormal_vector();
        let down = right.cross(scene.towards_sun);
        let sun_from_world = DMat3::from_cols(right, down, -scene.towards_sun).transpose();
        let (mut casters, mut away) = (Extent::NOTHING, [f64::INFINITY, f64::NEG_INFINITY]);
        let mut add = |from: f64, to: f64| away = [away[0].min(from), away[1].max(to)];
        let mut longest = 0.0f64;
        for Ball { middle, radius } in scene.casters {
            let at = sun_from_world * *middle;
            casters = casters.with(at.truncate(), *radius);
            add(at.z - radius, at.z + radius);
            longest = longest.max(2.0 * radius);
        }
        let along = scene.corners.iter().map(|corner| sun_from_world.row(2).dot(*corner));
        let [top, floor] =
            along.fold([f64::INFINITY, f64::NEG_INFINITY], |[top, floor], at| [top.min(at), floor.max(at)]);
        if top <= floor {
            add(top, floor);
        }
        let penumbra = SUN_TANGENT * longest / scene.towards_sun.dot(scene.up).max(LOWEST_SUN);
        Self { sun_from_world, casters, away, floor, penumbra }
    }

    /// Returns the depths in a camera's frame between which shadows may fall on faces: those of the rays from each tree down to
    /// the farthest face.
    fn depths_of_shadows(&self, pose: &Pose, scene: &SunScene<'_>) -> Option<[f64; 2]> {
        let mut found = [f64::INFINITY, f64::NEG_INFINITY];
        for Ball { middle, radius } in scene.casters {
            let top = self.sun_from_world.row(2).dot(*middle);
            let length = (self.floor - top).max(0.0);
            for end in [*middle, *middle - length * scene.towards_sun] {
                let depth = pose.camera_from_world(end).z;
                found = [found[0].min(depth - radius), found[1].max(depth + radius)];
            }
        }
        let [nearest, farthest] = found;
        let least = farthest / DEPTH_RATIO.powi(MOST_SUN_VIEWS as i32);
        (farthest > 0.0 && self.floor.is_finite()).then(|| [nearest.max(least), farthest])
    }

    /// Returns what a camera sees between two depths.
    fn around_part(&self, camera: &Pinhole, pose: &Pose, depths: [f64; 2]) -> Extent {
        let [width, height] = [camera.width, camera.height].map(f64::from);
        let mut extent = Extent::NOTHING;
        for depth in depths {
            for [x, y] in [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]] {
                let ray = camera.ray_in_camera(DVec2::new(x, y));
                let point = pose.world_from_camera(depth * ray);
                extent = extent.with((self.sun_from_world * point).truncate(), 0.0);
            }
        }
        extent
    }

    /// Makes the view of what a camera sees, which serves until a depth, with pixels of a least size, and with room.
    fn view(&self, seen: Extent, until: f64, least: f64, side: u32, room: f64) -> SunView {
        let extent = seen.and_within(&self.casters);
        let shown = extent.with_room(room).and_within(&self.casters);
        let size = (shown.high - shown.low).max_element();
        let least = least.max(LEAST_PIXEL[1] * self.penumbra);
        let finest = (size / (f64::from(side) - 2.0 * MARGIN_PX)).max(least);
        let pixel = ((RUNGS * finest.log2()).ceil() / RUNGS).exp2();
        let middle = ((0.5 * (shown.low + shown.high)) / pixel).round() * pixel;
        let [top, floor] = self.away;
        let distance = (SUN_WIDTHS * pixel * f64::from(side)).max(SUN_LENGTHS * (floor - top));
        let between = 0.5 * (top + floor);
        let eye = middle.extend(between - distance);
        let focal = distance / pixel;
        let centre = 0.5 * f64::from(side);
        let camera = Pinhole { width: side, height: side, fx: focal, fy: focal, cx: centre, cy: centre };
        // Rounding on the device must not cut off what is nearest.
        let slack = 0.01 * (floor - top) + 1e-6 * distance;
        SunView {
            camera,
            pose: Pose { rotation: self.sun_from_world, translation: -eye },
            depths: [distance - (between - top) - slack, distance + (floor - between) + slack],
            until,
            pixel,
            extent,
            penumbra: self.penumbra,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::{centred, look_at};

    const GROUND: [DVec3; 4] = [
        DVec3::new(-50.0, -50.0, 0.0),
        DVec3::new(50.0, -50.0, 0.0),
        DVec3::new(50.0, 50.0, 0.0),
        DVec3::new(-50.0, 50.0, 0.0),
    ];

    fn casters() -> Vec<Ball> {
        (-3..4).map(|x| Ball { middle: DVec3::new(6.0 * f64::from(x), 10.0, 4.0), radius: 3.5 }).collect()
    }

    fn is_in(camera: &Pinhole, px: DVec2) -> bool {
        let size = DVec2::new(f64::from(camera.width), f64::from(camera.height));
        px.cmpge(DVec2::ZERO).all() && px.cmple(size).all()
    }

    #[test]
    fn what_lies_in_a_shadow_before_the_camera_is_in_the_view_of_its_depth_and_so_is_the_tree() {
        let camera = centred(400, 300, 350.0);
        let (casters, mut met) = (casters(), 0);
        for towards_sun in [DVec3::Z, DVec3::new(0.6, -0.4, 0.5), DVec3::new(-0.9, 0.3, 0.1)] {
            let towards_sun = towards_sun.normalize();
            let scene = SunScene { casters: &casters, corners: &GROUND, towards_sun, up: DVec3::Z };
            for eye in
                [DVec3::new(0.0, -20.0, 1.7), DVec3::new(3.0, 9.0, 1.7), DVec3::new(-60.0, -60.0, 50.0)]
            {
                let pose = look_at(eye, DVec3::new(1.0, 12.0, 0.0));
                let views = sun_views(&camera, &pose, &scene, 1024, 0.0);
                assert!((1..=MOST_SUN_VIEWS).contains(&views.len()));
                assert!(views.windows(2).all(|two| two[0].until < two[1].until), "from near to far");
                for Ball { middle, radius } in &casters {
                    for from in [DVec3::ZERO, 0.9 * radius * DVec3::X, -0.9 * radius * DVec3::Y] {
                        let leaf = *middle + from;
                        let ground = leaf - leaf.z / towards_sun.z * towards_sun;
                        let seen = pose.camera_from_world(ground);
                        let px = camera.image_from_camera(seen).filter(|px| is_in(&camera, *px));
                        let is_on_ground = ground.abs().max_element() < 50.0;
                        if px.is_none() || !is_on_ground {
                            continue;
                        }
                        met += 1;
                        let serves = views.iter().find(|view| seen.z <= view.until).unwrap();
                        let at = |point: DVec3| {
                            let in_sun = serves.pose.camera_from_world(point);
                            let [near, far] = serves.depths;
                            assert!(near < in_sun.z && in_sun.z < far, "{in_sun} {near} {far}");
                            serves.camera.image_from_camera(in_sun).unwrap()
                        };
                        let (shadow, leaf) = (at(ground), at(leaf));
                        assert!(is_in(&serves.camera, shadow), "{shadow}");
                        // The rays are almost parallel.
                        assert!(shadow.distance(leaf) < 1.0, "{shadow} {leaf}");
                    }
                }
            }
        }
        assert!(met > 30, "{met} shadows are on the ground in view");
    }

    #[test]
    fn near_by_pixels_are_finer_than_far_away() {
        let (camera, casters) = (centred(400, 300, 350.0), casters());
        let towards_sun = DVec3::new(0.6, -0.4, 0.5).normalize();
        let scene = SunScene { casters: &casters, corners: &GROUND, towards_sun, up: DVec3::Z };
        let pose = look_at(DVec3::new(-24.0, 8.0, 1.7), DVec3::new(0.0, 10.0, 1.0));
        let views = sun_views(&camera, &pose, &scene, 1024, 0.0);
        assert_eq!(views.len(), 3);
        assert!(views[0].pixel <= views[1].pixel && views[1].pixel < views[2].pixel);
        // Near by they are no finer than a penumbra asks for.
        assert!((0.2..0.3).contains(&(views[0].pixel / views[0].penumbra)), "{:?}", views[0]);
        // A camera that turns a little sees shadows from the same pixels.
        let turned = look_at(DVec3::new(-24.0, 8.0, 1.7), DVec3::new(0.0, 10.1, 1.0));
        assert_eq!(sun_views(&camera, &turned, &scene, 1024, 0.0)[2].pixel, views[2].pixel);
    }

    #[test]
    fn views_with_room_hold_what_cameras_near_by_see_and_those_without_hold_their_own() {
        let (camera, casters) = (centred(400, 300, 350.0), casters());
        let towards_sun = DVec3::new(0.6, -0.4, 0.5).normalize();
        let scene = SunScene { casters: &casters, corners: &GROUND, towards_sun, up: DVec3::Z };
        let views = |x: f64, room: f64| {
            let pose = look_at(DVec3::new(x, 8.0, 1.7), DVec3::new(0.0, 10.0, 1.0));
            sun_views(&camera, &pose, &scene, 1024, room)
        };
        let held = |held: &[SunView], wanted: &[SunView]| {
            held.iter().zip(wanted).filter(|(held, wanted)| held.holds(wanted)).count()
        };
        for x in [-24.0, -23.7, -10.3, 5.1] {
            let [tight, wide] = [0.0, 0.2].map(|room| views(x, room));
            assert_eq!([held(&tight, &tight), held(&wide, &wide), held(&wide, &tight)], [tight.len(); 3]);
            assert!(tight.iter().zip(&views(x, 0.0)).all(|(a, b)| a.is_drawn_as(b)));
        }
        let (tight, wide) = (views(-24.0, 0.0), views(-24.0, 0.2));
        assert!(!tight[0].is_drawn_as(&wide[0]));
        assert_eq!(held(&wide, &views(-23.9, 0.2)), 3);
        assert!(held(&tight, &views(-10.0, 0.0)) < 3 && held(&wide, &views(-10.0, 0.2)) < 3);
    }

    #[test]
    fn without_faces_or_trees_before_the_camera_there_are_none() {
        let (camera, casters) = (centred(400, 300, 350.0), casters());
        let views = |corners: &[DVec3], casters: &[Ball], y: f64| {
            let scene = SunScene { casters, corners, towards_sun: DVec3::Z, up: DVec3::Z };
            sun_views(&camera, &look_at(DVec3::new(0.0, 0.0, 1.7), DVec3::new(0.0, y, 1.7)), &scene, 64, 0.0)
                .len()
        };
        assert!(views(&GROUND, &casters, 1.0) > 0);
        assert_eq!(
            [views(&GROUND, &casters, -1.0), views(&[], &casters, 1.0), views(&GROUND, &[], 1.0)],
            [0; 3]
        );
    }
}
