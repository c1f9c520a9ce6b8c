//! The threads beside the window: jobs, the painter of the 3D view, the autosave, system dialogs, file watchers.
//! Results arrive as closures on the state.

pub mod autosave;
pub mod chooser;
pub mod choosing;
pub mod crash;
pub mod jobs;
pub mod known;
pub mod live_project;
pub mod on_disk;

pub mod pages;
pub mod painter;
pub mod pictures;
pub mod priority;
pub mod waker;
pub mod watching;
pub mod write_lock;

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use self::autosave::{AutosaveWriter, Ending};
use self::chooser::Chooser;
use self::choosing::Choosing;
use self::jobs::Jobs;
use self::known::KnownFile;
use self::live_project::LiveProject;
use self::on_disk::OnDisk;
use self::painter::Painter;
use self::pictures::PhotoPictures;
use self::waker::Waker;
use self::watching::Watching;
use super::state::space::SpaceView;
use quadratura_base::scene::Model;
use quadratura_document::Stack;
use quadratura_document::paint::PaintBook;

/// The threads of the window, with their handles.
pub struct Work {
    /// The waker of the window.
    pub waker: Waker,
    /// The threads of jobs.
    pub jobs: Jobs,
    /// The painter of the 3D view; none while it is being made, or where there is no adapter.
    pub painter: Option<Painter>,
    /// The slot in which a job leaves a painter that was made.
    pub made: PainterSlot,
    /// The autosave of the open project.
    pub autosave: Option<Arc<AutosaveWriter>>,
    /// What all windows know about projects.
    pub known: KnownFile,
    /// The folder of the documents' pages, where the system names one for files of the program.
    pub pages: Option<PathBuf>,
    /// The handle that ends the window from outside.
    pub ending: Ending,
    /// The pictures of photos.
    pub pictures: PhotoPictures,
    /// The system dialog for files and folders of projects.
    pub chooser: Chooser,
    /// The system dialog for layered files and programs.
    pub choosing: Option<Choosing>,
    /// The watch on the files of the site.
    pub on_disk: Option<OnDisk>,
    /// The watch that imports documents saved in the image editor.
    pub watching: Option<Watching>,
    /// The open project as updates in the background see it, with the locks for writing paint and stacks.
    pub live: LiveProject,
}

/// A painter that was made, and the project that it draws.
pub struct MadePainter {
    /// The painter.
    pub painter: Painter,
    /// The project's folder.
    pub folder: PathBuf,
    /// The model.
    pub model: Arc<Model>,
    /// The project's paint when it began to be made, where that had changed since the project was opened.
    pub book: Option<Arc<PaintBook>>,
    /// The stacks that it shows, in the site's order.
    pub stacks: Vec<Option<Arc<Stack>>>,
}

/// A slot for a painter, between the job that makes it and the state that uses it.
#[derive(Clone, Default)]
pub struct PainterSlot(Arc<Mutex<Option<MadePainter>>>);

impl PainterSlot {
    /// Stores a painter; one that was not taken is dropped.
    pub fn put(&self, painter: MadePainter) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(painter);
    }

    /// Takes the painter.
    pub fn take(&self) -> Option<MadePainter> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

impl Work {
    /// Makes a work without running threads.
    pub fn new(waker: Waker) -> Self {
        Self {
            jobs: Jobs::new(waker.clone()),
            waker,
            painter: None,
            made: PainterSlot::default(),
            autosave: None,
            known: KnownFile::default(),
            pages: None,
            ending: Ending::default(),
            pictures: PhotoPictures::default(),
            chooser: Chooser::default(),
            choosing: None,
            on_disk: None,
            watching: None,
            live: LiveProject::default(),
        }
    }

    /// Stops the painter of the 3D view.
    pub fn drop_painter(&mut self, space: &mut SpaceView) {
        (self.painter, space.device) = (None, None);
    }
}
