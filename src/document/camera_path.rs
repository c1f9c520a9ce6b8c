//! Camera paths: files of keyframes that a flight passes through (see `docs/formats.md`).

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use quadratura_base::geometry::{Pinhole, Pose, Similarity};
use quadratura_view::flight::{Aim, Flight, FrameLens, Keyframe, Speed};

/// The version of the format that this program writes, and the only one that it reads.
pub const PATH_VERSION: u32 = 1;

/// The longest permitted side of a frame in pixels, far beyond any film format.
pub(super) const LONGEST_SIDE: u32 = 16_384;
/// The most permitted frames of a flight.
const MOST_FRAMES: f64 = 100_000.0;

/// A problem of a camera path: where it is, and what was found there.
pub type PathFlaw = (String, String);

/// A camera path as it is in its file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraPath {
    /// The format's version, [`PATH_VERSION`].
    pub version: u32,
    /// The width and height of a frame in pixels.
    pub size: [u32; 2],
    /// The frame rate in frames per second.
    #[serde(default = "usual_fps")]
    pub fps: f64,
    /// The rule for the flight's speed.
    #[serde(default)]
    pub speed: PathSpeed,
    /// The direction of the world that is up in the pictures of keyframes with `look_at`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<[f64; 3]>,
    /// The keyframes, by ascending time.
    pub keyframes: Vec<PathKeyframe>,
}

/// A rule for the speed of a flight.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PathSpeed {
    /// The flight passes each keyframe at its time.
    #[default]
    Timed,
    /// The flight has constant speed from the first keyframe's time to the last one's.
    Constant,
    /// The flight has constant speed except for a soft start and a soft end.
    Eased,
}

/// The index of a keyframe in [`CameraPath::keyframes`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct KeyframeIndex(pub usize);

/// The camera at one time. Exactly one of `look_at` and `rotation`, and one of `fov` and `K`, is given.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
pub struct PathKeyframe {
    /// The time in seconds.
    pub t: f64,
    /// The camera centre in the world.
    pub position: [f64; 3],
    /// The point of the world that is in the middle of the picture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub look_at: Option<[f64; 3]>,
    /// The rotation from world to camera, as COLMAP writes it: w, x, y, z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<[f64; 4]>,
    /// The vertical field of view in degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fov: Option<f64>,
    /// The 3 x 3 camera matrix, in pixels of `size`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub K: Option<[[f64; 3]; 3]>,
}

/// Returns the default frame rate.
fn usual_fps() -> f64 {
    25.0
}

impl CameraPath {
    /// Returns the same flight after a transform of the world.
    pub fn moved(&self, by: &Similarity) -> Self {
        let point = |at: [f64; 3]| by.apply(DVec3::from_array(at)).to_array();
        let turn = DQuat::from_mat3(&by.rotation);
        let keyframe = |keyframe: &PathKeyframe| PathKeyframe {
            position: point(keyframe.position),
            look_at: keyframe.look_at.map(point),
            rotation: keyframe.rotation.map(|[w, x, y, z]| {
                let turned = DQuat::from_xyzw(x, y, z, w) * turn.inverse();
                [turned.w, turned.x, turned.y, turned.z]
            }),
            ..keyframe.clone()
        };
        Self {
            up: self.up.map(|up| (by.rotation * DVec3::from_array(up)).to_array()),
            keyframes: self.keyframes.iter().map(keyframe).collect(),
            ..self.clone()
        }
    }

    /// Makes a path through cameras, `seconds` from one to the next, with frames of `size`. The flight is at rest
    /// at the first and at the last one.
    pub fn through(cameras: &[(Pinhole, Pose)], size: [u32; 2], seconds: f64) -> Self {
        let keyframe = |(i, (camera, pose)): (usize, &(Pinhole, Pose))| {
            let turn = DQuat::from_mat3(&pose.rotation);
            PathKeyframe {
                t: i as f64 * seconds,
                position: pose.center_in_world().to_array(),
                look_at: None,
                rotation: Some([turn.w, turn.x, turn.y, turn.z]),
                fov: None,
                K: Some(FrameLens::from_camera(camera).camera(size[0], size[1]).matrix_rows()),
            }
        };
        Self {
            version: PATH_VERSION,
            size,
            fps: usual_fps(),
            speed: PathSpeed::Eased,
            up: None,
            keyframes: cameras.iter().enumerate().map(keyframe).collect(),
        }
    }

    /// Returns the flight that the path describes. `up` is used where the file gives none.
    ///
    /// # Errors
    /// Returns the first problem that is found.
    pub fn flight(&self, up: DVec3) -> Result<Flight, PathFlaw> {
        self.judge()?;
        let of_keyframe = |i: usize| format!("keyframe {}", i + 1);
        let keyframe = |(i, frame): (usize, &PathKeyframe)| {
            self.keyframe(frame).map_err(|found| (of_keyframe(i), found))
        };
        let keyframes = self.keyframes.iter().enumerate().map(keyframe).collect::<Result<Vec<_>, _>>()?;
        let speed = match self.speed {
            PathSpeed::Timed => Speed::Timed,
            PathSpeed::Constant => Speed::Constant,
            PathSpeed::Eased => Speed::Eased,
        };
        let up = self.up.map_or(up, DVec3::from_array);
        Flight::new(&keyframes, self.size, speed, up).map_err(|(i, found)| (of_keyframe(i), found))
    }

    /// Checks everything that does not concern a single keyframe.
    fn judge(&self) -> Result<(), PathFlaw> {
        let flaw = |place: &str, found: String| Err((place.to_owned(), found));
        if self.version != PATH_VERSION {
            return flaw("version", format!("version {}, this program reads {PATH_VERSION}", self.version));
        }
        if self.size.iter().any(|side| !(1..=LONGEST_SIDE).contains(side)) {
            let [w, h] = self.size;
            return flaw("size", format!("{w} x {h} pixels; sides are 1 to {LONGEST_SIDE}"));
        }
        if !(self.fps > 0.0 && self.fps <= 1000.0) {
            return flaw("fps", format!("{} frames per second; expected above 0, at most 1000", self.fps));
        }
        if self.up.is_some_and(|up| !(1e-6..1e6).contains(&DVec3::from_array(up).length())) {
            return flaw("up", "no direction; write one such as [0, 0, 1]".into());
        }
        self.check_frame_count()
    }

    /// Checks that the number of frames is at most 100,000. Call it again where `fps` is not the file's own.
    ///
    /// # Errors
    /// Returns a problem when there are too many frames.
    pub fn check_frame_count(&self) -> Result<(), PathFlaw> {
        let times = self.keyframes.first().zip(self.keyframes.last());
        let seconds = times.map_or(0.0, |(first, last)| last.t - first.t);
        // NaN compares false, too; so do the other comparisons here.
        let is_possible = seconds * self.fps <= MOST_FRAMES;
        if !is_possible {
            let found =
                format!("{seconds} s at {} frames per second make more than {MOST_FRAMES} frames", self.fps);
            return Err(("keyframes".into(), found));
        }
        Ok(())
    }

    /// Converts a keyframe; the error says what was found instead of a valid one.
    fn keyframe(&self, frame: &PathKeyframe) -> Result<Keyframe, String> {
        let mut numbers = frame.position.iter().chain(frame.look_at.iter().flatten()).chain([&frame.t]);
        if !numbers.all(|number| number.abs() <= 1e15) {
            return Err("a number that is not within 1e15 of 0".into());
        }
        let aim = match (frame.look_at, frame.rotation) {
            (Some(point), None) => Aim::At(point.into()),
            (None, Some(turn)) => Aim::Rotation(rotation(turn)?.conjugate()),
            _ => return Err("expected one of look_at and rotation".into()),
        };
        let lens = match (frame.fov, frame.K) {
            (Some(fov), None) if fov > 0.1 && fov < 179.0 => FrameLens::with_field_of_view(fov.to_radians()),
            (Some(fov), None) => {
                return Err(format!("a field of view of {fov} degrees; 0.1 to 179 is possible"));
            }
            (None, Some(matrix)) => lens(matrix, self.size)?,
            _ => return Err("expected one of fov and K".into()),
        };
        Ok(Keyframe { time_s: frame.t, position: frame.position.into(), aim, lens })
    }
}

/// Converts a quaternion w, x, y, z of any reasonable length.
fn rotation([w, x, y, z]: [f64; 4]) -> Result<DQuat, String> {
    let turn = DQuat::from_xyzw(x, y, z, w);
    let length = turn.length();
    if length > 1e-6 && length < 1e6 {
        Ok(turn.normalize())
    } else {
        Err(format!("the rotation {:?} is not a quaternion w, x, y, z", [w, x, y, z]))
    }
}

/// Converts a camera matrix for frames of the given size in pixels.
fn lens(matrix: [[f64; 3]; 3], [width, height]: [u32; 2]) -> Result<FrameLens, String> {
    let [[fx, skew, cx], [zero, fy, cy], last] = matrix;
    let is_camera = skew == 0.0 && zero == 0.0 && last == [0.0, 0.0, 1.0];
    let side = f64::from(width.max(height));
    let possible = |f: f64| f > 1e-3 * side && f < 1e4 * side;
    let is_near = |c: f64| c.abs() <= 100.0 * side;
    if !(is_camera && possible(fx) && possible(fy) && is_near(cx) && is_near(cy)) {
        return Err("K is not [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] in pixels of size".into());
    }
    Ok(FrameLens::from_camera(&Pinhole { width, height, fx, fy, cx, cy }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(keyframe: &str) -> Result<Flight, PathFlaw> {
        let text = format!(r#"{{"version": 1, "size": [64, 48], "keyframes": [{keyframe}]}}"#);
        serde_json::from_str::<CameraPath>(&text).unwrap().flight(DVec3::Z)
    }

    #[test]
    fn a_path_through_cameras_passes_through_them() {
        let camera = Pinhole { width: 640, height: 480, fx: 500.0, fy: 505.0, cx: 300.0, cy: 250.0 };
        let pose = |angle: f64| {
            let rotation = glam::DMat3::from_rotation_y(angle);
            Pose { rotation, translation: DVec3::new(angle, 2.0, 3.0) }
        };
        let cameras = [0.0, 0.4, 0.9].map(|angle| (camera, pose(angle)));
        let written = serde_json::to_string(&CameraPath::through(&cameras, [320, 240], 2.0)).unwrap();
        let read: CameraPath = serde_json::from_str(&written).unwrap();
        let frames = read.flight(DVec3::Z).unwrap().frames(read.fps);
        assert_eq!(frames.len(), 101);
        for (frame, expected) in [(&frames[0], &cameras[0]), (&frames[100], &cameras[2])] {
            assert!((frame.1.center_in_world() - expected.1.center_in_world()).length() < 1e-9);
            assert!((frame.1.rotation.x_axis - expected.1.rotation.x_axis).length() < 1e-9);
            assert!((frame.0.fx - 250.0).abs() < 1e-9 && (frame.0.cx - 150.0).abs() < 1e-9, "{:?}", frame.0);
        }
    }

    #[test]
    fn each_flaw_is_told_with_its_keyframe() {
        let fine = r#"{"t": 0, "position": [0, 0, 0], "look_at": [1, 0, 0], "fov": 50}"#;
        assert!(path(fine).is_ok());
        for (keyframe, place, message) in [
            ("", "keyframe 1", "no keyframe"),
            (r#"{"t": 0, "position": [0, 0, 0], "fov": 50}"#, "keyframe 1", "look_at and rotation"),
            (r#"{"t": 0, "position": [0, 0, 0], "look_at": [1, 0, 0]}"#, "keyframe 1", "fov and K"),
            (
                r#"{"t": 0, "position": [0, 0, 0], "rotation": [0, 0, 0, 0], "fov": 9}"#,
                "keyframe 1",
                "quaternion",
            ),
            (r#"{"t": 0, "position": [0, 0, 0], "look_at": [1, 0, 0], "fov": 180}"#, "keyframe 1", "180"),
            (&format!("{fine}, {fine}"), "keyframe 2", "after"),
            (&format!("{fine}, {}", fine.replace("\"t\": 0", "\"t\": 1e9")), "keyframes", "frames"),
        ] {
            let (at, found) = path(keyframe).unwrap_err();
            assert!(at == place && found.contains(message), "{keyframe}: {at}: {found}");
        }
    }
}
