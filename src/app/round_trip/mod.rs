//! The round trip to the image editor: exports, imports, and their changes.

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
use crate::app::round_trip::choosing::take_chosen_files;
use crate::app::round_trip::importing::import_files;
use crate::app::round_trip::importing::read_history;
use crate::app::round_trip::watching::take_saved;
use crate::app::round_trip::watching::watch_for_saves;
use crate::app::state::State;
use crate::app::work::Work;
use crate::document::paint::PaintImport;
use crate::io::documents::is_document;
use crate::io::programs::ImageEditor;
use crate::recipe::editing::folder as folder_of_documents;

/// The state of exports and imports.
#[derive(Default)]
pub struct RoundTrip {
    /// The last import.
    pub report: Option<Report>,
    /// The imports that can be undone, oldest first.
    pub history: Vec<PaintImport>,
    /// The photos that have paint.
    pub painted: BTreeSet<String>,
    /// The open import dialog.
    pub import: Option<ImportDialog>,
    /// The open export dialog.
    pub export: Option<ExportDialog>,
    /// Whether the dialog for the image editor is open.
    pub choosing_editor: bool,
    /// The installed image editors, once they were looked up.
    pub found: Option<Vec<(ImageEditor, PathBuf)>>,
}

/// A lock for writing the project's paint: one writer at a time.
#[derive(Debug, Clone, Default)]
pub struct PaintLock(Arc<Mutex<()>>);

impl PaintLock {
    /// Waits for the lock.
    pub fn take(&self) -> MutexGuard<'_, ()> {
        // A panic leaves the project's paint complete: it changes by one rename.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl RoundTrip {
    /// Returns whether a dialog is open.
    pub fn asks(&self) -> bool {
        self.import.is_some() || self.export.is_some() || self.choosing_editor
    }
}

impl State {
    /// Returns the folder of documents that are being edited, where there is one.
    pub fn editing_folder(&self) -> Option<PathBuf> {
        let folder = folder_of_documents(&self.session.as_ref()?.folder);
        folder.is_dir().then_some(folder)
    }
}

/// Handles files saved in image editors, and answers of system dialogs.
pub fn take_home(state: &mut State, work: &mut Work) {
    take_saved(state, work);
    take_chosen_files(state, work);
}

/// Resets the state, because another project or none is open.
pub fn leave_round_trip(state: &mut State, work: &mut Work) {
    let found = state.round_trip.found.take();
    state.round_trip = RoundTrip { found, ..RoundTrip::default() };
    (work.choosing, work.watching, work.turn) = (None, None, PaintLock::default());
}

/// Starts the watch after a project was opened: documents saved in the meantime are imported.
pub fn begin_round_trip(state: &mut State, work: &mut Work) {
    leave_round_trip(state, work);
    watch_for_saves(state, work);
    read_history(state, work);
}

/// Imports layered files dropped on the window; returns whether there were any.
pub fn import_dropped(state: &mut State, work: &mut Work, dropped: &[PathBuf]) -> bool {
    let layered: Vec<PathBuf> = dropped.iter().filter(|path| is_document(path)).cloned().collect();
    if state.session.is_none() || layered.is_empty() {
        return false;
    }
    import_files(state, work, layered);
    true
}

/// Formats a path for display: relative to the project where the file is inside it.
pub fn shown_path(project: &Path, file: &Path) -> String {
    file.strip_prefix(project).unwrap_or(file).display().to_string()
}
