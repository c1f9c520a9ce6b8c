//! Starts the jobs that make results for a view.

use crate::state::State;
use crate::state::flat::slot::{Due, ResultSlot};
use crate::state::notes::Note;
use crate::state::running::JobKind;
use crate::work::Work;
use crate::work::jobs::arrival;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;

/// A request for a result.
pub struct ResultRequest<K, V> {
    /// The key of the requested result.
    pub key: K,
    /// The name of the job.
    pub name: &'static str,
    /// Whether a running job for another key is stopped. Otherwise it is finished first, so that the view shows
    /// something while keys change quickly.
    pub gives_up: bool,
    /// Finds the slot in the state.
    pub slot: fn(&mut State) -> &mut ResultSlot<K, V>,
}

/// Starts a job for a request, unless its result exists, is being made, or has failed.
pub fn want<K: Clone + PartialEq + Send + 'static, V: Send + 'static>(
    state: &mut State,
    work: &mut Work,
    request: ResultRequest<K, V>,
    make: impl FnOnce(&Task) -> Result<V> + Send + 'static,
) {
    let ResultRequest { key, name, gives_up, slot } = request;
    let runs = slot(state).job().is_some_and(|job| state.running.is_running(job));
    let Due::Job(former) = slot(state).due(&key, runs, gives_up) else { return };
    former.into_iter().for_each(|job| work.jobs.stop(&mut state.running, job));
    let asked = key.clone();
    let job = work.jobs.start(&mut state.running, JobKind::FlatView, name, move |task| {
        let made = make(task);
        if matches!(made, Err(Error::Cancelled)) {
            return Err(Error::Cancelled);
        }
        Ok(arrival(move |state| {
            let failed = slot(state).arrived(key, made);
            failed.iter().flat_map(|error| Note::of_error(name, error)).for_each(|note| state.notify(note));
        }))
    });
    slot(state).is_asked(asked, job);
}
