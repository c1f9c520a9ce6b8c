//! Edits of the project: every decision of the user, its undo and redo, and the updates that follow from it.

use std::path::PathBuf;
use std::sync::Arc;

use crate::app::action::objects::follow_objects;
use crate::app::action::round_trip::importing::{import_again, take_back_import};
use crate::app::action::saving::autosave_if_due;
use crate::app::quality::colour::follow_colour;
use crate::app::state::State;
use crate::app::state::ask::{BuildAsk, MaskAsk};
use crate::app::state::life::Autosave;
use crate::app::state::notes::{Note, Remedy, Weight};
use crate::app::state::running::JobKind;
use crate::app::state::selection::Selection;
use crate::app::state::session::{Session, survey};
use crate::app::work::Work;
use crate::app::work::jobs::{Arrival, arrival};
use crate::document::Project;
use crate::document::history::{Gesture, History, StepResult};
use crate::document::masks::MaskChange;
use crate::document::paint::PaintImport;
use crate::error::{Error, Result};
use crate::io::mask_store::MaskStore;
use crate::recipe::decide::{self, LayerEdit};
use crate::recipe::open::open_site;
use crate::recipe::site_stamp::SiteStamp;

/// Time without an edit, in seconds, after which the updates that follow from edits are done.
const FOLLOWS_AFTER_S: f64 = 0.3;

/// The parts of the session that an edit invalidates. Later variants include the earlier ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Invalidation {
    /// The gains of the photos are out of date.
    Gains,
    /// The state of stacks, and what is shown of them, is out of date.
    Stacks,
    /// The model is out of date: other objects are in use.
    Objects,
    /// Everything is out of date: files or the placement of the model have changed.
    Site,
}

impl Invalidation {
    /// Returns what the change from one project to another invalidates; `None` where nothing is.
    fn new(before: &Project, after: &Project) -> Option<Self> {
        let site = |project: &Project| {
            let Project { photos, cameras, model, world_from_model, .. } = project.clone();
            (photos, cameras, model, world_from_model)
        };
        // Bookmarks and flights invalidate nothing; masks and fill options take effect when layers are made again.
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

/// The updates that are pending after edits.
#[derive(Debug, Default)]
pub struct PendingUpdates {
    invalidation: Option<Invalidation>,
    /// Whether masks of photos have changed: their stacks stay, and may be out of date.
    looks: bool,
    /// Whether an update was stopped or failed. It waits until the next edit, build or reload.
    waits: bool,
    edited_s: f64,
    /// When the autosave is due.
    pub keep: Autosave,
}

impl State {
    /// Adds a step to the history; `name` is the text for undo. Edits of one gesture form one step.
    pub fn edit(&mut self, name: impl Into<String>, project: Project, gesture: Option<Gesture>) {
        let now_s = self.window.now_s;
        let Some(session) = &mut self.session else { return };
        let before = session.history.present().clone();
        session.history.edit(name, project, gesture);
        session.present_changed(&before, gesture.is_some(), now_s);
    }

    /// Ends the gesture: the next edit becomes a step of its own.
    pub fn end_gesture(&mut self) {
        if let Some(session) = &mut self.session {
            session.history.end_gesture();
            session.pending.keep.gesture_ended();
        }
    }

    /// Applies a decision about layers; a note gives the reason where it is not possible.
    pub fn decide(&mut self, edit: &LayerEdit) {
        match self.decided(edit) {
            Ok(project) => self.edit(edit.name(), project, None),
            Err(error) => self.tell(Note::new(Weight::Problem, error.to_string())),
        }
    }

    /// Returns the project after a decision about layers.
    ///
    /// # Errors
    /// The reason why the decision is not possible.
    pub fn decided(&self, edit: &LayerEdit) -> Result<Project> {
        let session = self.session.as_ref().ok_or_else(|| Error::Request("no project is open".into()))?;
        let stacks: Vec<_> = session.photos.iter().map(|photo| photo.stack.as_deref()).collect();
        decide::edited(session.history.present(), edit, &session.opened.site, &stacks)
    }

    /// Adds an import, new or redone, to the history as a step, with the masks that it brought.
    pub fn remember_import(
        &mut self,
        number: u32,
        again: Option<u32>,
        files: Vec<PathBuf>,
        masks: Vec<MaskChange>,
    ) {
        self.on_disk_already(|history| match again {
            Some(old) => history.import_redone(old, number, masks),
            None => history.imported(step_of_import(number), number, files, masks),
        });
    }

    /// Removes the masks of an import that is undone on disk.
    pub fn forget_masks_of(&mut self, import: &PaintImport) {
        self.on_disk_already(|history| history.import_undone(import.number, &import.masks));
    }

    fn on_disk_already(&mut self, change: impl FnOnce(&mut History)) {
        let now_s = self.window.now_s;
        let Some(session) = &mut self.session else { return };
        let before = session.history.present().clone();
        change(&mut session.history);
        session.present_changed(&before, false, now_s);
    }

    /// Removes an import from the history: it can no longer be undone or redone as a step.
    pub fn forget_import(&mut self, number: u32) {
        if let Some(session) = &mut self.session {
            session.history.forget_import(number);
        }
    }
}

/// Undoes the last step.
pub fn undo(state: &mut State, work: &mut Work) {
    turn_history(state, work, History::undo);
}

/// Redoes the step that was undone last.
pub fn redo(state: &mut State, work: &mut Work) {
    turn_history(state, work, History::redo);
}

fn turn_history(state: &mut State, work: &mut Work, turn: fn(&mut History) -> Option<StepResult>) {
    let now_s = state.window.now_s;
    let Some(session) = &mut state.session else { return };
    let before = session.history.present().clone();
    match turn(&mut session.history) {
        Some(StepResult::Project) => {
            session.present_changed(&before, false, now_s);
            if session.history.present().fill != before.fill {
                // The running fill uses the decisions that are being undone.
                work.jobs.stop_kind(&mut state.running, JobKind::Fill);
            }
        }
        Some(StepResult::TakeBack(number)) => take_back_import(state, work, number),
        Some(StepResult::ImportAgain(number, files)) => import_again(state, work, number, files),
        None => (),
    }
}

/// Starts the pending updates, once there has been no edit for a moment.
pub fn follow(state: &mut State, work: &mut Work) {
    autosave_if_due(state, work);
    let now_s = state.window.now_s;
    let Some(session) = &mut state.session else { return };
    let rests_s = now_s - session.pending.edited_s;
    // A job that writes uses the project it started with, and a film is drawn by the renderer of the 3D view.
    let busy = [JobKind::Build, JobKind::Fill, JobKind::Import, JobKind::Open, JobKind::Render];
    let busy = busy.into_iter().any(|kind| state.running.runs(kind));
    if rests_s < FOLLOWS_AFTER_S || busy || session.pending.waits {
        return;
    }
    let (invalidation, looks) =
        (session.pending.invalidation.take(), std::mem::take(&mut session.pending.looks));
    match invalidation {
        Some(Invalidation::Gains) => follow_colour(state, work),
        Some(Invalidation::Stacks) => return look_again(state, work),
        Some(Invalidation::Objects) => return follow_objects(state, work),
        Some(Invalidation::Site) => return reopen(state, work, None),
        None => (),
    }
    if looks {
        look_at_states(state, work);
    }
}

/// Starts the job that finds which stacks are up to date.
fn look_again(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let (folder, opened, known) = (session.folder.clone(), session.opened.clone(), session.photos.clone());
    work.jobs.stop_kind(&mut state.running, JobKind::Survey);
    work.jobs.start(&mut state.running, JobKind::Survey, "Looking at stacks", move |task| {
        let photos = survey(&folder, &opened, &known, task)?;
        Ok(Box::new(move |state| state.stacks_changed(&folder, photos, Vec::new(), false)))
    });
}

/// Starts the job that finds which stacks are up to date, where the stacks that are shown are still the current ones.
fn look_at_states(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let (folder, opened, known) = (session.folder.clone(), session.opened.clone(), session.photos.clone());
    work.jobs.stop_kind(&mut state.running, JobKind::Survey);
    work.jobs.start(&mut state.running, JobKind::Survey, "Looking at stacks", move |task| {
        let photos = survey(&folder, &opened, &known, task)?;
        Ok(Box::new(move |state| state.states_seen(&folder, photos)))
    });
}

/// Starts reading the site again, as the project now describes it. Then, if `then_build` is given, builds these photos
/// (all where the list is empty).
pub fn reopen(state: &mut State, work: &mut Work, then_build: Option<Vec<String>>) {
    let Some(session) = &mut state.session else { return };
    // Reading the site again includes all pending updates.
    (session.pending.invalidation, session.pending.waits) = (None, false);
    let (folder, project) = (session.folder.clone(), session.history.present().clone());
    work.jobs.stop_kind(&mut state.running, JobKind::Survey);
    work.jobs.start(&mut state.running, JobKind::Open, "Reading the site again", move |task| {
        let seen = SiteStamp::new(&folder, &project);
        let read = || {
            let opened = open_site(&folder, Project::clone(&project), task)?;
            let photos = survey(&folder, &opened, &[], task)?;
            Ok((opened, photos))
        };
        let (opened, photos) = match read() {
            Ok(read) => read,
            Err(error) => return Ok(not_followed(folder, Invalidation::Site, error)),
        };
        let count = photos.len();
        Ok(Box::new(move |state| {
            let Some(session) = state.session.as_mut().filter(|session| session.folder == folder) else {
                return Vec::new();
            };
            session.set_site(opened, photos);
            session.seen = seen;
            // Photos, objects and faces may have changed: earlier indices are invalid.
            state.select(Selection::Nothing);
            state.photo = state.photo.filter(|photo| *photo < count);
            state.space.forget_site();
            state.flat.forget();
            state.space.refresh();
            let build = then_build.map(|photos| BuildAsk::Build(photos).into());
            let asks = [BuildAsk::SiteRead.into(), MaskAsk::ReportProblems.into()];
            asks.into_iter().chain(build).collect()
        }))
    });
}

/// Returns the arrival of an update that failed: the update is pending again.
pub fn not_followed(folder: PathBuf, invalidation: Invalidation, error: Error) -> Arrival {
    arrival(move |state| {
        let Some(session) = state.session.as_mut().filter(|session| session.folder == folder) else {
            return;
        };
        session.pending.invalidation = session.pending.invalidation.max(Some(invalidation));
        session.pending.waits = true;
        let (weight, why) = match error {
            Error::Cancelled => (Weight::Warning, "stopped".to_owned()),
            error => (Weight::Problem, error.to_string()),
        };
        let text = format!("The site was not read again ({why}): views and photos show it as it was before.");
        state.tell(Note::new(weight, text).with("Read files again", Remedy::ReadAgain));
    })
}

/// Returns the name of an import as a step of the history.
pub fn step_of_import(number: u32) -> String {
    format!("import {number}")
}

impl Session {
    /// Returns whether the views show an earlier model or earlier files, because reading the current ones was stopped.
    pub fn is_behind(&self) -> bool {
        self.pending.invalidation >= Some(Invalidation::Objects)
    }

    /// Records that the present project differs from `before`, and which updates follow.
    fn present_changed(&mut self, before: &Project, in_gesture: bool, now_s: f64) {
        let present = self.history.present().clone();
        if *present == *before {
            return;
        }
        let invalidation = Invalidation::new(before, &present).max(self.brings_back(before, &present));
        self.pending.looks |= before.masks != present.masks;
        self.pending.invalidation = self.pending.invalidation.max(invalidation);
        (self.pending.edited_s, self.pending.waits) = (now_s, false);
        self.pending.keep.edited(in_gesture, now_s);
        if invalidation != Some(Invalidation::Site) {
            self.opened = Arc::new(self.opened.with_project(&self.folder, Project::clone(&present)));
        }
    }

    /// Returns what to update where a mask change brings a photo back or leaves it out: a photo with an unusable mask
    /// comes back with another mask, and undo can restore a mask whose file is missing.
    fn brings_back(&self, before: &Project, after: &Project) -> Option<Invalidation> {
        let is_other = |photo: &&str| before.masks.of(photo) != after.masks.of(photo);
        let mut left_out = self.opened.left_out.iter().map(|(photo, _)| photo.as_str());
        let store = MaskStore::new(&self.folder);
        let is_gone =
            |photo: &str| after.masks.of(photo).iter().any(|mask| !store.path(&mask.file).is_file());
        let mut masked = after.masks.photos().map(|(photo, _)| photo).filter(is_other);
        (left_out.any(|photo| is_other(&photo)) || masked.any(is_gone)).then_some(Invalidation::Site)
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
        assert_eq!(Invalidation::new(&before, &after), None);
        after.colour.reference = Some("a.jpg".into());
        assert_eq!(Invalidation::new(&before, &after), Some(Invalidation::Gains));
        after.masks =
            serde_json::from_str(r#"{"a.jpg":[{"from":"drawn","file":"a/1.png","pixels":3}]}"#).unwrap();
        assert_eq!(
            Invalidation::new(&before, &after),
            Some(Invalidation::Gains),
            "no stack is another one for a mask"
        );
        after.options.margin += 1;
        assert_eq!(Invalidation::new(&before, &after), Some(Invalidation::Stacks));
        after.objects_off.insert("tower".into());
        assert_eq!(Invalidation::new(&before, &after), Some(Invalidation::Objects));
        after.world_from_model = Similarity { scale: 2.0, ..Similarity::IDENTITY };
        assert_eq!(Invalidation::new(&before, &after), Some(Invalidation::Site));
    }
}
