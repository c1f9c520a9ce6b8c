//! Removing objects from the model and restoring them: photos, layers and views ignore removed objects.

use std::path::Path;

use super::State;
use super::notes::{Note, Weight};
use super::request::{JobRequest, Request};
use super::selection::Selection;
use super::session::{PhotoStatus, Session};
use quadratura_base::scene::{Model, ObjectId};
use quadratura_document::Project;
use quadratura_sites::impostors::{self, ImpostorEdit};
use quadratura_sites::objects::{ObjectEdit, edited};
use quadratura_sites::open::Opened;
use quadratura_sites::see_through::{self, SeeThroughEdit};

impl State {
    /// Removes an object from the model or restores it, by name.
    pub fn switch_object(&mut self, name: &str, on: bool) {
        match on {
            true => self.switch_objects(format!("restoration of {name}"), ObjectEdit::On(name.to_owned())),
            false => self.switch_objects(format!("removal of {name}"), ObjectEdit::Off(name.to_owned())),
        }
    }

    /// Makes an object turn towards cameras, or stay as it is modelled, by name.
    pub fn turn_object(&mut self, name: &str, turns: bool) {
        let Some(session) = &self.session else { return };
        let project = session.history.present();
        let edit = match turns {
            true => ImpostorEdit::Turns(name.to_owned()),
            false => ImpostorEdit::Stays(name.to_owned()),
        };
        match impostors::edited(&project.impostors, &[edit], &session.opened.whole) {
            Ok(impostors) => {
                let step = if turns { "turning" } else { "no turning" };
                self.edit(
                    format!("{step} of {name}"),
                    Project { impostors, ..Project::clone(project) },
                    None,
                );
            }
            Err(error) => self.notify(Note::new(Weight::Problem, error.to_string())),
        }
    }

    /// Declares an object see-through in places, or solid, by name.
    pub fn see_through_object(&mut self, name: &str, through: bool) {
        let Some(session) = &self.session else { return };
        let (project, opened) = (session.history.present(), &session.opened);
        let edit = match through {
            true => SeeThroughEdit::SeeThrough(name.to_owned()),
            false => SeeThroughEdit::Solid(name.to_owned()),
        };
        match see_through::edited(project, &[edit], &opened.whole, &opened.site.photos) {
            Ok(decided) => {
                let step = if through { "see-through" } else { "solid" };
                let project = Project { see_through: decided, ..Project::clone(project) };
                self.edit(format!("{name} {step}"), project, None);
            }
            Err(error) => self.notify(Note::new(Weight::Problem, error.to_string())),
        }
    }

    /// Removes what was decided about whether an object turns and is see-through, by name.
    pub fn free_object(&mut self, name: &str) {
        let Some(session) = &self.session else { return };
        let mut project = Project::clone(session.history.present());
        project.impostors.remove(name);
        project.see_through.remove(name);
        self.edit(format!("removal of decisions about {name}"), project, None);
    }

    /// Restores all removed objects.
    pub fn switch_all_on(&mut self) {
        let Some(session) = &self.session else { return };
        let project =
            Project { objects_off: Default::default(), ..Project::clone(session.history.present()) };
        self.edit("restoration of all objects", project, None);
    }

    /// Returns the name of the selected object, or of the object of the selected face.
    pub fn selected_object(&self) -> Option<String> {
        let session = self.session.as_ref()?;
        Some(session.model().object(session.object_of(self.selection.main)?).name.clone())
    }

    fn switch_objects(&mut self, step: String, edit: ObjectEdit) {
        let Some(session) = &self.session else { return };
        let project = session.history.present();
        match edited(&project.objects_off, &[edit], &session.opened.whole) {
            Ok(off) => self.edit(step, Project { objects_off: off, ..Project::clone(project) }, None),
            Err(error) => self.notify(Note::new(Weight::Problem, error.to_string())),
        }
    }

    /// Replaces the model by one with other objects, and carries the selection over.
    pub fn take_model(&mut self, folder: &Path, opened: Opened, photos: Vec<PhotoStatus>) -> Vec<Request> {
        let Some(session) = self.session.as_mut().filter(|session| session.folder == folder) else {
            return Vec::new();
        };
        let before = session.opened.site.model.clone();
        session.set_site(opened, photos);
        self.selection.main = carried(self.selection.main, &before, session.model());
        self.space.forget_faces();
        self.follow_visibility();
        self.quality.forget_stacks();
        self.space.refresh();
        vec![JobRequest::RestartPainter.into()]
    }
}

/// Returns the same object or face in another model, by name; nothing where it has none.
fn carried(selection: Selection, before: &Model, after: &Model) -> Selection {
    match selection {
        Selection::Object(object) => {
            let object = after.object_named(&before.object(object).name);
            object.map_or(Selection::Nothing, Selection::Object)
        }
        Selection::Face(face) => {
            let face = before.face(face);
            let face = after.face_named(&before.object(face.object).name, face.index);
            face.map_or(Selection::Nothing, Selection::Face)
        }
        other => other,
    }
}

impl Session {
    /// Returns the object that is selected, or whose face is.
    pub fn object_of(&self, selection: Selection) -> Option<ObjectId> {
        match selection {
            Selection::Object(object) => Some(object),
            Selection::Face(face) => Some(self.model().face(face).object),
            Selection::Nothing | Selection::Photo(_) | Selection::Layer { .. } => None,
            Selection::Tree(_) | Selection::Trees => None,
        }
    }

    /// Returns whether it was decided about an object, by name, that it turns, is see-through, or the opposite.
    pub fn is_decided_about(&self, name: &str) -> bool {
        let project = self.history.present();
        project.impostors.contains_key(name) || project.see_through.contains_key(name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::closed_form;
    use quadratura_base::scene::{ObjectId, PhotoId};

    #[test]
    fn what_is_selected_is_carried_over_by_its_name_and_lost_with_its_object() {
        let whole = closed_form::stairs().model;
        let first = whole.objects[0].name.clone();
        let part = whole.without(|object| object.name == first);
        let (object, face) = (Selection::Object(ObjectId(1)), Selection::Face(whole.objects[1].faces[0]));
        assert_eq!(carried(object, &whole, &part), Selection::Object(ObjectId(0)));
        assert_eq!(carried(face, &whole, &part), Selection::Face(part.objects[0].faces[0]));
        assert_eq!(carried(Selection::Object(ObjectId(0)), &whole, &part), Selection::Nothing);
        assert_eq!(carried(Selection::Photo(PhotoId(3)), &whole, &part), Selection::Photo(PhotoId(3)));
    }
}
