//! A test bench for actions: a state with a project, without a window.

use std::path::Path;
use std::sync::Arc;

use tempfile::TempDir;

use crate::action::build::opened;
use crate::action::{apply, check_cancelled, take_in};
use crate::state::State;
use crate::state::request::Request;
use crate::state::session::Session;
use crate::work::Work;
use crate::work::waker::Waker;
use quadratura_base::scene::synthetic::closed_form::stairs;
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_io::project::{read_project, write_project};
use quadratura_io::recovery::read_unsaved;
use quadratura_sites::open::Opened;

/// The photos of the project.
pub const PHOTOS: [&str; 3] = ["a.jpg", "b.jpg", "c.jpg"];

/// A state, its work, and the folder of its project.
pub struct TestBench {
    /// The state under test.
    pub state: State,
    /// The threads of the state.
    pub work: Work,
    folder: TempDir,
}

impl TestBench {
    /// Makes a bench without a project.
    pub fn empty() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut state = State::default();
        // Most tests look at what one action does.
        state.settings.keep_up_to_date = false;
        Self { state, work: Work::new(Waker::default()), folder }
    }

    /// Makes a bench with an open project of three photos of some stairs, none of which is built.
    pub fn new() -> Self {
        let mut bench = Self::empty();
        let project = project();
        write_project(bench.folder(), &project).unwrap();
        let session = Session::new(bench.folder(), site_of(project), &Task::silent()).unwrap();
        opened(&mut bench.state, &mut bench.work, session);
        bench.settle();
        bench
    }

    /// Returns the project's folder.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Applies a request.
    pub fn request(&mut self, request: impl Into<Request>) {
        apply(&mut self.state, &mut self.work, request.into());
    }

    /// Advances the clock by `seconds` and runs what is due.
    pub fn pass(&mut self, seconds: f64) {
        self.state.window.now_s += seconds;
        check_cancelled(&mut self.state, &mut self.work);
    }

    /// Waits until no job runs, and applies the results.
    pub fn settle(&mut self) {
        while !self.state.running.is_idle() {
            take_in(&mut self.state, &mut self.work);
            std::thread::yield_now();
        }
    }

    /// Returns the open project with all decisions so far.
    pub fn project(&self) -> Project {
        Project::clone(self.session().history.present())
    }

    /// Returns the project as it is saved in its file.
    pub fn saved(&self) -> Project {
        read_project(self.folder()).unwrap()
    }

    /// Returns the project that the autosave has stored.
    pub fn kept(&self) -> Option<Project> {
        read_unsaved(self.folder(), &self.saved()).unwrap().map(|found| found.project)
    }

    /// Returns the session of the open project.
    pub fn session(&self) -> &Session {
        self.state.session.as_ref().expect("a project is open")
    }

    /// Returns the texts of all notes.
    pub fn said(&self) -> Vec<String> {
        self.state.notes.list().iter().map(|note| note.text.to_string()).collect()
    }

    /// Returns the name of the step that `Undo` would undo.
    pub fn undoes(&self) -> Option<&str> {
        self.session().history.undoes()
    }
}

/// Returns a new project.
pub fn project() -> Project {
    let text = r#"{"version": 1, "photos": "p", "cameras": "c", "model": "m.obj"}"#;
    serde_json::from_str(text).unwrap()
}

fn site_of(project: Project) -> Opened {
    let scene = stairs();
    let mut site = scene.site();
    let photo = site.photos.remove(0);
    site.photos = PHOTOS
        .iter()
        .map(|name| quadratura_base::scene::Photo { name: (*name).into(), ..photo.clone() })
        .collect();
    Opened {
        project,
        site,
        whole: scene.model.clone(),
        points: Arc::default(),
        reprojection: None,
        problems: Arc::default(),
    }
}
