//! Watches the files of the site on disk, and offers to read them again when they have changed. Plants are read again at once.

use crate::state::State;
use crate::state::notes::{NoteRemedy, changed, plants_changed};
use crate::work::Work;
use crate::work::on_disk::{FoundOnDisk, OnDisk};

/// Starts watching the files that the site was read from.
pub fn watch_disk(state: &mut State, work: &mut Work) {
    work.on_disk = state.session.as_ref().and_then(|session| OnDisk::new(session, work.waker.clone()));
}

/// Reports changes that the thread has found.
pub fn take_changes(state: &mut State, work: &mut Work) {
    let (Some(on_disk), Some(session)) = (&work.on_disk, &state.session) else { return };
    on_disk.follow(session.history.present());
    for found in on_disk.take() {
        match found {
            FoundOnDisk::Site(now) => {
                let changes = state.session.as_ref().map_or(Vec::new(), |session| session.seen.changes(&now));
                if !changes.is_empty() {
                    state.notify(changed(&changes).with("Reload from disk", NoteRemedy::ReadAgain));
                }
            }
            FoundOnDisk::Plants { there, missing } => {
                state.trees.files_changed();
                plants_changed(&there, &missing).into_iter().for_each(|note| state.notify(note));
            }
        }
    }
}
