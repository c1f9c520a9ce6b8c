//! Opens a project, or turns the reason why it cannot be opened into a dialog.

use std::path::{Path, PathBuf};

use crate::action::build::close_project;
use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::state::opening::held::Held;
use crate::state::opening::relinking::Relinking;
use crate::state::request::ProjectRequest;
use crate::state::running::JobKind;
use crate::state::session::Session;
use crate::work::Work;
use crate::work::jobs::{Arrival, arrival};
use quadratura_base::error::{Error, Result};
use quadratura_files::lock::ProjectLock;
use quadratura_io::project::{PROJECT_FILE, read_project};
use quadratura_sites::discover::SitePart;
use quadratura_sites::relink::{gone, parts_of};

/// Opens the project in `folder`, after all questions were answered.
pub fn open_now(state: &mut State, work: &mut Work, folder: PathBuf) {
    let folder = project_at(&folder).unwrap_or(folder);
    close_project(state, work);
    cancel_dialogs(state, work);
    let name = format!("Opening {}", folder.display());
    let round = state.opening.round;
    work.jobs.start(&mut state.running, JobKind::Open, name, move |task| {
        let arrival: Arrival = match Session::open(&folder, task) {
            Ok(opened) => {
                let opened = ProjectRequest::Opened(Box::new(opened));
                Box::new(move |_| vec![opened.into()])
            }
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => obstacle(folder, error)?,
        };
        Ok(if_wanted(round, arrival))
    });
}

/// Closes the open dialogs.
pub fn cancel_dialogs(state: &mut State, work: &mut Work) {
    if state.opening.dialogs.assistant.take().is_some() {
        work.jobs.stop_kind(&mut state.running, JobKind::Search);
    }
    work.jobs.stop_kind(&mut state.running, JobKind::Paths);
    let dialogs = &mut state.opening.dialogs;
    (dialogs.relinking, dialogs.sample, dialogs.copy) = (None, None, None);
    (state.opening.held, state.opening.typing) = (None, false);
}

/// Drops an arrival where a project was left since `round`.
pub fn if_wanted(round: u64, arrival: Arrival) -> Arrival {
    Box::new(move |state| if state.opening.round == round { arrival(state) } else { Vec::new() })
}

/// Returns the project's folder, for a folder with a project or its file.
pub fn project_at(path: &Path) -> Option<PathBuf> {
    if path.file_name().is_some_and(|name| name == PROJECT_FILE) {
        return path.parent().map(PathBuf::from);
    }
    path.join(PROJECT_FILE).is_file().then(|| path.to_path_buf())
}

/// Turns an error of opening into a dialog, where the user can resolve it.
fn obstacle(folder: PathBuf, error: Error) -> Result<Arrival> {
    if let Some(holder) = ProjectLock::holder(&folder) {
        return Ok(arrival(move |state| state.opening.held = Some(Held::by(folder, holder))));
    }
    let Ok(project) = read_project(&folder) else { return Err(error) };
    let parts = parts_of(&folder, &project);
    let gone = gone(&parts);
    if gone.is_empty() {
        return Err(error);
    }
    Ok(arrival(move |state| {
        let names: Vec<&str> = gone.iter().map(|part: &SitePart| part.name()).collect();
        let text = format!("{}: {} not found", folder.display(), names.join(", "));
        state.notes.add(Note::new(Weight::Problem, text));
        state.opening.dialogs.relinking = Some(Relinking::of_parts(folder, parts, &gone));
    }))
}
