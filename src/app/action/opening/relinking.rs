//! Actions on missing parts of a project: copies photos, and updates the project with new paths.

use std::path::Path;

use crate::action::life::open_project;
use crate::state::State;
use crate::state::request::{ProjectRequest, Request};
use crate::state::running::JobKind;
use crate::work::Work;
use quadratura_base::error::Result;
use quadratura_files::lock::ProjectLock;
use quadratura_sites::relink::{bring_photo, relink, relinked};

impl State {
    /// Takes the result of copying the file of a photo; opens the project when none is missing any more.
    fn brought(&mut self, name: &str, brought: Result<()>) -> Vec<Request> {
        let Some(relinking) = &mut self.opening.dialogs.relinking else { return Vec::new() };
        match brought {
            Ok(()) => relinking.photos.retain(|photo| photo != name),
            Err(error) => relinking.errors.push(error.to_string()),
        }
        let is_whole = relinking.photos.is_empty();
        is_whole.then(|| ProjectRequest::Open(relinking.folder.clone()).into()).into_iter().collect()
    }
}

/// Starts copying the file of a photo to where the project expects it.
pub fn copy_photo(state: &mut State, work: &mut Work, name: &str, file: &Path) {
    let Some(relinking) = &mut state.opening.dialogs.relinking else { return };
    relinking.errors.clear();
    let (photos, name, file) = (relinking.was.photos.clone(), name.to_owned(), file.to_path_buf());
    work.jobs.start(&mut state.running, JobKind::Import, format!("Copying {name}"), move |_| {
        let brought = bring_photo(&photos, &name, &file);
        Ok(Box::new(move |state| state.brought(&name, brought)))
    });
}

/// Updates the project with the new paths: an open one by a step that can be undone, one that cannot be opened in its
/// file.
pub fn relink_parts(state: &mut State, work: &mut Work) {
    let Some(relinking) = &state.opening.dialogs.relinking else { return };
    let (folder, parts) = (relinking.folder.clone(), relinking.parts());
    let open = state.session.as_ref().filter(|session| session.folder == folder);
    let message = match open {
        Some(session) => relinked(session.history.present(), &folder, &parts).map(Some),
        None => ProjectLock::take(&folder).and_then(|_lock| relink(&folder, &parts)).map(|()| None),
    };
    match message {
        Ok(Some(project)) => {
            state.opening.dialogs.relinking = None;
            state.edit("new locations of files", project, None);
        }
        Ok(None) => open_project(state, work, folder),
        Err(error) => {
            if let Some(relinking) = &mut state.opening.dialogs.relinking {
                relinking.errors = vec![error.to_string()];
            }
        }
    }
}
