//! Objects, and surfaces that no photo covers, are shown in the 3D view and hidden.

use std::collections::BTreeSet;

use super::scene::ShownScene;
use super::visibility::{ModelVisibility, Uncovered};
use crate::state::State;
use quadratura_base::scene::FaceId;
use quadratura_view::hidden::HiddenFaces;

impl State {
    /// Opens or closes the eye of an object, by name.
    pub fn show_object(&mut self, name: &str, on: bool) {
        let hidden = &mut self.space.visibility.hidden;
        match on {
            true => hidden.remove(name),
            false => hidden.insert(name.to_owned()),
        };
        self.follow_visibility();
    }

    /// Shows only one object, by name, or all again where it is the only one.
    pub fn isolate_object(&mut self, name: &str) {
        let Some(session) = &self.session else { return };
        let names = session.model().objects.iter().map(|object| object.name.clone());
        let others: BTreeSet<String> = names.filter(|other| other != name).collect();
        let hidden = &mut self.space.visibility.hidden;
        *hidden = if *hidden == others { BTreeSet::new() } else { others };
        self.follow_visibility();
    }

    /// Opens the eyes of all objects.
    pub fn show_all_objects(&mut self) {
        self.space.visibility.hidden.clear();
        self.follow_visibility();
    }

    /// Sets how surfaces that no photo covers are shown.
    pub fn show_uncovered(&mut self, uncovered: Uncovered) {
        self.space.visibility.uncovered = uncovered;
        self.follow_visibility();
    }

    /// Leaves out of the pictures what is not to be shown, after a change of it or of the model's surface.
    pub fn follow_visibility(&mut self) {
        let faces = self.hidden_faces();
        self.space.look.hidden = faces;
    }

    fn hidden_faces(&self) -> HiddenFaces {
        let Some(session) = &self.session else { return HiddenFaces::default() };
        let ModelVisibility { hidden, uncovered } = &self.space.visibility;
        let objects = session.model().objects.iter().filter(|object| hidden.contains(&object.name));
        let mut faces: BTreeSet<FaceId> = objects.flat_map(|object| object.faces.iter().copied()).collect();
        if *uncovered != Uncovered::Solid {
            faces.extend(session.solid.sides().uncovered());
        }
        faces.into_iter().collect()
    }
}

impl ShownScene<'_> {
    /// Returns the faces that are drawn as glass.
    pub fn glass(&self) -> Vec<FaceId> {
        let session = self.session;
        let ModelVisibility { hidden, uncovered } = &self.space.visibility;
        if *uncovered != Uncovered::Glass {
            return Vec::new();
        }
        let model = session.model();
        let is_shown = |face: &FaceId| !hidden.contains(&model.object(model.face(*face).object).name);
        session.solid.sides().uncovered().filter(is_shown).collect()
    }
}
