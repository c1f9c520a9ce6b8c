//! What the window remembers of projects, together with all other windows: which were opened last, and in which updates are
//! paused.

use std::path::Path;

use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::work::Work;
use quadratura_io::known_projects::KnownProjects;

/// Remembers that a project was opened; its updates are paused where they were.
pub fn remember_opened(state: &mut State, work: &mut Work, project: &Path) {
    remember(state, work, project);
    let usual = state.updating.usual.unwrap_or(state.settings.keep_up_to_date);
    state.updating.usual = Some(usual);
    state.settings.keep_up_to_date = usual && !state.settings.known.is_paused(project);
}

/// Puts a project at the top of the list of recent ones.
pub fn remember(state: &mut State, work: &Work, project: &Path) {
    change(state, work, |known| known.remember(project));
}

/// Ends what belongs to the project that is left.
pub fn leave_known(state: &mut State) {
    if let Some(usual) = state.updating.usual.take() {
        state.settings.keep_up_to_date = usual;
    }
}

/// Removes a project from the list of recent ones.
pub fn forget_project(state: &mut State, work: &mut Work, project: &Path) {
    change(state, work, |known| known.forget(project));
}

/// Follows what other windows have opened, and remembers where updates were paused or resumed here. Called once a frame.
pub fn follow_known(state: &mut State, work: &mut Work) {
    if let Some(known) = work.known.news(state.window.now_s) {
        state.settings.known = known;
    }
    let Some(session) = state.session.as_ref().filter(|_| state.updating.usual == Some(true)) else { return };
    let (folder, paused) = (session.folder.clone(), !state.settings.keep_up_to_date);
    if state.updating.paused != Some(paused) {
        state.updating.paused = Some(paused);
        if state.settings.known.is_paused(&folder) != paused {
            change(state, work, |known| known.pause(&folder, paused));
        }
    }
}

fn change(state: &mut State, work: &Work, change: impl Fn(&mut KnownProjects)) {
    if let Err(error) = work.known.change(&mut state.settings.known, change) {
        let text = format!("other windows do not know of this: {error}");
        state.notify(Note::new(Weight::Warning, text));
    }
}
