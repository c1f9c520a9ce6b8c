//! Edits of a camera path, made on the timeline.

use glam::{DQuat, DVec3};

use super::camera_path::{CameraPath, KeyframeIndex, PATH_VERSION, PathKeyframe, PathSpeed};
use quadratura_view::navigation::Viewpoint;

/// The least time between two keyframes in seconds; closer ones replace each other.
pub const LEAST_APART_S: f64 = 0.01;

impl CameraPath {
    /// Makes a path without keyframes, with frames of `size` pixels.
    pub fn empty(size: [u32; 2]) -> Self {
        Self {
            version: PATH_VERSION,
            size,
            fps: 25.0,
            speed: PathSpeed::default(),
            up: None,
            keyframes: Vec::new(),
        }
    }

    /// Adds a keyframe at a time; a keyframe that is there is replaced.
    pub fn set(&mut self, time_s: f64, view: &Viewpoint) {
        let turn = DQuat::from_mat3(&view.pose.rotation);
        let keyframe = PathKeyframe {
            t: time_s,
            position: view.position().to_array(),
            look_at: None,
            rotation: Some([turn.w, turn.x, turn.y, turn.z]),
            fov: None,
            K: Some(view.camera(self.size[0], self.size[1]).matrix_rows()),
        };
        self.keyframes.retain(|frame| (frame.t - time_s).abs() >= LEAST_APART_S);
        let index = self.keyframes.partition_point(|frame| frame.t < time_s);
        self.keyframes.insert(index, keyframe);
    }

    /// Removes a keyframe.
    pub fn remove(&mut self, KeyframeIndex(index): KeyframeIndex) {
        if index < self.keyframes.len() {
            self.keyframes.remove(index);
        }
    }

    /// Moves a keyframe to another time between its neighbours, so that the order stays.
    pub fn shift(&mut self, KeyframeIndex(index): KeyframeIndex, time_s: f64) {
        let neighbour =
            |index: Option<usize>| index.and_then(|index| self.keyframes.get(index)).map(|frame| frame.t);
        let earliest = neighbour(index.checked_sub(1)).map_or(0.0, |t| t + LEAST_APART_S);
        let latest = neighbour(Some(index + 1)).map_or(f64::INFINITY, |t| t - LEAST_APART_S);
        if let Some(frame) = self.keyframes.get_mut(index) {
            frame.t = time_s.max(earliest).min(latest);
        }
    }

    /// Changes the frame size in pixels; vertical fields of view stay.
    pub fn resize(&mut self, size: [u32; 2]) {
        let [width, height] = size.map(|side| f64::from(side.max(1)));
        let old = self.size.map(f64::from);
        for matrix in self.keyframes.iter_mut().filter_map(|frame| frame.K.as_mut()) {
            let scale = height / old[1];
            let [[fx, _, cx], [_, fy, cy], _] = *matrix;
            let cx = (cx - old[0] / 2.0) * scale + width / 2.0;
            *matrix = [[fx * scale, 0.0, cx], [0.0, fy * scale, cy * scale], [0.0, 0.0, 1.0]];
        }
        self.size = size.map(|side| side.max(1));
    }

    /// Returns a sentence that says why the path cannot be flown, or `None` if it can or has no keyframes yet.
    pub fn problem(&self) -> Option<String> {
        let flown = (!self.keyframes.is_empty()).then(|| self.flight(DVec3::Z))?;
        flown.err().map(|(place, found)| format!("{place}: {found}"))
    }

    /// Returns the time of the last keyframe in seconds; 0 where there is none.
    pub fn end_s(&self) -> f64 {
        self.keyframes.last().map_or(0.0, |frame| frame.t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::{centred, look_at};

    fn view(x: f64) -> Viewpoint {
        let pose = look_at(DVec3::new(x, -8.0, 2.0), DVec3::ZERO);
        Viewpoint::of_camera(&centred(640, 480, 500.0), &pose, DVec3::ZERO)
    }

    #[test]
    fn keyframes_stay_in_order_and_apart_whatever_is_done_to_them() {
        let mut path = CameraPath::empty([320, 240]);
        [4.0, 0.0, 2.0, 2.001].iter().for_each(|time_s| path.set(*time_s, &view(*time_s)));
        let times = |path: &CameraPath| path.keyframes.iter().map(|frame| frame.t).collect::<Vec<_>>();
        assert_eq!(times(&path), [0.0, 2.001, 4.0], "what is as good as at the same time is replaced");
        path.shift(KeyframeIndex(1), 9.0);
        assert_eq!(times(&path)[1], 4.0 - LEAST_APART_S);
        path.shift(KeyframeIndex(0), -3.0);
        assert_eq!(times(&path)[0], 0.0);
        let flight = path.flight(DVec3::Z).unwrap();
        assert!((flight.at(4.0).1.center_in_world() - view(4.0).position()).length() < 1e-9);
        path.remove(KeyframeIndex(1));
        path.remove(KeyframeIndex(7));
        assert_eq!((path.keyframes.len(), path.end_s()), (2, 4.0));
    }

    #[test]
    fn another_size_shows_the_same_from_top_to_bottom() {
        let mut path = CameraPath::empty([320, 240]);
        path.set(0.0, &view(1.0));
        let lens = |path: &CameraPath| path.flight(DVec3::Z).unwrap().at(0.0).0;
        let before = lens(&path);
        path.resize([1920, 1080]);
        let after = lens(&path);
        assert_eq!([after.width, after.height], [1920, 1080]);
        assert!((after.fy / 1080.0 - before.fy / 240.0).abs() < 1e-12);
        assert!((after.cx - 960.0).abs() < 1e-9);
    }
}
