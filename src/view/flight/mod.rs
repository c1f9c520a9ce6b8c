//! A camera's flight through keyframes: position, direction and field of view as smooth functions of time.
//!
//! Every channel is a cubic Hermite spline whose velocity at a keyframe is a weighted mean of the slopes to
//! its neighbours, in which the nearer one in time weighs more (Catmull & Rom 1974, for uneven knots: Barry &
//! Goldman, *A Recursive Evaluation Algorithm for a Class of Catmull-Rom Splines*, 1988). The flight passes
//! through its keyframes, and the velocities of position and direction are continuous.

mod pace;
mod spline;
mod turn;

use glam::{DMat3, DQuat, DVec3};

use self::pace::Pace;
use self::spline::Spline;
use self::turn::TurnSpline;
use quadratura_base::geometry::{Pinhole, Pose};

pub use self::pace::Speed;

/// The camera at one time of a flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Keyframe {
    /// The time in seconds; it rises from keyframe to keyframe.
    pub time_s: f64,
    /// The position of the camera's centre, in world coordinates.
    pub position: DVec3,
    /// The direction of the camera.
    pub aim: Aim,
    /// The field of view.
    pub lens: FrameLens,
}

/// The direction of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Aim {
    /// A rotation from the camera frame (x right, y down, z forward) to the world.
    Rotation(DQuat),
    /// A point in world coordinates to look at, with the flight's `up` upwards in the image.
    At(DVec3),
}

/// A pinhole's field of view and principal point, independent of the size in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameLens {
    /// Focal lengths along x and y, in image heights.
    pub focal: [f64; 2],
    /// The principal point relative to the image's centre, in image heights.
    pub shift: [f64; 2],
}

impl FrameLens {
    /// Builds a centred lens with this angle from the image's top to its bottom, in radians.
    pub fn with_field_of_view(vertical_rad: f64) -> Self {
        Self { focal: [0.5 / (vertical_rad / 2.0).tan(); 2], shift: [0.0; 2] }
    }

    /// Converts the intrinsics of a camera.
    pub fn from_camera(camera: &Pinhole) -> Self {
        let (width, height) = (f64::from(camera.width), f64::from(camera.height));
        Self {
            focal: [camera.fx / height, camera.fy / height],
            shift: [(camera.cx - width / 2.0) / height, (camera.cy - height / 2.0) / height],
        }
    }

    /// Returns the intrinsics for images of `width` x `height` pixels.
    pub fn camera(&self, width: u32, height: u32) -> Pinhole {
        let px = f64::from(height);
        Pinhole {
            width,
            height,
            fx: self.focal[0] * px,
            fy: self.focal[1] * px,
            cx: f64::from(width) / 2.0 + self.shift[0] * px,
            cy: px / 2.0 + self.shift[1] * px,
        }
    }
}

/// A camera as a function of time.
#[derive(Debug, Clone)]
pub struct Flight {
    size_px: [u32; 2],
    pace: Pace,
    positions: Spline<3>,
    directions: ViewDirections,
    /// Logarithms of the focal lengths, then the shifts.
    lenses: Spline<4>,
}

#[derive(Debug, Clone)]
enum ViewDirections {
    Turned(TurnSpline),
    /// The points to look at, and the up direction.
    At(Spline<3>, DVec3),
}

impl Flight {
    /// Builds a flight through `keyframes` for images of `size_px`. `up` is a direction of the world, for
    /// keyframes that look at a point. Where all keyframes do, the flight looks at points on a smooth path
    /// between them and never rolls; otherwise rotations are interpolated.
    ///
    /// # Errors
    /// The index of an invalid keyframe, from 0, and a description of the problem.
    pub fn new(
        keyframes: &[Keyframe],
        size_px: [u32; 2],
        speed: Speed,
        up: DVec3,
    ) -> Result<Self, (usize, String)> {
        let rotations = rotations_of(keyframes, up)?;
        let positions: Vec<DVec3> = keyframes.iter().map(|frame| frame.position).collect();
        let times: Vec<f64> = keyframes.iter().map(|frame| frame.time_s).collect();
        let knots = pace::knots(&times, &positions, &rotations, speed);
        let lens = |frame: &Keyframe| {
            let FrameLens { focal: [fx, fy], shift: [x, y] } = frame.lens;
            [fx.ln(), fy.ln(), x, y]
        };
        let mut flight = Self {
            size_px,
            pace: Pace::even(&knots, &times),
            positions: Spline::new(&knots, positions.iter().map(DVec3::to_array).collect()),
            directions: directions(keyframes, &knots, &rotations, up),
            lenses: Spline::new(&knots, keyframes.iter().map(lens).collect()),
        };
        if speed != Speed::Timed {
            flight.pace = Pace::measured(&flight, &knots, &times, speed == Speed::Eased);
        }
        Ok(flight)
    }

    /// Returns the first and the last time, in seconds.
    pub fn span_s(&self) -> [f64; 2] {
        self.pace.span_s()
    }

    /// Returns the camera at a time; times outside of the flight are clamped.
    pub fn at(&self, time_s: f64) -> (Pinhole, Pose) {
        let knot = self.pace.knot_at(time_s);
        let [fx, fy, x, y] = self.lenses.at(knot);
        let lens = FrameLens { focal: [fx.exp(), fy.exp()], shift: [x, y] };
        (lens.camera(self.size_px[0], self.size_px[1]), self.pose(knot))
    }

    /// Returns the cameras of a video with `fps` frames per second, from the first time to the last.
    pub fn frames(&self, fps: f64) -> Vec<(Pinhole, Pose)> {
        let [start, end] = self.span_s();
        let count = ((end - start) * fps).round() as usize;
        // The last frame is the last keyframe, even where the duration is no whole number of frames.
        let time = |i: usize| start + (end - start) * (i as f64 / count.max(1) as f64);
        (0..=count).map(|i| self.at(time(i))).collect()
    }

    fn pose(&self, knot: f64) -> Pose {
        let center = DVec3::from_array(self.positions.at(knot));
        let rotation = match &self.directions {
            ViewDirections::Turned(turns) => DMat3::from_quat(turns.at(knot)).transpose(),
            ViewDirections::At(points, up) => {
                camera_from_world(DVec3::from_array(points.at(knot)) - center, *up)
            }
        };
        Pose { rotation, translation: -(rotation * center) }
    }
}

fn directions(keyframes: &[Keyframe], knots: &[f64], rotations: &[DQuat], up: DVec3) -> ViewDirections {
    let point = |frame: &Keyframe| match frame.aim {
        Aim::At(point) => Some(point.to_array()),
        Aim::Rotation(_) => None,
    };
    match keyframes.iter().map(point).collect::<Option<Vec<_>>>() {
        Some(points) => ViewDirections::At(Spline::new(knots, points), up),
        None => ViewDirections::Turned(TurnSpline::new(knots, rotations)),
    }
}

/// Validates the keyframes and returns their rotations, camera to world.
fn rotations_of(keyframes: &[Keyframe], up: DVec3) -> Result<Vec<DQuat>, (usize, String)> {
    if keyframes.is_empty() {
        return Err((0, "the path has no keyframes".into()));
    }
    for (i, pair) in keyframes.windows(2).enumerate() {
        // The comparison is false for NaN, too.
        let rises = pair[1].time_s > pair[0].time_s;
        if !rises {
            return Err((i + 1, format!("{} s does not come after {} s", pair[1].time_s, pair[0].time_s)));
        }
    }
    let rotation = |(i, frame): (usize, &Keyframe)| match frame.aim {
        Aim::Rotation(rotation) => Ok(rotation.normalize()),
        Aim::At(point) => {
            let forward = point - frame.position;
            let across = forward.normalize_or_zero().cross(up.normalize_or_zero());
            if across.length() < 1e-6 {
                let found = "it looks straight up or down, or at its own position, so its roll is undefined";
                return Err((i, found.into()));
            }
            Ok(DQuat::from_mat3(&camera_from_world(forward, up).transpose()))
        }
    };
    keyframes.iter().enumerate().map(rotation).collect()
}

/// Returns the rotation of a camera that looks along `forward` with `up` upwards: rows right, down, forward.
/// Where the two are parallel, the roll is arbitrary.
fn camera_from_world(forward: DVec3, up: DVec3) -> DMat3 {
    let forward = forward.try_normalize().unwrap_or(DVec3::Z);
    let right = forward.cross(up).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
    DMat3::from_cols(right, forward.cross(right), forward).transpose()
}

#[cfg(test)]
mod tests;
