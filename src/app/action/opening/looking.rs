//! Checks the paths of a dialog on disk, in a job, while the user types.

use std::time::Instant;

use crate::state::State;
use crate::state::running::JobKind;
use crate::work::Work;
use crate::work::jobs::arrival;
use quadratura_sites::discover::look_at;

/// Starts a check of the paths when one is due.
pub fn keep_looking(state: &mut State, work: &mut Work) {
    let now_s = state.window.now_s;
    let parts = state.opening.dialogs.parts();
    let (is_shown, is_busy) = (parts.is_some(), state.running.runs(JobKind::Paths));
    let looking = &mut state.opening.looking;
    parts.into_iter().for_each(|parts| looking.want(parts, now_s));
    let Some(rest_s) = looking.rest_s(is_shown, is_busy, now_s) else { return };
    if rest_s > 0.0 {
        return state.window.wake_within(rest_s);
    }
    let (parts, before) = (looking.begin(now_s), looking.look.clone());
    work.jobs.stop_kind(&mut state.running, JobKind::Paths);
    work.jobs.start(&mut state.running, JobKind::Paths, "Checking files", move |task| {
        let since = Instant::now();
        let look = look_at(&parts, before.as_ref(), task)?;
        let took_s = since.elapsed().as_secs_f64();
        Ok(arrival(move |state| state.opening.looking.found(look, took_s)))
    });
}
