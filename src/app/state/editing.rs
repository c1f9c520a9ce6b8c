//! Edits of the project: every decision of the user becomes a step of the history, and what follows is pending.

use std::path::PathBuf;
use std::sync::Arc;

use super::State;
use super::notes::{Note, Weight};
use super::pending::Invalidation;
use super::session::Session;
use quadratura_base::error::{Error, Result};
use quadratura_document::Project;
use quadratura_document::history::{Gesture, History};
use quadratura_document::masks::MaskChange;
use quadratura_document::paint::PaintImport;
use quadratura_document::stroke::Stroke;
use quadratura_io::mask_store::MaskStore;
use quadratura_stacks::decide::{self, LayerEdit};

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
            Err(error) => self.notify(Note::new(Weight::Problem, error.to_string())),
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
            None => history.imported(format!("import {number}"), number, files, masks),
        });
    }

    /// Adds a stroke of the brush, new or redone, to the history as a step; `name` describes it.
    pub fn remember_stroke(&mut self, number: u32, again: Option<u32>, stroke: Stroke, name: String) {
        self.on_disk_already(|history| match again {
            Some(old) => history.import_redone(old, number, Vec::new()),
            None => history.stroked(name, number, stroke),
        });
    }

    /// Records that the paint of a stroke stays in its photo, as the project on disk says already.
    pub fn remember_only_here(&mut self, number: u32) {
        self.on_disk_already(|history| history.stays_in_photo(number));
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

impl Session {
    /// Returns whether the views show an earlier model or earlier files, because reading the current ones was stopped.
    pub fn is_behind(&self) -> bool {
        self.pending.invalidation >= Some(Invalidation::Objects)
    }

    /// Records that the present project differs from `before`, and which updates follow.
    pub fn present_changed(&mut self, before: &Project, in_gesture: bool, now_s: f64) {
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
        let mut left_out = self.opened.problems.left_out.iter().map(|(photo, _)| photo.as_str());
        let store = MaskStore::new(&self.folder);
        let is_gone =
            |photo: &str| after.masks.of(photo).iter().any(|mask| !store.path(&mask.file).is_file());
        let mut masked = after.masks.photos().map(|(photo, _)| photo).filter(is_other);
        (left_out.any(|photo| is_other(&photo)) || masked.any(is_gone)).then_some(Invalidation::Site)
    }
}
