//! Where the faces of a view are, to tell what a blended view shows of a face from what it shows behind one.

use std::sync::Arc;

use glam::DVec2;
use rayon::prelude::*;

use crate::ldi::Blended;
use crate::ldi::cracks::Shows;
use crate::projection::{Shot, shown_face};
use crate::scene::impostor::Facing;
use crate::scene::{FaceId, Model};

/// The share of a face's inverse depth below which a pixel shows something behind the face, and of the pixel's below which the face
/// is behind it. Relief reaches 0.06 of the photos' distance along the normal, so seen from 37 degrees or more to the face at that distance it
/// moves surfaces by less. Of faces that are seen at a glance, relief may count as something else; then at most a single pixel between
/// others gets their colours.
const BEHIND: f64 = 0.9;

/// The planes of a model's faces in a view.
struct FaceDepths<'a> {
    model: Arc<Model>,
    shot: &'a Shot,
}

impl FaceDepths<'_> {
    /// Returns the inverse depth of a face's plane at the centre of a pixel; `None` where the plane is not before the camera, and for
    /// see-through faces, behind which other surfaces are seen.
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
/// [`crate::projection::Renders::seen_faces`]. Where there is none, and where nothing is drawn, nothing is wrong.
pub fn shown(blended: &Blended, faces: &[u32], model: &Arc<Model>, shot: &Shot) -> Vec<Shows> {
    let width = shot.camera.width as usize;
    let depths = FaceDepths { model: model.facing(&Facing::of_pose(&shot.pose)), shot };
    let apart = |at: usize| {
        let face = shown_face(faces[at]).and_then(|face| depths.at(face, [at % width, at / width]));
        match (face, f64::from(blended.inverse_depths[at])) {
            _ if blended.picture.pixels()[at][3] == 0 => Shows::Face,
            (Some(face), found) if found < BEHIND * face => Shows::Behind,
            (Some(face), found) if face < BEHIND * found => Shows::Before,
            _ => Shows::Face,
        }
    };
    let shows = |at: usize| match (faces[at], blended.invented[at]) {
        (0, _) => Shows::Face,
        (_, true) => Shows::Filling,
        _ => apart(at),
    };
    (0..faces.len()).into_par_iter().map(shows).collect()
}

/// Returns the faces that images show, by pixel: those of `faces` but for billboards that turn towards the camera. These have a place
/// of their own in each photo, and a view from images would show them from the side. Where a view has such faces, what images show
/// before another face is one of them, too. All this is 0, as where no face is.
pub fn shown_by_images(faces: &[u32], shows: &[Shows], model: &Model) -> Vec<u32> {
    let turns = |number: u32| shown_face(number).is_some_and(|face| model.impostor(face).is_some());
    if !faces.par_iter().any(|number| turns(*number)) {
        return faces.to_vec();
    }
    let is_shown = |number: u32, shows: Shows| !turns(number) && shows != Shows::Before;
    let pixels = faces.par_iter().zip(shows);
    pixels.map(|(number, shows)| if is_shown(*number, *shows) { *number } else { 0 }).collect()
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
        let (model, shot) = (modeller.finish(), Shot::new(centred(7, 1, 3.0), camera_is_world()));
        let blended = Blended {
            picture: Picture { width: 7, height: 1, rgba: [[255; 24].to_vec(), vec![0; 4]].concat() },
            invented: vec![false, false, false, false, true, true, false],
            // A little behind the wall, far behind it, far before it, far behind the turned one; filled in; where no face is; empty.
            inverse_depths: vec![0.235, 0.2, 0.3, 0.25, 0.25, 0.1, 0.0],
        };
        use Shows::{Before, Behind, Face, Filling};
        let faces = [1, 1, 1, 2, 1, 0, 1];
        let found = shown(&blended, &faces, &model, &shot);
        assert_eq!(found, [Face, Behind, Before, Behind, Filling, Face, Face]);
        assert_eq!(shown_by_images(&faces, &found, &model), faces, "nothing turns");
    }

    #[test]
    fn billboards_that_turn_are_left_to_the_renderer_and_so_is_what_is_before_faces_beside_them() {
        let mut modeller = Modeller::new();
        modeller.object("wall").screen(4.0, [-2.0, -2.0, 2.0, 2.0]);
        modeller.object("tree.billboard").screen(2.0, [-0.5, -1.0, 0.5, 1.0]);
        let is_tree = |object: &crate::scene::Object| object.name == "tree.billboard";
        let (model, refused) = (*modeller.finish()).clone().with_impostors(DVec3::NEG_Y, is_tree);
        assert!(refused.is_empty());
        use Shows::{Before, Behind, Face};
        let shows = [Face, Before, Behind, Face, Face];
        assert_eq!(shown_by_images(&[1, 1, 1, 2, 0], &shows, &model), [1, 0, 1, 0, 0]);
        assert_eq!(shown_by_images(&[1, 1, 1, 1, 0], &shows, &model), [1, 1, 1, 1, 0]);
    }
}
