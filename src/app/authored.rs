//! What the user decides: every edit of the project, undone and done again, saved, and kept for the case of a crash.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use super::editor::Editor;
use super::jobs::Kind;
use super::notes::{Note, Weight};
use super::selection::Selection;
use super::session::{Session, survey};
use crate::document::Project;
use crate::document::history::{Gesture, Turn};
use crate::error::{Error, Result};
use crate::io::project::{read_project, write_project};
use crate::io::recovery::{forget_unsaved, keep_unsaved};
use crate::recipe::decide::{self, LayerEdit};
use crate::recipe::open::open_site;

/// What was edited is kept for the case of a crash when nothing has been edited for so long, in seconds: a slider
/// that is being dragged is not written at every step.
const KEPT_AFTER_S: f64 = 0.4;
/// And at the latest so long after the first edit that is not kept, in seconds: somebody who works without a rest loses
/// no more than that.
const KEPT_AT_LATEST_S: f64 = 2.0;
/// Where it could not be kept, it is tried again after so long, in seconds: a disk was full, and may not be any more.
const KEPT_AGAIN_S: f64 = 5.0;
/// What follows from an edit is done when nothing has been edited for so long, in seconds.
const FOLLOWS_AFTER_S: f64 = 0.3;

/// What must be made anew after an edit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Follows {
    /// By what photos are multiplied.
    Gains,
    /// Which stacks are up to date, and what is shown.
    Stacks,
    /// The model, of which other objects are in use.
    Objects,
    /// Everything: files or the model's place are others.
    Site,
}

impl Follows {
    /// Of a change from one project to another.
    fn of(before: &Project, after: &Project) -> Option<Self> {
        let site = |project: &Project| {
            let Project { photos, cameras, model, world_from_model, .. } = project.clone();
            (photos, cameras, model, world_from_model)
        };
        // Views and flights change nothing that is made, masks and options of filling nothing until it is made again.
        let kept = Project {
            masks: after.masks.clone(),
            views: after.views.clone(),
            flight: after.flight.clone(),
            fill: after.fill.clone(),
            ..before.clone()
        };
        let multiplied = Project { colour: after.colour.clone(), ..kept.clone() };
        if kept == *after {
            None
        } else if multiplied == *after {
            Some(Self::Gains)
        } else if site(before) != site(after) {
            Some(Self::Site)
        } else if before.objects_off != after.objects_off {
            Some(Self::Objects)
        } else {
            Some(Self::Stacks)
        }
    }
}

/// What is left to do after edits.
#[derive(Debug, Default)]
pub struct Due {
    follows: Option<Follows>,
    /// Photos have other masks: their stacks stay, and may be out of date.
    looks: bool,
    keeps: bool,
    edited_s: f64,
    /// When the first edit was made that is not kept.
    unkept_s: f64,
    /// It is not kept before: the last try failed.
    not_before_s: f64,
    /// Held by whoever writes or forgets what is not saved: else it could be written after a save.
    keeping: Arc<Mutex<()>>,
}

impl Editor {
    /// Masks that came home with paint, or went with it, are on disk already: the project in the window has them, too,
    /// beside what was drawn and is not saved.
    pub(super) fn take_masks(&mut self) {
        let Some(session) = &self.session else { return };
        let Ok(saved) = read_project(&session.folder) else { return };
        let present = session.history.present();
        let masks = present.masks.with_layers_of(&saved.masks);
        if present.masks != masks {
            let project = Project { masks, ..Project::clone(present) };
            self.edit("masks that came home", project, None);
        }
    }

    /// Makes a step of the history: `name` is what is undone. Edits of one gesture are one step.
    pub fn edit(&mut self, name: impl Into<String>, project: Project, gesture: Option<Gesture>) {
        let now_s = self.now_s();
        let Some(session) = &mut self.session else { return };
        let before = session.history.present().clone();
        session.history.edit(name, project, gesture);
        session.present_changed(&before, now_s);
    }

    /// The next edit is a step of its own.
    pub fn end_gesture(&mut self) {
        if let Some(session) = &mut self.session {
            session.history.end_gesture();
        }
    }

    /// Decides something about layers; where that cannot be, a note says why.
    pub fn decide(&mut self, edit: &LayerEdit) {
        match self.decided(edit) {
            Ok(project) => self.edit(edit.name(), project, None),
            Err(error) => self.tell(Note::new(Weight::Problem, error.to_string())),
        }
    }

    /// The project after a decision about layers.
    ///
    /// # Errors
    /// Why it cannot be.
    pub(super) fn decided(&self, edit: &LayerEdit) -> Result<Project> {
        let session = self.session.as_ref().ok_or_else(|| Error::Request("no project is open".into()))?;
        let stacks: Vec<_> = session.photos.iter().map(|photo| photo.stack.as_deref()).collect();
        decide::edited(session.history.present(), edit, &session.opened.site, &stacks)
    }

    /// Takes the last step back.
    pub fn undo(&mut self) {
        self.turn(crate::document::history::History::undo);
    }

    /// Does a step again that was undone.
    pub fn redo(&mut self) {
        self.turn(crate::document::history::History::redo);
    }

    fn turn(&mut self, turn: fn(&mut crate::document::history::History) -> Option<Turn>) {
        let now_s = self.now_s();
        let Some(session) = &mut self.session else { return };
        let before = session.history.present().clone();
        match turn(&mut session.history) {
            Some(Turn::Project) => {
                session.present_changed(&before, now_s);
                if session.history.present().fill != before.fill {
                    // It goes by what was taken back.
                    self.jobs.stop_kind(Kind::Fill);
                }
            }
            Some(Turn::TakeBack(number)) => self.take_back_import(number),
            Some(Turn::ImportAgain(number, files)) => self.import_again(number, files),
            None => (),
        }
    }

    /// An import was made, or one that was taken back is made again: it is a step.
    pub(super) fn remember_import(&mut self, number: u32, again: Option<u32>, files: Vec<PathBuf>) {
        let Some(session) = &mut self.session else { return };
        match again {
            Some(old) => session.history.imported_again(old, number),
            None => session.history.imported(step_of_import(number), number, files),
        }
    }

    /// An import cannot be taken back or done again as a step any more.
    pub(super) fn forget_import(&mut self, number: u32) {
        if let Some(session) = &mut self.session {
            session.history.forget_import(number);
        }
    }

    /// Something is not saved.
    pub fn is_dirty(&self) -> bool {
        self.session.as_ref().is_some_and(|session| session.history.is_dirty()) || !self.masking.is_kept()
    }

    /// Saves the project; whether it is saved now.
    pub fn save_project(&mut self) -> bool {
        self.jobs.stop_kind(Kind::Keep);
        let Some(session) = &mut self.session else { return true };
        let keeping = session.due.keeping.clone();
        let _keeping = keeping.lock().unwrap_or_else(PoisonError::into_inner);
        let folder = &session.folder;
        let saved = write_project(folder, session.history.present()).and_then(|()| forget_unsaved(folder));
        match saved {
            Ok(()) => {
                session.history.saved();
                session.due.keeps = false;
                true
            }
            Err(error) => {
                self.notes.add(Note::new(Weight::Problem, format!("The project was not saved: {error}")));
                self.settings.notes_shown = true;
                false
            }
        }
    }

    /// Forgets what is not saved: the project was left so by its user.
    pub fn discard_unsaved(&mut self) {
        self.jobs.stop_kind(Kind::Keep);
        let Some(session) = &self.session else { return };
        let forgotten = {
            let _keeping = session.due.keeping.lock().unwrap_or_else(PoisonError::into_inner);
            forget_unsaved(&session.folder)
        };
        if let Err(error) = forgotten {
            self.tell(Note::new(Weight::Warning, error.to_string()));
        }
    }

    /// Does what follows from edits, once nothing has been edited for a moment.
    pub(super) fn follow(&mut self) {
        let now_s = self.now_s();
        let Some(session) = &mut self.session else { return };
        let due = &mut session.due;
        let rests_s = now_s - due.edited_s;
        let is_time = rests_s >= KEPT_AFTER_S || now_s - due.unkept_s >= KEPT_AT_LATEST_S;
        if due.keeps && is_time && now_s >= due.not_before_s {
            due.keeps = false;
            self.keep();
        } else if due.keeps {
            self.context.request_repaint_after_secs(KEPT_AFTER_S as f32);
        }
        let Some(session) = &mut self.session else { return };
        // A job that writes goes by the project that it began with, and a film is drawn by the 3D view's renderer.
        let busy = [Kind::Build, Kind::Fill, Kind::Import, Kind::Open, Kind::Render];
        let busy = busy.into_iter().any(|kind| self.jobs.runs(kind));
        if rests_s < FOLLOWS_AFTER_S || busy {
            return;
        }
        let (follows, looks) = (session.due.follows.take(), std::mem::take(&mut session.due.looks));
        match follows {
            Some(Follows::Gains) => self.follow_colour(),
            Some(Follows::Stacks) => return self.look_again(),
            Some(Follows::Objects) => return self.follow_objects(),
            Some(Follows::Site) => return self.reopen(),
            None => (),
        }
        if looks {
            self.look_at_states();
        }
    }

    /// Keeps what is not saved at once: the program may be about to end.
    pub(super) fn keep_now(&mut self) {
        let dirty = |session: &&mut Session| session.history.is_dirty();
        self.jobs.stop_kind(Kind::Keep);
        let Some(session) = self.session.as_mut().filter(dirty) else { return };
        session.due.keeps = false;
        let _keeping = session.due.keeping.lock().unwrap_or_else(PoisonError::into_inner);
        if let Err(error) = keep_unsaved(&session.folder, session.history.present()) {
            self.notes.add(Note::new(Weight::Problem, error.to_string()));
        }
    }

    fn keep(&mut self) {
        let Some(session) = &self.session else { return };
        let (folder, project, dirty) =
            (session.folder.clone(), session.history.present().clone(), session.history.is_dirty());
        let keeping = session.due.keeping.clone();
        self.jobs.stop_kind(Kind::Keep);
        self.jobs.start(Kind::Keep, "Keeping what is not saved", move |task| {
            let _keeping = keeping.lock().unwrap_or_else(PoisonError::into_inner);
            // Saved or forgotten meanwhile.
            task.go_on()?;
            let kept = kept(&folder, &project, dirty);
            Ok(Box::new(move |editor| kept.unwrap_or_else(|error| editor.not_kept(&folder, &error))))
        });
    }

    /// Looks which stacks are up to date.
    fn look_again(&mut self) {
        let Some(session) = &self.session else { return };
        let (folder, opened, known) =
            (session.folder.clone(), session.opened.clone(), session.photos.clone());
        self.jobs.stop_kind(Kind::Survey);
        self.jobs.start(Kind::Survey, "Looking at stacks", move |task| {
            let photos = survey(&folder, &opened, &known, task)?;
            Ok(Box::new(move |editor| editor.stacks_changed(&folder, photos, Vec::new())))
        });
    }

    fn not_kept(&mut self, folder: &Path, error: &Error) {
        let now_s = self.now_s();
        if let Some(session) = self.session.as_mut().filter(|session| session.folder == folder) {
            (session.due.keeps, session.due.not_before_s) = (true, now_s + KEPT_AGAIN_S);
        }
        let text = format!(
            "What is not saved could not be kept for the case of a crash; it is tried again: {error}"
        );
        self.tell(Note::new(Weight::Problem, text));
    }

    /// Looks which stacks are up to date, where the stacks themselves are those that are shown.
    fn look_at_states(&mut self) {
        let Some(session) = &self.session else { return };
        let (folder, opened, known) =
            (session.folder.clone(), session.opened.clone(), session.photos.clone());
        self.jobs.stop_kind(Kind::Survey);
        self.jobs.start(Kind::Survey, "Looking at stacks", move |task| {
            let photos = survey(&folder, &opened, &known, task)?;
            Ok(Box::new(move |editor| editor.states_seen(&folder, photos)))
        });
    }

    /// Reads the site again, as the project says it is now.
    pub(super) fn reopen(&mut self) {
        let Some(session) = &self.session else { return };
        let (folder, project) = (session.folder.clone(), session.history.present().clone());
        self.jobs.stop_kind(Kind::Survey);
        self.jobs.start(Kind::Open, "Reading the site again", move |task| {
            let opened = open_site(&folder, Project::clone(&project), task)?;
            let photos = survey(&folder, &opened, &[], task)?;
            let count = photos.len();
            Ok(Box::new(move |editor| {
                let Some(session) = editor.session.as_mut().filter(|session| session.folder == folder) else {
                    return;
                };
                session.set_site(opened, photos);
                // Photos, objects and faces may be others: nothing goes by their old places.
                editor.select(Selection::Nothing);
                editor.photo = editor.photo.filter(|photo| *photo < count);
                editor.space.forget_site();
                editor.flat.forget();
                editor.pictures = super::pictures::Pictures::default();
                let opened = editor.session.as_ref().map(|session| session.opened.clone());
                if let Some(opened) = opened {
                    editor.pictures.start(&folder, &opened, &mut editor.jobs);
                }
                editor.space.refresh();
                editor.prepare_painter();
            }))
        });
    }
}

/// What an import is called among the steps.
pub(super) fn step_of_import(number: u32) -> String {
    format!("import {number}")
}

/// What is saved needs not be kept.
fn kept(folder: &Path, project: &Project, dirty: bool) -> Result<()> {
    if dirty { keep_unsaved(folder, project) } else { forget_unsaved(folder) }
}

impl Session {
    /// The project is another one than `before`.
    fn present_changed(&mut self, before: &Project, now_s: f64) {
        let present = self.history.present().clone();
        if *present == *before {
            return;
        }
        let follows = Follows::of(before, &present).max(self.brings_back(before, &present));
        self.due.looks |= before.masks != present.masks;
        self.due.follows = self.due.follows.max(follows);
        if !self.due.keeps {
            self.due.unkept_s = now_s;
        }
        self.due.keeps = true;
        self.due.edited_s = now_s;
        if follows != Some(Follows::Site) {
            self.opened = Arc::new(self.opened.with_project(&self.folder, Project::clone(&present)));
        }
    }

    /// A photo that is left out for a mask that cannot be used may come back with another one.
    fn brings_back(&self, before: &Project, after: &Project) -> Option<Follows> {
        let mut left_out = self.opened.left_out.iter().map(|(photo, _)| photo);
        left_out.any(|photo| before.masks.of(photo) != after.masks.of(photo)).then_some(Follows::Site)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Similarity;

    fn project() -> Project {
        let text = r#"{"version": 1, "photos": "p", "cameras": "c", "model": "m.obj"}"#;
        serde_json::from_str(text).unwrap()
    }

    #[test]
    fn what_follows_depends_on_what_was_edited() {
        let before = project();
        let mut after = before.clone();
        after.flight = Some(crate::document::CameraPath::empty([64, 48]));
        assert_eq!(Follows::of(&before, &after), None);
        after.colour.reference = Some("a.jpg".into());
        assert_eq!(Follows::of(&before, &after), Some(Follows::Gains));
        after.masks =
            serde_json::from_str(r#"{"a.jpg":[{"from":"drawn","file":"a/1.png","pixels":3}]}"#).unwrap();
        assert_eq!(Follows::of(&before, &after), Some(Follows::Gains), "no stack is another one for a mask");
        after.options.margin += 1;
        assert_eq!(Follows::of(&before, &after), Some(Follows::Stacks));
        after.objects_off.insert("tower".into());
        assert_eq!(Follows::of(&before, &after), Some(Follows::Objects));
        after.world_from_model = Similarity { scale: 2.0, ..Similarity::IDENTITY };
        assert_eq!(Follows::of(&before, &after), Some(Follows::Site));
    }
}
