//! System dialogs for the files and folders of the round trip.

use crate::state::State;
use crate::state::round_trip::dialogs::DialogPurpose;
use crate::work::Work;
use crate::work::choosing::Choosing;

/// Opens a system dialog.
pub fn choose_path(state: &mut State, work: &mut Work, wanted: DialogPurpose) {
    let folder = state.session.as_ref().map(|session| session.folder.clone()).unwrap_or_default();
    work.choosing = Choosing::start(wanted, &folder, work.waker.clone());
}

/// Handles the answer of the system dialog.
pub fn take_chosen_files(state: &mut State, work: &mut Work) {
    let Some((wanted, chosen)) = work.choosing.as_ref().and_then(Choosing::answer) else { return };
    work.choosing = None;
    state.take_chosen(wanted, &chosen);
}
