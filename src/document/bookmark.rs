//! Saved views, which the user can return to.

use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

use quadratura_base::geometry::Pose;
use quadratura_view::flight::FrameLens;
use quadratura_view::navigation::Viewpoint;

/// The index of a bookmark in the project.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BookmarkIndex(pub usize);

/// A saved view.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bookmark {
    /// The name; several bookmarks may have the same one.
    pub name: String,
    /// The camera centre in the world.
    pub position: [f64; 3],
    /// The rotation from world to camera, as COLMAP writes it: w, x, y, z.
    pub rotation: [f64; 4],
    /// The focal lengths along x and y, in picture heights.
    pub focal: [f64; 2],
    /// The principal point relative to the picture's centre, in picture heights.
    #[serde(default)]
    pub shift: [f64; 2],
    /// The point that orbiting turns around, in the world.
    pub pivot: [f64; 3],
}

impl Bookmark {
    /// Makes a bookmark of a view.
    pub fn new(name: impl Into<String>, view: &Viewpoint) -> Self {
        let turn = DQuat::from_mat3(&view.pose.rotation);
        Self {
            name: name.into(),
            position: view.position().to_array(),
            rotation: [turn.w, turn.x, turn.y, turn.z],
            focal: view.lens.focal,
            shift: view.lens.shift,
            pivot: view.pivot.to_array(),
        }
    }

    /// Returns the view.
    pub fn viewpoint(&self) -> Viewpoint {
        let [w, x, y, z] = self.rotation;
        let rotation = DMat3::from_quat(DQuat::from_xyzw(x, y, z, w).normalize());
        let position = DVec3::from_array(self.position);
        Viewpoint {
            pose: Pose { rotation, translation: -(rotation * position) },
            lens: FrameLens { focal: self.focal, shift: self.shift },
            pivot: DVec3::from_array(self.pivot),
        }
    }

    /// Returns a sentence that says why the bookmark cannot be a view, or `None` if it can.
    pub fn problem(&self) -> Option<String> {
        let numbers = self.position.iter().chain(&self.pivot).chain(&self.shift);
        let turn = self.rotation.iter().map(|part| part * part).sum::<f64>();
        // NaN compares false, too.
        let fine = numbers.copied().all(|number| number.abs() <= 1e15)
            && turn > 1e-12
            && turn < 1e12
            && self.focal.iter().all(|focal| *focal > 1e-3 && *focal < 1e4);
        (!fine).then(|| {
            format!(
                "the view {:?} is not valid: expected a position and a pivot within 1e15 of 0, a rotation \
                 w, x, y, z, and \
                 focal lengths of 0.001 to 10000 heights of the picture",
                self.name
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::{centred, look_at};

    #[test]
    fn a_kept_view_comes_back_and_an_impossible_one_is_told() {
        let pose = look_at(DVec3::new(3.0, -8.0, 2.0), DVec3::ZERO);
        let view = Viewpoint::of_camera(&centred(640, 480, 500.0), &pose, DVec3::ZERO);
        let kept = Bookmark::new("gate", &view);
        let text = serde_json::to_string(&kept).unwrap();
        let back = serde_json::from_str::<Bookmark>(&text).unwrap().viewpoint();
        assert!((back.position() - view.position()).length() < 1e-9 && back.lens == view.lens);
        assert!((back.pivot - view.pivot).length() < 1e-12);
        assert_eq!(kept.problem(), None);
        let flat = Bookmark { rotation: [0.0; 4], ..kept };
        assert!(flat.problem().unwrap().contains("gate"));
    }
}
