//! The round trip to the image editor: exports to paint on, what comes back, and what it changed.

pub mod choosing;
pub mod editing;
pub mod exporting;
pub mod importing;
mod watching;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use self::choosing::Choosing;
use self::exporting::ExportDialog;
use self::importing::{ImportDialog, Report};
use self::watching::Watching;
use super::editor::Editor;
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
    /// What is chosen in a dialog of the system.
    choosing: Option<Choosing>,
    watching: Option<Watching>,
    turn: Turn,
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

impl Editor {
    /// Takes in what was saved in image editors, and what was chosen in dialogs of the system.
    pub(super) fn take_home(&mut self) {
        self.take_saved();
        self.take_chosen_files();
    }

    /// Another project is open, or none.
    pub(super) fn leave_trip(&mut self) {
        let found = self.trip.found.take();
        self.trip = Trip { found, ..Trip::default() };
    }

    /// A project was opened: what was painted on while it was not comes home.
    pub(super) fn begin_trip(&mut self) {
        self.leave_trip();
        self.watch_for_saves();
        self.read_history();
    }

    /// The folder of documents that are painted on, where there is one.
    pub fn editing_folder(&self) -> Option<PathBuf> {
        let folder = folder_of_documents(&self.session.as_ref()?.folder);
        folder.is_dir().then_some(folder)
    }

    /// Layered files that were dropped on the window are imported; whether there were any.
    pub(super) fn import_dropped(&mut self, dropped: &[PathBuf]) -> bool {
        let layered: Vec<PathBuf> = dropped.iter().filter(|path| is_document(path)).cloned().collect();
        if self.session.is_none() || layered.is_empty() {
            return false;
        }
        self.import_files(layered);
        true
    }
}

/// A file as people read it: from the project on, where it lies in that.
pub fn shown_path(project: &Path, file: &Path) -> String {
    file.strip_prefix(project).unwrap_or(file).display().to_string()
}
