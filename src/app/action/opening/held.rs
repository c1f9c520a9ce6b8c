//! Waits for a project that is open elsewhere, and opens it as soon as it is free.

use crate::state::State;
use crate::state::opening::held::LOOKS_EVERY_S;
use crate::state::request::ProjectRequest;
use crate::state::running::JobKind;
use crate::work::Work;
use quadratura_files::lock::ProjectLock;

/// Opens the project when its lock is free.
pub fn watch_held(state: &mut State, work: &mut Work) {
    let Some(held) = &mut state.opening.held else { return };
    let now_s = state.window.now_s;
    state.window.wake_within(LOOKS_EVERY_S);
    if state.running.runs(JobKind::Lock) || !held.looks(now_s) {
        return;
    }
    let folder = held.folder.clone();
    work.jobs.start(&mut state.running, JobKind::Lock, "Checking the project's lock", move |_| {
        let is_free = ProjectLock::holder(&folder).is_none();
        Ok(Box::new(move |state| {
            let waits = state.opening.held.as_ref().is_some_and(|held| held.folder == folder);
            let opens = (is_free && waits).then(|| ProjectRequest::OpenNow(folder).into());
            opens.into_iter().collect()
        }))
    });
}
