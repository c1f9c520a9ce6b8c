//! Decisions of the user: their undo and redo, and the updates that follow from them.

use crate::action::brush::{paint_again, undo_stroke};
use crate::action::model_suggestions::turn_model;
use crate::action::objects::follow_objects;
use crate::action::quality::colour::follow_colour;
use crate::action::reread::reopen;
use crate::action::round_trip::importing::{import_again, take_back_import};
use crate::action::saving::autosave_if_due;
use crate::state::State;
use crate::state::pending::Invalidation;
use crate::state::running::JobKind;
use crate::state::session::survey;
use crate::work::Work;
use quadratura_document::history::{History, StepResult};

/// Undoes the last step.
pub fn undo(state: &mut State, work: &mut Work) {
    if !undo_stroke(state, work) {
        undo_step(state, work);
    }
}

/// Undoes the last step of the history, also while a stroke waits that is none yet.
pub fn undo_step(state: &mut State, work: &mut Work) {
    turn_history(state, work, History::undo);
}

/// Redoes the step that was undone last.
pub fn redo(state: &mut State, work: &mut Work) {
    turn_history(state, work, History::redo);
}

/// Goes on undoing or redoing steps until as many are done as was asked for in the list of the history. Imports are
/// undone and redone by jobs, one after the other.
pub fn follow_history(state: &mut State, work: &mut Work) {
    let Some(target) = state.dialogs.history_target else { return };
    let waits = state.running.runs(JobKind::Import) || !state.masking.is_kept();
    if waits {
        return;
    }
    let done = |state: &State| state.session.as_ref().map(|session| session.history.names().1);
    let Some(now) = done(state).filter(|now| *now != target) else {
        state.dialogs.history_target = None;
        return;
    };
    turn_history(state, work, if now > target { History::undo } else { History::redo });
    // A step that cannot be undone ends the way.
    if done(state) == Some(now) && !state.running.runs(JobKind::Import) {
        state.dialogs.history_target = None;
    }
    state.window.wake_within(0.0);
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
        Some(StepResult::WriteModel(change)) => turn_model(state, work, &change),
        Some(StepResult::PaintAgain(number, stroke)) => paint_again(state, work, number, &stroke),
        None => (),
    }
}

/// Starts the pending updates, once there has been no edit for a moment.
pub fn follow(state: &mut State, work: &mut Work) {
    autosave_if_due(state, work);
    let now_s = state.window.now_s;
    let Some(session) = &mut state.session else { return };
    // A job that writes uses the project it started with, and a film is drawn by the renderer of the 3D view.
    let busy = [JobKind::Build, JobKind::Fill, JobKind::Import, JobKind::Open, JobKind::Render];
    let busy = busy.into_iter().any(|kind| state.running.runs(kind));
    if busy || session.pending.rests(now_s) {
        return;
    }
    let (invalidation, looks) = session.pending.take();
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
    work.jobs.start(&mut state.running, JobKind::Survey, "Checking layers", move |task| {
        let photos = survey(&folder, &opened.project, &opened.site, &known, task)?;
        Ok(Box::new(move |state| state.stacks_changed(&folder, photos, Vec::new(), false)))
    });
}

/// Starts the job that finds which stacks are up to date, where the stacks that are shown are still the current ones.
fn look_at_states(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let (folder, opened, known) = (session.folder.clone(), session.opened.clone(), session.photos.clone());
    work.jobs.stop_kind(&mut state.running, JobKind::Survey);
    work.jobs.start(&mut state.running, JobKind::Survey, "Checking layers", move |task| {
        let photos = survey(&folder, &opened.project, &opened.site, &known, task)?;
        Ok(Box::new(move |state| state.states_seen(&folder, photos)))
    });
}
