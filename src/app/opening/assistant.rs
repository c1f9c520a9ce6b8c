//! The assistant for new projects: typed paths, detected contents, and the creation of the project.

use std::path::{Path, PathBuf};

use super::place::PathField;
use super::{if_wanted, looking::Looking, typed_path};
use crate::app::action::build::close_project;
use crate::app::action::build::opened;
use crate::app::state::State;
use crate::app::state::ask::ProjectAsk;
use crate::app::state::running::JobKind;
use crate::app::state::session::Session;
use crate::app::work::Work;
use crate::app::work::jobs::arrival;
use crate::error::{Error, Result};
use crate::geometry::Similarity;
use crate::io::project::check_is_empty;
use crate::layers::Options;
use crate::recipe::create::{self, NewProject};
use crate::recipe::discover::{Candidates, SitePart, SiteParts, find_site, folder_beside, part_at};

/// The state of the assistant.
#[derive(Default)]
pub struct Assistant {
    /// The site folder that is searched.
    pub root: String,
    /// The error of the search.
    pub root_error: Option<String>,
    /// Whether the search of the site folder stopped at its limit.
    pub cut_short: bool,
    /// The paths of photos, cameras and model, in the order of [`SitePart::ALL`].
    pub places: [PathField; 3],
    /// The project folder.
    pub folder: PathField,
    /// Whether the user chose the project folder: it is not replaced by a suggestion any more.
    folder_is_theirs: bool,
    /// The project folder that was checked last, and the reason why the project cannot be created there.
    judged: (PathBuf, Option<String>),
}

impl Assistant {
    /// Returns the parts as typed.
    pub fn parts(&self) -> SiteParts {
        let [photos, cameras, model] = [0, 1, 2].map(|part: usize| self.places[part].path());
        SiteParts { photos, cameras, model }
    }

    /// Sets the project folder that the user chose.
    pub fn goes_to(&mut self, folder: &Path) {
        self.folder.set(folder);
        self.folder_is_theirs = true;
    }

    /// Marks the project folder as typed by the user.
    pub fn folder_typed(&mut self) {
        self.folder.errors.clear();
        self.folder_is_theirs = true;
    }

    /// Checks whether the project can be created in its folder, once for each folder.
    pub fn judge_folder(&mut self) {
        let folder = self.folder.path();
        if folder != self.judged.0 {
            let refused = check_is_empty(&folder).err().map(|error| error.to_string());
            self.judged = (folder, refused);
        }
    }

    /// Returns the reason why the project cannot be created in its folder.
    pub fn objection(&self) -> Option<&str> {
        match self.judged.0.as_os_str().is_empty() {
            true => Some("Give a new or empty folder."),
            false => self.judged.1.as_deref(),
        }
    }

    /// Fills in the detected parts; the others stay unchanged.
    fn take(&mut self, root: &Path, candidates: Candidates) {
        self.cut_short = candidates.cut_short;
        for part in SitePart::ALL {
            let found = candidates.of(part);
            self.places[part as usize].searched = true;
            if let Some(best) = found.first() {
                self.places[part as usize].set(best);
                self.places[part as usize].offered = found.to_vec();
            }
        }
        if !self.folder_is_theirs {
            self.folder.set(&folder_beside(root));
        }
    }

    /// Shows each error beside the path that it is about.
    fn refuse(&mut self, parts: &SiteParts, error: &Error) {
        let errors = match error {
            Error::Several(errors) => errors.as_slice(),
            error => std::slice::from_ref(error),
        };
        let of = |wanted: Option<SitePart>| {
            let errors: Vec<&Error> =
                errors.iter().filter(|error| parts.part_of_error(error) == wanted).collect();
            Error::gathered(&errors).into_iter().map(|message| message.to_string())
        };
        for part in SitePart::ALL {
            self.places[part as usize].errors.extend(of(Some(part)));
        }
        self.folder.errors.extend(of(None));
    }
}

impl State {
    fn searched(&mut self, root: &Path, found: Result<Candidates>, known: Option<(SitePart, PathBuf)>) {
        let Some(assistant) = &mut self.opening.assistant else { return };
        assistant.root_error = found.as_ref().err().map(ToString::to_string);
        found.into_iter().for_each(|candidates| assistant.take(root, candidates));
        if let Some((part, path)) = known {
            assistant.places[part as usize].set(&path);
        }
    }
}

/// Shows the assistant; a folder is searched for a site, a part of a site is filled in.
pub fn start_assistant(state: &mut State, work: &mut Work, path: Option<&Path>) {
    if state.opening.assistant.is_none() {
        state.opening.looking = Looking::default();
    }
    let assistant = state.opening.assistant.get_or_insert_default();
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
    let root = state.opening.assistant.as_ref().map(|assistant| typed_path(&assistant.root));
    root.into_iter().for_each(|root| search_in(state, work, root, None));
}

/// Starts the search of `root`, of which one part may be known.
fn search_in(state: &mut State, work: &mut Work, root: PathBuf, known: Option<(SitePart, PathBuf)>) {
    work.jobs.stop_kind(&mut state.running, JobKind::Search);
    let name = format!("Looking through {}", root.display());
    work.jobs.start(&mut state.running, JobKind::Search, name, move |task| {
        let found = match find_site(&root, task) {
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            found => found,
        };
        Ok(arrival(move |state| state.searched(&root, found, known)))
    });
}

/// Creates the project and opens it; errors are shown beside the paths that they are about.
pub fn create_project(state: &mut State, work: &mut Work) {
    let Some(assistant) = &mut state.opening.assistant else { return };
    let (parts, folder) = (assistant.parts(), assistant.folder.path());
    assistant.places.iter_mut().for_each(|place| place.errors.clear());
    assistant.folder.errors.clear();
    let name = format!("Making {}", folder.display());
    let round = state.opening.round;
    work.jobs.start(&mut state.running, JobKind::Open, name, move |task| {
        let new = NewProject {
            photos: parts.photos.clone(),
            cameras: parts.cameras.clone(),
            model: parts.model.clone(),
            world_from_model: Similarity::IDENTITY,
            options: Options::default(),
        };
        let made = create::create_project(&folder, &new, task)
            .and_then(|opened| Session::new(&folder, opened, task));
        match made {
            Err(Error::Cancelled) => Err(Error::Cancelled),
            made => {
                let made = ProjectAsk::Created(parts, Box::new(made));
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
            state.opening.assistant = None;
            state.opening.check_next = true;
            opened(state, work, session);
        }
        Err(error) => {
            if let Some(assistant) = &mut state.opening.assistant {
                assistant.refuse(parts, &error);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_stand_at_the_part_that_they_speak_of_and_the_rest_at_the_folder() {
        let parts =
            SiteParts { photos: "s/images".into(), cameras: "s/sparse".into(), model: "s/a.obj".into() };
        let errors = Error::Several(vec![
            Error::input("s/a.obj", "line 3", "no faces", "export them"),
            Error::input("s/images/1.jpg", "", "too small", "give the right one"),
            Error::Request("the folder is not empty".into()),
        ]);
        let mut assistant = Assistant::default();
        assistant.refuse(&parts, &errors);
        let counts = assistant.places.each_ref().map(|place| place.errors.len());
        assert_eq!((counts, assistant.folder.errors.len()), ([1, 0, 1], 1));
        assert!(assistant.places[2].errors[0].contains("line 3: no faces; export them"));
    }

    #[test]
    fn many_photos_of_the_wrong_size_are_one_line() {
        let parts =
            SiteParts { photos: "s/images".into(), cameras: "s/sparse".into(), model: "s/a.obj".into() };
        let photo =
            |number| Error::input(format!("s/images/{number}.jpg"), "", "too small", "give the right one");
        let mut assistant = Assistant::default();
        assistant.refuse(&parts, &Error::Several((0..19).map(photo).collect()));
        let [line] = &assistant.places[SitePart::Photos as usize].errors[..] else { panic!() };
        assert!(
            line.starts_with("19 files: too small") && line.contains("0.jpg, 1.jpg and 17 more"),
            "{line}"
        );
    }

    #[test]
    fn a_second_search_keeps_what_it_did_not_find_and_the_folder_that_was_chosen() {
        let mut assistant = Assistant::default();
        assistant.places[2].set(Path::new("mine.obj"));
        assistant.goes_to(Path::new("here"));
        let candidates = Candidates { photos: vec!["a".into(), "b".into()], ..Candidates::default() };
        assistant.take(Path::new("root"), candidates);
        assert_eq!(
            assistant.parts(),
            SiteParts { photos: "a".into(), cameras: "".into(), model: "mine.obj".into() }
        );
        assert_eq!((assistant.folder.typed.as_str(), assistant.places[0].offered.len()), ("here", 2));
    }
}
