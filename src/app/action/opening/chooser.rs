//! Handles files and folders that were chosen in a dialog of the system. Where there is none, the path is typed.

use std::path::PathBuf;

use super::assistant::start_assistant;
use super::copying::place_of_copy;
use super::relinking::copy_photo;
use crate::action::life::open_project;
use crate::action::masks::repairing::bring_mask;
use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::state::opening::Purpose;
use crate::work::Work;
use crate::work::chooser::FileDialogAnswer;
use quadratura_sites::sample::folder_in;

/// Opens a file dialog.
pub fn choose(work: &mut Work, purpose: Purpose) {
    work.chooser.choose(purpose, work.waker.clone());
}

/// Handles the answer of the file dialog.
pub fn take_chosen(state: &mut State, work: &mut Work) {
    match work.chooser.take() {
        Some((purpose, FileDialogAnswer::Path(path))) => take_choice(state, work, purpose, path),
        Some((purpose, FileDialogAnswer::NoDialog)) => without_dialog(state, &purpose),
        Some((_, FileDialogAnswer::Nothing)) | None => (),
    }
}

/// Says how to go on where the desktop shows no dialog for files.
pub fn without_dialog(state: &mut State, purpose: &Purpose) {
    if let Purpose::Mask(it) = purpose {
        return state.tell_place_of_mask(it);
    }
    state.opening.typing = *purpose == Purpose::Project;
    if !state.opening.typing {
        let text = "This desktop has no file dialog: type the path, or drop the file or folder on the window";
        state.notify(Note::new(Weight::Warning, text));
    }
}

/// Handles a path that was chosen.
pub fn take_choice(state: &mut State, work: &mut Work, purpose: Purpose, path: PathBuf) {
    match purpose {
        Purpose::Project => open_project(state, work, path),
        Purpose::Site => start_assistant(state, work, Some(&path)),
        Purpose::Photo(name) => copy_photo(state, work, &name, &path),
        Purpose::Mask(it) => bring_mask(state, work, *it, path),
        Purpose::Folder => {
            if let Some(assistant) = &mut state.opening.dialogs.assistant {
                assistant.goes_to(&path);
            }
        }
        Purpose::Copy => {
            let name = state.session.as_ref().map(|session| session.name()).unwrap_or_default();
            if let Some(field) = &mut state.opening.dialogs.copy {
                field.set(&place_of_copy(&path, &name));
            }
        }
        Purpose::Sample => {
            if let Some(field) = &mut state.opening.dialogs.sample {
                field.set(&folder_in(&path));
            }
        }
        Purpose::Part(part, _) => {
            if let Some(assistant) = &mut state.opening.dialogs.assistant {
                assistant.places[part as usize].set(&path);
            } else if let Some(relinking) = &mut state.opening.dialogs.relinking {
                relinking.found(part, &path);
            }
        }
    }
}
