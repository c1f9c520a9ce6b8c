//! Actions for opening, creating and relinking projects: chosen or dropped paths, projects open elsewhere, missing
//! parts, and leaving without losing what runs.

pub mod around;
pub mod assistant;
pub mod chooser;
mod copying;
mod held;
mod looking;
pub mod on_disk;
pub mod open;
mod relinking;
mod sample;

use std::path::{Path, PathBuf};

use self::assistant::{search_site, start_assistant, suggest_model};
use self::chooser::{choose, take_chosen};
use self::copying::{request_for_copy, save_copy};
use self::held::watch_held;
use self::looking::keep_looking;
use self::on_disk::take_changes;
use self::open::{cancel_dialogs, project_at};
use self::relinking::relink_parts;
use self::sample::{open_sample, request_for_sample};
use crate::action::build::opened;
use crate::action::life::{happens, offer_recovery, open_project};
use crate::action::round_trip::import_dropped;
use crate::state::State;
use crate::state::life::{Goal, LifeEvent};
use crate::state::opening::DialogRequest;
use crate::state::session::Session;
use crate::work::Work;
use quadratura_io::recovery::UnsavedChanges;

/// Runs the periodic checks of the dialogs; called once a frame, before drawing.
pub fn watch_opening(state: &mut State, work: &mut Work) {
    take_chosen(state, work);
    watch_held(state, work);
    happens(state, work, LifeEvent::Frame);
    keep_looking(state, work);
    take_changes(state, work);
}

/// Handles files and folders dropped on the window.
pub fn take_dropped(state: &mut State, work: &mut Work, paths: &[PathBuf]) {
    if state.is_asking() {
        return;
    }
    if !import_dropped(state, work, paths) {
        paths.iter().for_each(|path| take_path(state, work, path));
    }
}

/// Handles a request of a dialog.
pub fn grant_opening(state: &mut State, work: &mut Work, request: DialogRequest) {
    match request {
        DialogRequest::New(root) => start_assistant(state, work, root.as_deref()),
        DialogRequest::Take(path) => take_path(state, work, &path),
        DialogRequest::Choose(purpose) => choose(work, purpose),
        DialogRequest::Search => search_site(state, work),
        DialogRequest::SuggestModel => suggest_model(state, work),
        DialogRequest::Create => happens(state, work, LifeEvent::Leave(Goal::Create)),
        DialogRequest::Cancel => cancel_dialogs(state, work),
        DialogRequest::TryAgain(folder) => open_project(state, work, folder),
        DialogRequest::Sample => request_for_sample(state),
        DialogRequest::OpenSample => open_sample(state, work),
        DialogRequest::Copy => request_for_copy(state),
        DialogRequest::SaveCopy => save_copy(state, work),
        DialogRequest::Relink => relink_parts(state, work),
    }
}

/// Opens a project, or starts a new one with anything else.
fn take_path(state: &mut State, work: &mut Work, path: &Path) {
    match project_at(path) {
        Some(folder) => happens(state, work, LifeEvent::Leave(Goal::Open(folder))),
        None => start_assistant(state, work, Some(path)),
    }
}

/// Handles a project that was opened, with unsaved changes found from an earlier run.
pub fn arrived(state: &mut State, work: &mut Work, session: Session, recovered: Option<UnsavedChanges>) {
    opened(state, work, session);
    recovered.into_iter().for_each(|recovered| offer_recovery(state, work, recovered));
}
