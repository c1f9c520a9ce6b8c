//! The round trip to the image editor: its dialogs, the last import, and the imports that can be undone.

pub mod dialogs;
pub mod image_editor;
pub mod report;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use self::dialogs::RoundTripDialogs;
use self::report::Report;
use super::State;
use crate::document::paint::PaintImport;
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
    /// The open dialogs.
    pub dialogs: RoundTripDialogs,
    /// The installed image editors, once they were looked up.
    pub found: Option<Vec<(ImageEditor, PathBuf)>>,
}

impl RoundTrip {
    /// Returns whether a dialog is open.
    pub fn asks(&self) -> bool {
        self.dialogs.is_open()
    }

    /// Resets the state, because another project or none is open; installed programs stay known.
    pub fn forget(&mut self) {
        *self = Self { found: self.found.take(), ..Self::default() };
    }
}

impl State {
    /// Returns the folder of documents that are being edited, where there is one.
    pub fn editing_folder(&self) -> Option<PathBuf> {
        let folder = folder_of_documents(&self.session.as_ref()?.folder);
        folder.is_dir().then_some(folder)
    }
}

/// Formats a path for display: relative to the project where the file is inside it.
pub fn shown_path(project: &Path, file: &Path) -> String {
    file.strip_prefix(project).unwrap_or(file).display().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_project_forgets_imports_and_dialogs_but_not_which_programs_are_installed() {
        let mut state = State::default();
        state.choose_export();
        state.round_trip.painted.insert("a.jpg".into());
        state.round_trip.found = Some(vec![(ImageEditor::Krita, "krita".into())]);
        assert!(state.round_trip.asks());
        state.round_trip.forget();
        assert!(!state.round_trip.asks() && state.round_trip.painted.is_empty());
        assert_eq!(state.round_trip.found.map(|found| found.len()), Some(1));
    }

    #[test]
    fn a_file_of_the_project_is_shown_from_its_folder_on_and_another_one_as_a_whole() {
        let project = Path::new("house");
        assert_eq!(shown_path(project, &project.join("edited").join("a.psd")), "edited/a.psd");
        assert_eq!(shown_path(project, Path::new("elsewhere/a.psd")), "elsewhere/a.psd");
    }
}
