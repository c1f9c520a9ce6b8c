//! Decisions of the user: their undo and redo, and the updates that follow from them.

use std::path::PathBuf;

use crate::app::action::objects::follow_objects;
use crate::app::action::round_trip::importing::{import_again, take_back_import};
use crate::app::action::saving::autosave_if_due;
use crate::app::quality::colour::follow_colour;
use crate::app::state::State;
use crate::app::state::ask::{BuildAsk, MaskAsk};
use crate::app::state::notes::{Note, Remedy, Weight};
use crate::app::state::pending::Invalidation;
use crate::app::state::running::JobKind;
use crate::app::state::selection::Selection;
use crate::app::state::session::survey;
use crate::app::work::Work;
use crate::app::work::jobs::{Arrival, arrival};
use crate::document::Project;
use crate::document::history::{History, StepResult};
use crate::error::Error;
use crate::recipe::open::open_site;
use crate::recipe::site_stamp::SiteStamp;

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
    session.pending.reread();
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
        session.pending.failed(invalidation);
        let (weight, why) = match error {
            Error::Cancelled => (Weight::Warning, "stopped".to_owned()),
            error => (Weight::Problem, error.to_string()),
        };
        let text = format!("The site was not read again ({why}): views and photos show it as it was before.");
        state.tell(Note::new(weight, text).with("Read files again", Remedy::ReadAgain));
    })
}
