//! The watch on saved documents: it begins with a project, and each save is imported.

use super::importing::read_history;
use crate::state::State;
use crate::state::request::Request;
use crate::state::round_trip::report::Way;
use crate::work::Work;
use crate::work::live_project::LiveProject;
use crate::work::watching::{News, Watching};
use quadratura_editing::editing;

/// Starts the watch after a project was opened: documents saved in the meantime are imported.
pub fn begin_round_trip(state: &mut State, work: &mut Work) {
    leave_round_trip(state, work);
    watch_for_saves(state, work);
    read_history(state, work);
}

/// Resets the state and stops the watch, because another project or none is open.
pub fn leave_round_trip(state: &mut State, work: &mut Work) {
    state.round_trip.forget();
    (work.choosing, work.watching, work.live) = (None, None, LiveProject::default());
}

/// Starts the watch for saved documents, if there is a folder and no watch yet.
pub fn watch_for_saves(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    if work.watching.is_none() && editing::folder(&session.folder).is_dir() {
        work.watching = Watching::start(session, work.live.paint.clone(), work.waker.clone());
    }
}

/// Handles documents that were saved; returns the requests to apply next.
pub fn take_saved(state: &mut State, work: &mut Work) -> Vec<Request> {
    let Some(watching) = &work.watching else { return Vec::new() };
    let (news, ended) = watching.take();
    // A watch that has ended can be started again.
    if ended {
        work.watching = None;
    }
    let mut requests = Vec::new();
    for news in news {
        match news {
            News::Imported(imported, spent) => requests.extend(state.paint_came(imported, spent, Way::Saved)),
            News::Said(note) => state.notify(note),
        }
    }
    requests
}
