//! Facts about the selected object or face, cached for the inspector, and where a photo shows a face.

use glam::DVec2;

use super::State;
use super::facts::FactInputs;
use super::panels::Tab;
use super::panes::Pane;
use super::selection::Selection;
use super::session::Session;

use quadratura_base::scene::{FaceId, ObjectId, Photo, PhotoId};
use quadratura_stacks::decide::{face_in_photos, photos_of_faces, state_of_face};

/// The margin around a face that is shown in a photo, as a share of its size.
const AROUND: f64 = 0.3;

impl State {
    /// Looks up what the inspector shows about the selected object or face, unless it is known or not shown.
    pub fn look_up_selection(&mut self) {
        if !self.settings.side_shown || self.settings.side != Tab::Selection {
            return;
        }
        match self.selection.main {
            Selection::Object(object) => self.look_up_object(object),
            Selection::Face(face) => self.look_up_face(face),
            Selection::Nothing | Selection::Photo(_) | Selection::Layer { .. } => (),
            Selection::Tree(_) | Selection::Trees => (),
        }
    }

    fn look_up_face(&mut self, face: FaceId) {
        let Some(session) = &self.session else { return };
        if self
            .selection
            .facts
            .face
            .as_ref()
            .is_some_and(|(of, inputs, _)| *of == face && inputs.is_of(session))
        {
            return;
        }
        let stacks: Vec<_> = session.photos.iter().map(|photo| photo.stack.as_deref()).collect();
        let decisions = &session.history.present().decisions;
        let found = face_in_photos(&session.opened.site, &stacks, decisions, face);
        self.selection.facts.face = Some((face, FactInputs::from_session(session), found));
    }

    fn look_up_object(&mut self, object: ObjectId) {
        let Some(session) = &self.session else { return };
        if self
            .selection
            .facts
            .object
            .as_ref()
            .is_some_and(|(of, inputs, _)| *of == object && inputs.is_of(session))
        {
            return;
        }
        let (site, decisions) = (&session.opened.site, &session.history.present().decisions);
        let stacks = session.photos.iter().zip(&site.photos);
        let stacks: Vec<_> = stacks
            .filter_map(|(it, photo)| Some((it.stack.as_deref()?, decisions.of(&photo.name))))
            .collect();
        let it = site.model.object(object);
        let found = photos_of_faces(&stacks, &it.name, it.faces.len());
        self.selection.facts.object = Some((object, FactInputs::from_session(session), found));
    }

    /// Shows a face in a photo; it stays selected.
    pub fn show_in_photo(&mut self, photo: PhotoId, face: FaceId, at: Option<[u32; 2]>) {
        let Some(session) = &self.session else { return };
        let Some(it) = session.opened.site.photos.get(photo.index()) else { return };
        let mark = at.map(|[x, y]| (face, DVec2::new(f64::from(x), f64::from(y)) + 0.5));
        let part = part_with(it, session.model().ring_points(face));
        self.selection.photo = Some(photo);
        self.panes.show(Pane::Photo);
        self.flat.photo.look_at(photo, part, mark);
    }
}

/// Returns the part of a photo that contains points of the world, with a margin, as corners in its pixels; none where
/// the photo has none of them.
fn part_with(photo: &Photo, points: impl Iterator<Item = glam::DVec3>) -> Option<[DVec2; 2]> {
    let size = DVec2::new(f64::from(photo.camera.width), f64::from(photo.camera.height));
    let in_photo = |point| photo.camera.image_from_camera(photo.pose.camera_from_world(point));
    let (low, high) = points
        .filter_map(in_photo)
        .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), px| (low.min(px), high.max(px)));
    let (low, high) = (low.max(DVec2::ZERO), high.min(size));
    let margin = AROUND * (high - low).max_element();
    (low.x < high.x && low.y < high.y).then(|| [low - margin, high + margin])
}

impl Session {
    /// Returns the photos in which something was decided about all faces of an object, with that in words.
    pub fn decided_about_object(&self, object: ObjectId) -> Vec<(PhotoId, &'static str)> {
        let (site, decisions) = (&self.opened.site, &self.history.present().decisions);
        let it = site.model.object(object);
        let of_photo = |(id, photo): (PhotoId, &Photo)| {
            let of_photo = decisions.of(&photo.name);
            let faces = it.faces.iter().map(|face| site.model.face(*face).index);
            let mut words = faces.map(|face| state_of_face(&of_photo, &it.name, face));
            let first = words.next().flatten()?;
            words.all(|word| word == Some(first)).then_some((id, first))
        };
        site.numbered_photos().filter_map(of_photo).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::closed_form;

    #[test]
    fn a_photo_is_looked_at_where_the_face_is_and_as_a_whole_where_it_is_not() {
        let scene = closed_form::two_quads();
        let photo = scene.photo();
        let face = scene.model.face_ids().next().unwrap();
        let [low, high] = part_with(&photo, scene.model.ring_points(face)).unwrap();
        let middle = scene.model.ring_points(face).sum::<glam::DVec3>() / scene.model.ring(face).len() as f64;
        let middle = photo.camera.image_from_camera(photo.pose.camera_from_world(middle)).unwrap();
        assert!(low.cmplt(middle).all() && high.cmpgt(middle).all(), "{low} {middle} {high}");
        let behind = photo.pose.world_from_camera(-glam::DVec3::Z);
        assert_eq!(part_with(&photo, [behind; 3].into_iter()), None);
    }
}
