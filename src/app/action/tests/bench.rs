//! A state with a project and without a window, for the tests of actions.

use std::path::Path;
use std::sync::Arc;

use tempfile::TempDir;

use crate::app::action::build::opened;
use crate::app::action::{apply, go_on, take_in};
use crate::app::state::State;
use crate::app::state::ask::Ask;
use crate::app::state::session::Session;
use crate::app::work::Work;
use crate::app::work::waker::Waker;
use crate::document::Project;
use crate::io::project::{read_project, write_project};
use crate::io::recovery::read_unsaved;
use crate::recipe::open::Opened;
use crate::scene::synthetic::closed_form::stairs;
use crate::task::Task;

/// Photos of the project.
pub const PHOTOS: [&str; 3] = ["a.jpg", "b.jpg", "c.jpg"];

/// The state, what runs beside it, and the folder of its project.
pub struct Bench {
    pub state: State,
    pub work: Work,
    folder: TempDir,
}

impl Bench {
    /// No project is open.
    pub fn empty() -> Self {
        let folder = tempfile::tempdir().unwrap();
        Self { state: State::default(), work: Work::new(Waker::default()), folder }
    }

    /// A project of three photos of some stairs is open, none of which is built.
    pub fn new() -> Self {
        let mut bench = Self::empty();
        let project = project();
        write_project(bench.folder(), &project).unwrap();
        let session = Session::of(bench.folder(), site_of(project), &Task::silent()).unwrap();
        opened(&mut bench.state, &mut bench.work, session);
        bench.settle();
        bench
    }

    /// The project's folder.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Does what is asked.
    pub fn ask(&mut self, ask: impl Into<Ask>) {
        apply(&mut self.state, &mut self.work, ask.into());
    }

    /// So much time passes, in seconds, and what goes on by itself goes on.
    pub fn pass(&mut self, seconds: f64) {
        self.state.window.now_s += seconds;
        go_on(&mut self.state, &mut self.work);
    }

    /// Waits until no job runs, and takes in what they brought.
    pub fn settle(&mut self) {
        while !self.state.running.is_idle() {
            take_in(&mut self.state, &mut self.work);
            std::thread::yield_now();
        }
    }

    /// The open project as it is decided now.
    pub fn project(&self) -> Project {
        Project::clone(self.session().history.present())
    }

    /// The project as its file has it.
    pub fn saved(&self) -> Project {
        read_project(self.folder()).unwrap()
    }

    /// What the autosave has kept.
    pub fn kept(&self) -> Option<Project> {
        read_unsaved(self.folder(), &self.saved()).unwrap().map(|found| found.project)
    }

    /// The open project.
    pub fn session(&self) -> &Session {
        self.state.session.as_ref().expect("a project is open")
    }

    /// The texts of all notes.
    pub fn said(&self) -> Vec<&str> {
        self.state.notes.list().iter().map(|note| note.text.as_str()).collect()
    }

    /// What `Undo` would take back.
    pub fn undoes(&self) -> Option<&str> {
        self.session().history.undoes()
    }
}

/// The project as it is when it is new.
pub fn project() -> Project {
    let text = r#"{"version": 1, "photos": "p", "cameras": "c", "model": "m.obj"}"#;
    serde_json::from_str(text).unwrap()
}

fn site_of(project: Project) -> Opened {
    let scene = stairs();
    let mut site = scene.site();
    let photo = site.photos.remove(0);
    site.photos =
        PHOTOS.iter().map(|name| crate::scene::Photo { name: (*name).into(), ..photo.clone() }).collect();
    Opened {
        project,
        site,
        whole: scene.model.clone(),
        points: Arc::default(),
        problems: Arc::default(),
        left_out: Vec::new(),
        unmasked: Arc::default(),
    }
}
