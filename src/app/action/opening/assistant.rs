//! Actions of the assistant for new projects: searches the folder of a site, and creates the project.

use std::path::{Path, PathBuf};

use super::open::if_wanted;
use crate::action::build::{close_project, opened};
use crate::state::State;
use crate::state::opening::looking::Looking;
use crate::state::opening::place::typed_path;
use crate::state::request::ProjectRequest;
use crate::state::running::JobKind;
use crate::state::session::Session;
use crate::work::Work;
use crate::work::jobs::arrival;
use quadratura_base::error::{Error, Result};
use quadratura_files::free_path::free_path;
use quadratura_import::cameras::CameraOptions;
use quadratura_sites::create::{self, NewProject};
use quadratura_sites::discover::{Candidates, SitePart, SiteParts, find_site, part_at};
use quadratura_sites::suggest::{SuggestFor, write_suggestion};

impl State {
    /// Fills in the result of a search; `known` is a part that was given.
    fn searched(&mut self, root: &Path, found: Result<Candidates>, known: Option<(SitePart, PathBuf)>) {
        let Some(assistant) = &mut self.opening.dialogs.assistant else { return };
        assistant.root_error = found.as_ref().err().map(ToString::to_string);
        if found.is_err() {
            assistant.forget_found();
        }
        found.into_iter().for_each(|candidates| assistant.take(root, candidates));
        if let Some((part, path)) = known {
            assistant.places[part as usize].set(&path);
        }
    }
}

impl State {
    /// Takes in a model that was suggested, or the reason why there is none.
    fn first_model_suggested(&mut self, made: Result<PathBuf>) {
        let Some(assistant) = &mut self.opening.dialogs.assistant else { return };
        let place = &mut assistant.places[SitePart::Model as usize];
        match made {
            Ok(file) => place.set(&file),
            Err(error) => place.errors.push(error.to_string()),
        }
    }
}

/// Shows the assistant; a folder is searched for a site, a part of a site is filled in.
pub fn start_assistant(state: &mut State, work: &mut Work, path: Option<&Path>) {
    if state.opening.dialogs.assistant.is_none() {
        state.opening.looking = Looking::default();
    }
    let assistant = state.opening.dialogs.assistant.get_or_insert_default();
    let Some(path) = path else { return };
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let part = part_at(&path);
    if let Some(part) = part {
        assistant.places[part as usize].set(&path);
        if !assistant.root.is_empty() {
            return;
        }
    }
    let root = if path.is_dir() { path.clone() } else { path.parent().unwrap_or(&path).to_path_buf() };
    assistant.root = root.display().to_string();
    search_in(state, work, root, part.map(|part| (part, path)));
}

/// Starts the search of the site folder that was typed.
pub fn search_site(state: &mut State, work: &mut Work) {
    let root = state.opening.dialogs.assistant.as_ref().map(|assistant| typed_path(&assistant.root));
    root.into_iter().for_each(|root| search_in(state, work, root, None));
}

/// Starts the search of `root`, of which one part may be known.
fn search_in(state: &mut State, work: &mut Work, root: PathBuf, known: Option<(SitePart, PathBuf)>) {
    work.jobs.stop_kind(&mut state.running, JobKind::Search);
    let name = format!("Searching {}", root.display());
    work.jobs.start(&mut state.running, JobKind::Search, name, move |task| {
        let found = match find_site(&root, task) {
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            found => found,
        };
        Ok(arrival(move |state| state.searched(&root, found, known)))
    });
}

/// Starts suggesting a model from photos and cameras; it is written into the site folder, where it becomes the model of the
/// project.
pub fn suggest_model(state: &mut State, work: &mut Work) {
    let Some(assistant) = &mut state.opening.dialogs.assistant else { return };
    let SiteParts { photos, cameras, .. } = assistant.parts();
    assistant.places[SitePart::Model as usize].errors.clear();
    let root = typed_path(&assistant.root);
    let beside = photos.parent().map(Path::to_path_buf).unwrap_or_default();
    let folder = if root.is_dir() { root } else { beside };
    let round = state.opening.round;
    work.jobs.start(&mut state.running, JobKind::Model, "Suggesting a model", move |task| {
        let out = free_path(&folder.join("suggested.obj"), |_| false).path;
        let source = SuggestFor::Folders { photos, cameras, options: CameraOptions::default() };
        let made = match write_suggestion(&source, None, &out, false, task) {
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            made => made.map(|_| out),
        };
        Ok(if_wanted(round, arrival(move |state| state.first_model_suggested(made))))
    });
}

/// Creates the project and opens it; errors are shown beside the paths that they are about.
pub fn create_project(state: &mut State, work: &mut Work) {
    let Some(assistant) = &mut state.opening.dialogs.assistant else { return };
    let (parts, folder) = (assistant.parts(), assistant.folder.path());
    assistant.places.iter_mut().for_each(|place| place.errors.clear());
    assistant.folder.errors.clear();
    let name = format!("Creating {}", folder.display());
    let round = state.opening.round;
    work.jobs.start(&mut state.running, JobKind::Open, name, move |task| {
        let new = NewProject {
            photos: parts.photos.clone(),
            cameras: parts.cameras.clone(),
            model: parts.model.clone(),
            ..NewProject::default()
        };
        let made = create::create_project(&folder, &new, task)
            .and_then(|opened| Session::new(&folder, opened, task));
        match made {
            Err(Error::Cancelled) => Err(Error::Cancelled),
            made => {
                let made = ProjectRequest::Created(parts, Box::new(made));
                Ok(if_wanted(round, Box::new(move |_| vec![made.into()])))
            }
        }
    });
}

/// Handles the result of creating a project.
pub fn created(state: &mut State, work: &mut Work, parts: &SiteParts, made: Result<Session>) {
    match made {
        Ok(session) => {
            close_project(state, work);
            state.opening.dialogs.assistant = None;
            state.opening.check_next = true;
            opened(state, work, session);
        }
        Err(error) => {
            if let Some(assistant) = &mut state.opening.dialogs.assistant {
                assistant.refuse(parts, &error);
            }
        }
    }
}
