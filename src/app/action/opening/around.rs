//! Actions that go with every project that is opened or left: missing files, the check of a new one, the watch on its
//! files.

use super::on_disk::watch_disk;
use crate::action::check::check_project;
use crate::state::State;
use crate::state::opening::relinking::Relinking;
use crate::work::Work;
use quadratura_document::names::file_name_of_photo;
use quadratura_sites::relink::{missing_photos, parts_of};

impl State {
    /// Shows which files of the open project are missing.
    pub fn show_missing(&mut self) {
        let Some(session) = &self.session else { return };
        let parts = parts_of(&session.folder, &session.opened.project);
        let mut missing = missing_photos(&session.opened.problems, &parts);
        missing.extend(session.missing_since().map(str::to_owned));
        self.opening.dialogs.relinking = Some(Relinking::of_photos(session.folder.clone(), parts, missing));
    }
}

/// Drops results that are on their way, because the project was left.
pub fn forget_opening(state: &mut State, work: &mut Work) {
    state.opening.round += 1;
    work.on_disk = None;
}

/// Starts everything that follows opening a project, beside showing it.
pub fn welcome_session(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let parts = parts_of(&session.folder, &session.opened.project);
    // Cameras often name more photos than are used; a photo that was built before is missing.
    let built = |photo: &String| session.folder.join("stacks").join(file_name_of_photo(photo)).exists();
    let missing = missing_photos(&session.opened.problems, &parts);
    if missing.iter().any(built) {
        state.opening.dialogs.relinking = Some(Relinking::of_photos(session.folder.clone(), parts, missing));
    }
    if std::mem::take(&mut state.opening.check_next) {
        check_project(state, work);
    }
    watch_disk(state, work);
}
