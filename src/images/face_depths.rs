//! Where the faces of a view are, to tell what a blended view shows of a face from what it shows behind one.

use std::sync::Arc;

use glam::DVec2;
use rayon::prelude::*;

use super::cover::OnRelief;
use quadratura_base::scene::impostor::Facing;
use quadratura_base::scene::{FaceId, Model};
use quadratura_ldi::Blended;
use quadratura_ldi::cracks::Shows;
use quadratura_projection::relief::Relief;
use quadratura_projection::shown_face;
use quadratura_view::Shot;

/// The share of a face's inverse depth below which a pixel shows something behind the face, and of the pixel's below which the face
/// is behind it. 0.95 predicted the fountain's held-out photos 0.02 dB worse, and those of castle and piazza no better.
const BEHIND: f64 = 0.9;

/// The depths of a model's faces in a view.
pub struct FaceDepths<'a> {
    model: Arc<Model>,
    relief: Option<OnRelief>,
    shot: &'a Shot,
}

impl<'a> FaceDepths<'a> {
    /// Prepares the faces of a model, moved to their relief where there is one.
    pub fn new(model: &Arc<Model>, relief: Option<Arc<Relief>>, shot: &'a Shot) -> Self {
        let (camera, pose) = (shot.camera, shot.pose);
        let model = model.facing(&Facing::of_pose(&pose));
        let relief = relief.map(|relief| OnRelief { camera, pose, model: model.clone(), relief });
        Self { model, relief, shot }
    }

    /// Returns the inverse depth of a face at the centre of a pixel; `None` where its plane is not before the camera, and for
    /// see-through faces, behind which other surfaces are seen.
    fn at(&self, face: FaceId, [x, y]: [u32; 2]) -> Option<f64> {
        if self.model.sees_through(face) {
            return None;
        }
        let Shot { camera, pose, .. } = self.shot;
        let plane = &self.model.face(face).plane;
        let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let ray = pose.rotation.transpose() * camera.ray_in_camera(centre);
        let on_plane = -plane.normal.dot(ray) / plane.signed_distance(pose.center_in_world());
        let on_plane = Some(on_plane).filter(|on_plane| *on_plane > 0.0 && on_plane.is_finite())?;
        let moved = |relief: &OnRelief| f64::from(relief.moved(Some(face), [x, y], on_plane as f32));
        Some(self.relief.as_ref().map_or(on_plane, moved))
    }

    /// Returns the inverse depth of a face at the centre of a pixel, by its index and its number in
    /// [`quadratura_projection::Renders::seen_faces`]; `None` as in [`Self::at`], and where no face is.
    pub fn at_pixel(&self, pixel: usize, number: u32) -> Option<f64> {
        let width = self.shot.camera.width as usize;
        let place = [pixel % width, pixel / width].map(|place| place as u32);
        shown_face(number).and_then(|face| self.at(face, place))
    }

    /// Returns what each pixel of a blended view shows of its face: what is clearly farther than the face, or clearly nearer, is
    /// something else. `faces` are those of [`quadratura_projection::Renders::seen_faces`]. Where there is none, and where nothing is
    /// drawn, nothing is wrong.
    pub fn shown(&self, blended: &Blended, faces: &[u32]) -> Vec<Shows> {
        let compared =
            |at: usize| match (self.at_pixel(at, faces[at]), f64::from(blended.surfaces[at].inverse_depth)) {
                _ if blended.picture.pixels()[at][3] == 0 => Shows::Face,
                (Some(face), found) if found < BEHIND * face => Shows::Behind,
                (Some(face), found) if face < BEHIND * found => Shows::Before,
                _ => Shows::Face,
            };
        let shows = |at: usize| match (faces[at], blended.surfaces[at].invented) {
            (0, _) => Shows::Face,
            (_, true) => Shows::Filling,
            _ => compared(at),
        };
        (0..faces.len()).into_par_iter().map(shows).collect()
    }
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
    use quadratura_base::geometry::polygon::PlaneFrame;
    use quadratura_base::scene::synthetic::{Modeller, camera_is_world, centred};
    use quadratura_ldi::BlendedSurface;
    use quadratura_projection::relief::FaceRelief;
    use quadratura_view::Picture;

    /// Returns a view of seven pixels in a row, the last of which is empty. Of the others the fifth is filled in.
    fn blended(inverse_depths: [f32; 7]) -> Blended {
        let surface = |(at, inverse_depth)| BlendedSurface { invented: at == 4, inverse_depth };
        Blended {
            picture: Picture { width: 7, height: 1, rgba: [[255; 24].to_vec(), vec![0; 4]].concat() },
            surfaces: inverse_depths.into_iter().enumerate().map(surface).collect(),
        }
    }

    /// A wall at depth 4, and one that the camera sees from behind, at depth 2.
    #[test]
    fn what_is_clearly_behind_a_face_is_told_from_what_is_on_its_plane() {
        let mut modeller = Modeller::new();
        modeller.object("wall").screen(4.0, [-2.0, -2.0, 2.0, 2.0]);
        modeller.object("turned").quad_facing(DVec3::Z, DVec3::new(-1.0, -1.0, 2.0), DVec3::X, DVec3::Y);
        let (model, shot) = (modeller.finish(), Shot::new(centred(7, 1, 3.0), camera_is_world()));
        // A little behind the wall, far behind it, far before it, far behind the turned one; filled in; where no face is; empty.
        let blended = blended([0.24, 0.2, 0.3, 0.25, 0.25, 0.1, 0.0]);
        use Shows::{Before, Behind, Face, Filling};
        let faces = [1, 1, 1, 2, 1, 0, 1];
        let found = FaceDepths::new(&model, None, &shot).shown(&blended, &faces);
        assert_eq!(found, [Face, Behind, Before, Behind, Filling, Face, Face]);
        assert_eq!(shown_by_images(&faces, &found, &model), faces, "nothing turns");
    }

    #[test]
    fn a_face_is_where_its_relief_is_at_grazing_angles_too() {
        // The ground, 1 below the camera, which looks along it; its relief is 0.2 higher.
        let mut modeller = Modeller::new();
        let corner = DVec3::new(-9.0, 1.0, 1.0);
        modeller.object("ground").quad_facing(DVec3::NEG_Y, corner, 18.0 * DVec3::X, 40.0 * DVec3::Z);
        let (model, shot) = (modeller.finish(), Shot::new(centred(7, 1, 7.0), camera_is_world()));
        let shot = Shot { camera: quadratura_base::geometry::Pinhole { cy: -0.2, ..shot.camera }, ..shot };
        let frame = PlaneFrame::from_plane(&model.face(FaceId(0)).plane);
        let raised = FaceRelief { frame, low: DVec2::ZERO, cell: 1.0, size: [1, 1], heights: vec![0.2] };
        let relief = Arc::new(Relief { of_face: vec![Some(raised)] });
        // The rays fall by a tenth of their depth: the plane is 10 away, the relief 8.
        let blended = blended([0.1, 0.125, 0.15, 0.08, 0.1, 0.1, 0.1]);
        use Shows::{Before, Behind, Face, Filling};
        let shown = |relief| FaceDepths::new(&model, relief, &shot).shown(&blended, &[1; 7]);
        assert_eq!(shown(None), [Face, Before, Before, Behind, Filling, Face, Face]);
        assert_eq!(shown(Some(relief)), [Behind, Face, Before, Behind, Filling, Behind, Face]);
    }

    #[test]
    fn billboards_that_turn_are_left_to_the_renderer_and_so_is_what_is_before_faces_beside_them() {
        let mut modeller = Modeller::new();
        modeller.object("wall").screen(4.0, [-2.0, -2.0, 2.0, 2.0]);
        modeller.object("tree.billboard").screen(2.0, [-0.5, -1.0, 0.5, 1.0]);
        let is_tree = |object: &quadratura_base::scene::Object| object.name == "tree.billboard";
        let (model, refused) = (*modeller.finish()).clone().with_impostors(DVec3::NEG_Y, is_tree);
        assert!(refused.is_empty());
        use Shows::{Before, Behind, Face};
        let shows = [Face, Before, Behind, Face, Face];
        assert_eq!(shown_by_images(&[1, 1, 1, 2, 0], &shows, &model), [1, 0, 1, 0, 0]);
        assert_eq!(shown_by_images(&[1, 1, 1, 1, 0], &shows, &model), [1, 1, 1, 1, 0]);
    }
}
