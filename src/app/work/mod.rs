//! What runs beside the window: jobs, the painter of the 3D view, the autosave, dialogs of the system, threads that
//! watch files. Whatever arrives is a closure on the state.

pub mod jobs;
pub mod keeper;
pub mod painter;
pub mod waker;

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use self::jobs::Jobs;
use self::keeper::{Ending, Keeper};
use self::painter::Painter;
use self::waker::Waker;
use super::opening::chooser::Chooser;
use super::opening::on_disk::OnDisk;
use super::pictures::Pictures;
use super::state::State;
use super::trip::Turn;
use super::trip::choosing::Choosing;
use super::trip::watching::Watching;
use crate::scene::Model;

/// The threads of the window and what belongs to them.
pub struct Work {
    /// Wakes the window.
    pub waker: Waker,
    /// The threads of jobs.
    pub jobs: Jobs,
    /// Draws the 3D view; none while that is being prepared, or where there is no adapter.
    pub painter: Option<Painter>,
    /// Where the job that makes a painter leaves it.
    pub made: Made,
    /// Keeps what is not saved of the open project.
    pub keeper: Option<Arc<Keeper>>,
    /// Ends the window from outside.
    pub ending: Ending,
    /// Pictures of photos.
    pub pictures: Pictures,
    /// The dialog of the system for files and folders of projects.
    pub chooser: Chooser,
    /// The dialog of the system for layered files and programs.
    pub choosing: Option<Choosing>,
    /// Looks for changes to what the site was read from.
    pub on_disk: Option<OnDisk>,
    /// Imports what is saved in the image editor.
    pub watching: Option<Watching>,
    /// Imports are made one after the other.
    pub turn: Turn,
}

/// A painter, and what it draws.
pub struct MadePainter {
    /// The painter.
    pub painter: Painter,
    /// The project's folder.
    pub folder: PathBuf,
    /// The model.
    pub model: Arc<Model>,
}

/// Where a painter waits for the window between the job that made it and the state that uses it.
#[derive(Clone, Default)]
pub struct Made(Arc<Mutex<Option<MadePainter>>>);

impl Made {
    /// Leaves it here; one that nobody took is dropped.
    pub fn put(&self, painter: MadePainter) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(painter);
    }

    /// Takes it.
    pub fn take(&self) -> Option<MadePainter> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

impl Work {
    /// Nothing runs yet.
    pub fn new(waker: Waker) -> Self {
        Self {
            jobs: Jobs::new(waker.clone()),
            waker,
            painter: None,
            made: Made::default(),
            keeper: None,
            ending: Ending::default(),
            pictures: Pictures::default(),
            chooser: Chooser::default(),
            choosing: None,
            on_disk: None,
            watching: None,
            turn: Turn::default(),
        }
    }

    /// Whoever draws the 3D view ends.
    pub fn drop_painter(&mut self, state: &mut State) {
        (self.painter, state.device) = (None, None);
    }
}
