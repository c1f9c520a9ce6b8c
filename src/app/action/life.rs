//! Effects of the project's life cycle: executes what [`state::life`](crate::state::life) decides.

use std::path::PathBuf;

use super::build::close_project;
use super::opening::assistant::create_project;
use super::opening::open::open_now;
use super::saving::{discard_unsaved, save};
use crate::state::State;
use crate::state::life::{Effect, Facts, Goal, LifeEvent};
use crate::state::notes::{Note, Weight};
use crate::work::Work;
use quadratura_io::recovery::UnsavedChanges;

impl State {
    /// Returns the facts about the project that the life cycle depends on.
    pub fn life_facts(&self) -> Facts {
        Facts {
            is_dirty: self.is_dirty(),
            masks_wait: !self.masking.is_kept(),
            writes: self.running.writing().next().is_some() || self.space.brush.unpainted() > 0,
        }
    }

    /// Closes the window without any further question.
    pub fn quit(&mut self) {
        self.life.quit();
        self.window.closes = true;
    }
}

/// Handles an event of the life cycle and executes its effects.
pub fn happens(state: &mut State, work: &mut Work, event: LifeEvent) {
    if matches!(event, LifeEvent::Leave(_)) {
        // The button may still be down.
        state.space.brush.end();
    }
    let mut event = Some(event);
    while let Some(now) = event.take() {
        let facts = state.life_facts();
        let (phase, effect) = std::mem::take(&mut state.life.phase).next(now, facts);
        state.life.phase = phase;
        event = effect.and_then(|effect| follow_effect(state, work, effect));
    }
}

fn follow_effect(state: &mut State, work: &mut Work, effect: Effect) -> Option<LifeEvent> {
    match effect {
        Effect::Save => return Some(LifeEvent::Saved(save(state, work).map_err(|error| error.to_string()))),
        Effect::StopWriting => {
            state.space.brush.drop_unpainted();
            work.jobs.stop_writing(&mut state.running);
        }
        Effect::Go { goal, discards } => {
            if discards {
                discard_unsaved(state, work);
            }
            match goal {
                Goal::Close => close_project(state, work),
                Goal::Open(project) => open_now(state, work, project),
                Goal::Create => create_project(state, work),
                Goal::Quit => state.quit(),
            }
        }
    }
    None
}

/// Opens the project in `folder` in place of the current one; asks first about unsaved changes and running writes.
pub fn open_project(state: &mut State, work: &mut Work, folder: PathBuf) {
    happens(state, work, LifeEvent::Leave(Goal::Open(folder)));
}

/// Offers unsaved changes that were found from an earlier run.
pub fn offer_recovery(state: &mut State, work: &mut Work, found: UnsavedChanges) {
    let Some(session) = &state.session else { return };
    // Until the question is answered, the recovery file on disk stays unchanged.
    work.autosave.iter().for_each(|autosave| autosave.hold(true));
    state.life.found(found, session.history.present().masks.clone());
}

/// Handles the user's answer about restoring unsaved changes.
pub fn answer_recovery(state: &mut State, work: &mut Work, restores: bool) {
    let Some(recovery) = state.life.answer() else { return };
    work.autosave.iter().for_each(|autosave| autosave.hold(false));
    if !restores {
        discard_unsaved(state, work);
        return state.notify(Note::new(Weight::Info, "Unsaved changes were discarded"));
    }
    let mut project = recovery.found.project;
    if let Some(session) = &state.session {
        // Masks that were imported before the question was answered are on disk, and are kept.
        project.masks = project.masks.merged_with_changes(&recovery.masks, &session.history.present().masks);
    }
    state.edit("recovery", project, None);
}
