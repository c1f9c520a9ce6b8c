//! The round trip to the image editor: exports to paint on, what comes back, and what it changed.

pub mod choosing;
pub mod editing;
pub mod exporting;
pub mod importing;
pub mod watching;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use self::exporting::ExportDialog;
use self::importing::{ImportDialog, Report};
use crate::app::state::State;
use crate::app::trip::choosing::take_chosen_files;
use crate::app::trip::importing::import_files;
use crate::app::trip::importing::read_history;
use crate::app::trip::watching::take_saved;
use crate::app::trip::watching::watch_for_saves;
use crate::app::work::Work;
use crate::document::paint::PaintImport;
use crate::io::documents::is_document;
use crate::io::programs::ImageEditor;
use crate::recipe::editing::folder as folder_of_documents;

/// What is under way between the project and image editors.
#[derive(Default)]
pub struct Trip {
    /// The last import.
    pub report: Option<Report>,
    /// Imports that can be taken back, oldest first.
    pub history: Vec<PaintImport>,
    /// Photos that have paint.
    pub painted: BTreeSet<String>,
    /// What is to be imported is being chosen.
    pub import: Option<ImportDialog>,
    /// How to export is being chosen.
    pub export: Option<ExportDialog>,
    /// Which image editor to use is being chosen.
    pub choosing_editor: bool,
    /// Image editors that are installed; looked for when somebody asks.
    pub found: Option<Vec<(ImageEditor, PathBuf)>>,
}

/// Who writes the project's paint: one at a time.
#[derive(Debug, Clone, Default)]
pub struct Turn(Arc<Mutex<()>>);

impl Turn {
    /// Waits until nobody else does.
    pub fn take(&self) -> MutexGuard<'_, ()> {
        // Whoever panicked has left the project's paint whole: it changes by one rename.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Trip {
    /// A dialog waits for an answer.
    pub fn asks(&self) -> bool {
        self.import.is_some() || self.export.is_some() || self.choosing_editor
    }
}

impl State {
    /// The folder of documents that are painted on, where there is one.
    pub fn editing_folder(&self) -> Option<PathBuf> {
        let folder = folder_of_documents(&self.session.as_ref()?.folder);
        folder.is_dir().then_some(folder)
    }
}

/// Takes in what was saved in image editors, and what was chosen in dialogs of the system.
pub fn take_home(state: &mut State, work: &mut Work) {
    take_saved(state, work);
    take_chosen_files(state, work);
}

/// Another project is open, or none.
pub fn leave_trip(state: &mut State, work: &mut Work) {
    let found = state.trip.found.take();
    state.trip = Trip { found, ..Trip::default() };
    (work.choosing, work.watching, work.turn) = (None, None, Turn::default());
}

/// A project was opened: what was painted on while it was not comes home.
pub fn begin_trip(state: &mut State, work: &mut Work) {
    leave_trip(state, work);
    watch_for_saves(state, work);
    read_history(state, work);
}

/// Layered files that were dropped on the window are imported; whether there were any.
pub fn import_dropped(state: &mut State, work: &mut Work, dropped: &[PathBuf]) -> bool {
    let layered: Vec<PathBuf> = dropped.iter().filter(|path| is_document(path)).cloned().collect();
    if state.session.is_none() || layered.is_empty() {
        return false;
    }
    import_files(state, work, layered);
    true
}

/// A file as people read it: from the project on, where it lies in that.
pub fn shown_path(project: &Path, file: &Path) -> String {
    file.strip_prefix(project).unwrap_or(file).display().to_string()
}
