//! Saving the project, and autosaving unsaved changes.

use std::path::Path;

use crate::state::State;
use crate::state::life::Autosave;
use crate::state::notes::{Note, Weight};
use crate::state::running::JobKind;
use crate::work::Work;
use crate::work::jobs::arrival;
use quadratura_base::error::{Error, Result};
use quadratura_document::Project;
use quadratura_io::project::change_project;

impl State {
    /// Returns whether there are unsaved changes.
    pub fn is_dirty(&self) -> bool {
        self.session.as_ref().is_some_and(|session| session.history.is_dirty()) || !self.masking.is_kept()
    }

    fn not_kept(&mut self, folder: &Path, error: &Error) {
        let now_s = self.window.now_s;
        if let Some(session) = self.session.as_mut().filter(|session| session.folder == folder) {
            session.pending.keep.failed(now_s);
        }
        let text = format!("Autosaving failed and is tried again: {error}");
        self.notify(Note::new(Weight::Problem, text));
    }
}

/// Saves the project; returns whether it succeeded. A note gives the reason where it did not.
pub fn save_project(state: &mut State, work: &mut Work) -> bool {
    match save(state, work) {
        Ok(()) => true,
        Err(error) => {
            state.notify(Note::new(Weight::Problem, format!("The project was not saved: {error}")));
            false
        }
    }
}

/// Saves the project.
///
/// # Errors
/// [`Error::Io`]: the file on disk is unchanged, and the changes stay unsaved.
pub fn save(state: &mut State, work: &mut Work) -> Result<()> {
    let Some(session) = &mut state.session else { return Ok(()) };
    let (folder, project, known) = (&session.folder, session.history.present(), session.history.on_disk());
    let save = || {
        change_project(folder, |now| {
            // An import that has just ended has added its masks to the file.
            let masks = now.map(|now| project.masks.merged_with_changes(&known.masks, &now.masks));
            let masks = masks.unwrap_or_else(|_| project.masks.clone());
            Ok(Project { masks, ..Project::clone(project) })
        })
    };
    let Some(autosave) = &work.autosave else { return Ok(()) };
    let ((), forgotten) = autosave.saved(save)?;
    session.history.saved();
    session.pending.keep = Autosave::default();
    if let Err(error) = forgotten {
        state.notify(Note::new(Weight::Warning, error.message()));
    }
    Ok(())
}

/// Discards the unsaved changes, as the user decided on leaving the project.
pub fn discard_unsaved(state: &mut State, work: &mut Work) {
    state.masking.forget_waiting();
    let Some(session) = &mut state.session else { return };
    session.pending.keep = Autosave::default();
    let forgotten = work.autosave.as_ref().map_or(Ok(()), |autosave| autosave.forget());
    if let Err(error) = forgotten {
        state.notify(Note::new(Weight::Warning, error.message()));
    }
}

/// Autosaves unsaved changes when it is time to.
pub fn autosave_if_due(state: &mut State, work: &mut Work) {
    want_kept(state, work);
    let now_s = state.window.now_s;
    let writes = state.running.runs(JobKind::Keep);
    let Some(session) = state.session.as_mut().filter(|session| session.pending.keep.is_due()) else {
        return;
    };
    if writes || !session.pending.keep.begins(now_s) {
        return state.window.wake_within(session.pending.keep.rest_s());
    }
    let (folder, Some(autosave)) = (session.folder.clone(), work.autosave.clone()) else { return };
    work.jobs.start(&mut state.running, JobKind::Keep, "Autosaving", move |_| {
        let kept = autosave.write();
        drop(autosave);
        Ok(arrival(move |state| kept.unwrap_or_else(|error| state.not_kept(&folder, &error))))
    });
}

/// Passes the edits since the last call to the autosave.
fn want_kept(state: &mut State, work: &Work) {
    let (Some(session), Some(autosave)) = (&mut state.session, &work.autosave) else { return };
    if session.pending.keep.take_news() {
        autosave.want(session.history.is_dirty().then(|| session.history.present().clone()));
    }
}

/// Autosaves unsaved changes at once, because the program may be about to end.
pub fn keep_now(state: &mut State, work: &mut Work) {
    want_kept(state, work);
    let kept = work.autosave.as_ref().map_or(Ok(()), |autosave| autosave.write());
    if let Err(error) = kept {
        state.notes.add(Note::new(Weight::Problem, error.message()));
    }
}
