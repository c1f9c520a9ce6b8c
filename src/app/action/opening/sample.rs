//! Actions of the sample project: suggests a folder for it, writes it there, and opens it.

use super::open::if_wanted;
use crate::state::State;
use crate::state::opening::DialogRequest;
use crate::state::opening::place::PathField;
use crate::state::request::ProjectRequest;
use crate::state::running::JobKind;
use crate::work::Work;
use quadratura_base::error::Error;
use quadratura_sites::sample::{create_sample, has_sample, project_of_sample, suggested_folder};

/// Shows the dialog, with a folder in the user's home.
pub fn request_for_sample(state: &mut State) {
    let mut folder = PathField::default();
    folder.set(&suggested_folder(&std::env::home_dir().unwrap_or_default()));
    state.opening.dialogs.sample = Some(folder);
}

/// Writes the sample into the folder of the dialog and opens its project; a sample that is there already is opened as
/// it is.
pub fn open_sample(state: &mut State, work: &mut Work) {
    let Some(field) = &mut state.opening.dialogs.sample else { return };
    field.errors.clear();
    let folder = field.path();
    let round = state.opening.round;
    let name = format!("Writing the sample project to {}", folder.display());
    work.jobs.start(&mut state.running, JobKind::Open, name, move |task| {
        let written = if has_sample(&folder) { Ok(()) } else { create_sample(&folder, task).map(drop) };
        if matches!(written, Err(Error::Cancelled)) {
            return Err(Error::Cancelled);
        }
        let arrival = move |state: &mut State| {
            let Some(field) = &mut state.opening.dialogs.sample else { return Vec::new() };
            if let Err(error) = written {
                field.errors = vec![error.to_string()];
                return Vec::new();
            }
            state.opening.dialogs.sample = None;
            let project = DialogRequest::Take(project_of_sample(&folder));
            vec![ProjectRequest::Dialog(project).into()]
        };
        Ok(if_wanted(round, Box::new(arrival)))
    });
}
