//! Where the faces of a view are, to tell what a blended view shows of a face from what it shows behind one.

use std::sync::Arc;

use glam::DVec2;
use rayon::prelude::*;

use crate::ldi::Blended;
use crate::ldi::cracks::Shows;
use crate::projection::{Shot, shown_face};
use crate::scene::impostor::Facing;
use crate::scene::{FaceId, Model};

/// The share of a face's inverse depth below which a pixel shows something behind the face. Relief moves surfaces off their faces'
/// planes by less.
const BEHIND: f64 = 0.9;

/// The planes of a model's faces in a view.
struct FaceDepths<'a> {
    model: Arc<Model>,
    shot: &'a Shot,
}

impl FaceDepths<'_> {
    /// Returns the inverse depth of a face's plane at the centre of a pixel; `None` where the plane is not before the camera, and where
    /// one sees through the face: what is behind it shows rightly.
    fn at(&self, face: FaceId, [x, y]: [usize; 2]) -> Option<f64> {
        if self.model.sees_through(face) {
            return None;
        }
        let Shot { camera, pose, .. } = self.shot;
        let plane = &self.model.face(face).plane;
        let ray =
            pose.rotation.transpose() * camera.ray_in_camera(DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
        let inverse_depth = -plane.normal.dot(ray) / plane.signed_distance(pose.center_in_world());
        (inverse_depth > 0.0 && inverse_depth.is_finite()).then_some(inverse_depth)
    }
}

/// Returns what each pixel of a blended view shows of its face. `faces` are those of
/// [`crate::projection::Renders::seen_faces`]; where there is none, nothing is wrong.
pub fn shown(blended: &Blended, faces: &[u32], model: &Arc<Model>, shot: &Shot) -> Vec<Shows> {
    let width = shot.camera.width as usize;
    let depths = FaceDepths { model: model.facing(&Facing::of_pose(&shot.pose)), shot };
    let is_behind = |at: usize| {
        let of_face = shown_face(faces[at]).and_then(|face| depths.at(face, [at % width, at / width]));
        of_face.is_some_and(|of_face| f64::from(blended.inverse_depths[at]) < BEHIND * of_face)
    };
    let shows = |at: usize| match (faces[at], blended.invented[at]) {
        (0, _) => Shows::Face,
        (_, true) => Shows::Filling,
        _ if is_behind(at) => Shows::Behind,
        _ => Shows::Face,
    };
    (0..faces.len()).into_par_iter().map(shows).collect()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::projection::Picture;
    use crate::scene::synthetic::{Modeller, camera_is_world, centred};

    /// A wall at depth 4, and one that the camera sees from behind, at depth 2.
    #[test]
    fn what_is_far_behind_a_face_is_told_from_what_is_near_its_plane() {
        let mut modeller = Modeller::new();
        modeller.object("wall").screen(4.0, [-2.0, -2.0, 2.0, 2.0]);
        modeller.object("turned").quad_facing(DVec3::Z, DVec3::new(-1.0, -1.0, 2.0), DVec3::X, DVec3::Y);
        let (model, shot) = (modeller.finish(), Shot::new(centred(6, 1, 3.0), camera_is_world()));
        let blended = Blended {
            picture: Picture { width: 6, height: 1, rgba: vec![255; 24] },
            invented: vec![false, false, false, false, true, true],
            // On the wall, a little behind it, far behind it, far behind the turned one, where no face is.
            inverse_depths: vec![0.25, 0.235, 0.2, 0.25, 0.25, 0.1],
        };
        use Shows::{Behind, Face, Filling};
        let found = shown(&blended, &[1, 1, 1, 2, 1, 0], &model, &shot);
        assert_eq!(found, [Face, Face, Behind, Behind, Filling, Face]);
    }
}
