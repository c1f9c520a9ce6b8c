//! Where the 3D view flies to: photos, the selection, everything.

use glam::DVec3;

use super::FIELD_RAD;
use super::picking::{ball_of, faces_of};
use crate::state::State;
use crate::state::selection::Selection;
use crate::state::session::Session;
use quadratura_base::scene::{FaceId, PhotoId};
use quadratura_projection::best_view::BestView;
use quadratura_view::flight::FrameLens;
use quadratura_view::navigation::{SceneFrame, Viewpoint};

impl State {
    /// Flies to a free viewpoint.
    pub fn fly_to_viewpoint(&mut self, there: Viewpoint) {
        let now_s = self.window.now_s;
        let Some(session) = &self.session else { return };
        self.space.fly(there, None, session, now_s);
    }

    /// Flies into the camera of a photo.
    pub fn fly_to_photo(&mut self, photo: PhotoId) {
        let now_s = self.window.now_s;
        let Some(session) = &self.session else { return };
        if self.space.through.is_none() && self.space.travel.is_none() {
            self.space.back = Some(self.space.viewpoint);
        }
        self.space.fly(session.viewpoint_of(photo), Some(photo), session, now_s);
        self.select(Selection::Photo(photo));
    }

    /// Flies into the selected photo, or back to the previous viewpoint.
    pub fn snap(&mut self) {
        let Some(photo) = self.selected_photo() else { return };
        let now_s = self.window.now_s;
        match (self.space.through, self.space.back.take()) {
            (Some(through), Some(back)) if through == photo => {
                let Some(session) = &self.session else { return };
                self.space.fly(back, None, session, now_s);
            }
            (_, back) => {
                self.space.back = back;
                self.fly_to_photo(photo);
            }
        }
    }

    /// Selects the photo `by` positions further; flies there when the view looks through a photo.
    pub fn step_photo(&mut self, by: isize) {
        let Some(session) = &self.session else { return };
        let count = session.photos.len() as isize;
        if count == 0 {
            return;
        }
        let photo = self.selection.photo.map_or(0, |photo| (photo.index() as isize + by).rem_euclid(count));
        let photo = PhotoId::new(photo as usize);
        if self.space.through.is_some()
            || self.space.travel.as_ref().is_some_and(|travel| travel.through.is_some())
        {
            self.fly_to_photo(photo);
        } else {
            self.select(Selection::Photo(photo));
        }
    }

    /// Moves back until the whole model is visible, backdrops excepted. Where it is not seen from here, the view turns to
    /// where a photo looks at it from. Layers that are pulled apart are shown instead, where there are some.
    pub fn show_everything(&mut self) {
        if self.frame_apart() {
            return;
        }
        let Some(session) = &self.session else { return };
        let (home, up) = (SceneFrame::new(&session.home, session.scene_frame.up), session.scene_frame.up);
        let width = self.space.width();
        let held = |mut view: Viewpoint| {
            view.lens = FrameLens::with_field_of_view(FIELD_RAD);
            view.show(home.center, home.radius);
            // A ball around it is much larger than a flat site.
            view.hold_within(&session.home, width);
            view
        };
        let faces: Vec<FaceId> =
            session.model().objects.iter().flat_map(|object| object.faces.clone()).collect();
        let views = views_onto(session, &faces, home.center);
        let lens = FrameLens::with_field_of_view(FIELD_RAD);
        let towards = |forward| held(Viewpoint::towards(home.center, home.radius, forward, up, lens));
        let there = views.best(held(self.space.viewpoint), home.center, up, width, towards);
        self.space.fly(there, None, session, self.window.now_s);
    }

    /// Shows all layers that are pulled apart; returns false where none are.
    fn frame_apart(&mut self) -> bool {
        let Some(there) = self.scene().and_then(|scene| scene.view_of_layers_apart()) else { return false };
        self.fly_to_viewpoint(there);
        true
    }

    /// Frames the selection, or the layers that are pulled apart.
    pub fn frame_selection(&mut self) {
        if self.frame_apart() {
            return;
        }
        let Some(session) = &self.session else { return };
        let of_tree = match self.selection.main {
            Selection::Tree(index) => self.ball_of_tree(index),
            _ => None,
        };
        match of_tree.or_else(|| ball_of(self.selection.main, session)) {
            Some((center, radius)) => self.fly_to_ball(center, radius),
            None => match self.selection.main.photo() {
                Some(photo) => self.fly_to_photo(photo),
                None => self.show_everything(),
            },
        }
    }

    fn fly_to_ball(&mut self, center: DVec3, radius: f64) {
        let now_s = self.window.now_s;
        let Some(session) = &self.session else { return };
        let (width, up) = (self.space.width(), session.scene_frame.up);
        let lens = FrameLens::with_field_of_view(FIELD_RAD);
        // The narrower side of the view decides.
        let radius = radius / width.min(1.0);
        let mut present = self.space.viewpoint;
        present.lens = lens;
        present.show(center, radius);
        let towards = |forward| Viewpoint::towards(center, radius, forward, up, lens);
        let views = views_onto(session, &faces_of(self.selection.main, session), center);
        let there = views.best(present, center, up, width, towards);
        self.space.fly(there, None, session, now_s);
    }

    /// Levels the horizon.
    pub fn level(&mut self) {
        let now_s = self.window.now_s;
        let Some(session) = &self.session else { return };
        let mut there = self.space.viewpoint;
        there.level(session.scene_frame.up);
        self.space.fly(there, None, session, now_s);
    }
}

/// Returns the views of faces from where photos look at them, and of `center` where there are none.
fn views_onto<'a>(session: &'a Session, faces: &[FaceId], center: DVec3) -> BestView<'a> {
    let photos = session.opened.site.photos.iter().map(|photo| photo.pose.center_in_world());
    let photos: Vec<DVec3> = photos.collect();
    BestView::new(session.model(), faces, center, &session.solid, &photos)
}
