//! Saves a copy of the open project, with the decisions that are not saved yet.

use std::path::{Path, PathBuf};

use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::state::numbers::{counted, grouped};
use crate::state::opening::place::PathField;
use crate::state::running::JobKind;
use crate::work::Work;
use crate::work::jobs::arrival;
use quadratura_io::project::check_is_empty;
use quadratura_sites::copy::copy_project;

/// Shows the dialog, with a free folder beside the project.
pub fn request_for_copy(state: &mut State) {
    let Some(session) = &state.session else { return };
    let folder = session.folder.canonicalize().unwrap_or_else(|_| session.folder.clone());
    let mut field = PathField::default();
    field.set(&free_place(folder.parent().unwrap_or(&folder), &session.name()));
    state.opening.dialogs.copy = Some(field);
}

/// Returns the folder for a copy of the project of this name, for the folder that was chosen: that folder where it is
/// empty, else one below it.
pub fn place_of_copy(chosen: &Path, name: &str) -> PathBuf {
    match check_is_empty(chosen) {
        Ok(()) => chosen.to_path_buf(),
        Err(_) => free_place(chosen, name),
    }
}

/// Returns a folder in `above` that does not exist yet.
fn free_place(above: &Path, name: &str) -> PathBuf {
    let place = |number: u32| match number {
        1 => above.join(format!("{name}-copy")),
        number => above.join(format!("{name}-copy-{number}")),
    };
    (1..).map(place).find(|place| !place.exists()).expect("some number is free")
}

/// Starts the job that copies the project to the folder of the dialog.
pub fn save_copy(state: &mut State, work: &mut Work) {
    let (Some(field), Some(session)) = (&mut state.opening.dialogs.copy, &state.session) else { return };
    let to = field.path();
    if let Err(error) = check_is_empty(&to) {
        field.errors = vec![error.to_string()];
        return;
    }
    state.opening.dialogs.copy = None;
    let (folder, project, lock) =
        (session.folder.clone(), session.history.present().clone(), session.lock.clone());
    let (stacks, paint) = (work.live.stacks.clone(), work.live.paint.clone());
    let name = format!("Copying the project to {}", to.display());
    work.jobs.start(&mut state.running, JobKind::Export, name, move |task| {
        // Layers and paint are copied when they are complete.
        let _locks = (lock, stacks.take(), paint.take());
        let copied = copy_project(&folder, &project, &to, task)?;
        let (files, megabytes) = (counted(copied.files, "file"), grouped(copied.bytes.div_ceil(1_000_000)));
        let text = format!("A copy of the project was saved: {}, {files}, {megabytes} MB", to.display());
        Ok(arrival(move |state| state.notify(Note::new(Weight::Info, text))))
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_is_placed_where_nothing_is() {
        let folder = tempfile::tempdir().unwrap();
        let above = folder.path();
        assert_eq!(place_of_copy(above, "castle"), above);
        std::fs::create_dir(above.join("castle-copy")).unwrap();
        assert_eq!(place_of_copy(above, "castle"), above.join("castle-copy-2"));
    }
}
