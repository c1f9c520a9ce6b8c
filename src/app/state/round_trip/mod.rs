//! The round trip to the image editor: its dialogs, the last import, and the imports that can be undone.

pub mod choosing;
pub mod dialogs;
pub mod editing;
pub mod image_editor;
pub mod report;
pub mod reporting;
mod stroked;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use self::dialogs::RoundTripDialogs;
use self::report::{ImportQuestion, Report};
use quadratura_base::scene::PhotoId;
use quadratura_document::paint::{PaintBook, PaintImport};
use quadratura_io::programs::ImageEditor;
use quadratura_stacks::projected_paint::ProjectedPaint;

/// The state of exports and imports.
#[derive(Default)]
pub struct RoundTrip {
    /// The last import.
    pub report: Option<Report>,
    /// The questions about files that are not imported yet.
    pub questions: Vec<ImportQuestion>,
    /// The imports that can be undone, oldest first.
    pub history: Vec<PaintImport>,
    /// The photos that have paint.
    pub painted: BTreeSet<String>,
    /// The open dialogs.
    pub dialogs: RoundTripDialogs,
    /// The installed image editors, once they were looked up.
    pub found: Option<Vec<(ImageEditor, PathBuf)>>,
    /// Whether the messages were opened to say that what is saved in the image editor is imported.
    pub opened_messages: bool,
    /// The number of the last change of paint that was projected to other photos.
    pub projection: u64,
    /// Whether the files of other photos may lack paint that is shown on them.
    pub is_behind: bool,
    /// The project's paint after its last change.
    pub book: Option<Arc<PaintBook>>,
}

/// Paint that was projected to photos whose files do not contain it yet.
pub struct Projected {
    /// The number of the change of paint.
    pub number: u64,
    /// The photos.
    pub photos: Vec<PhotoId>,
    /// The paint on them.
    pub paint: Vec<ProjectedPaint>,
    /// The photos that come next.
    pub later: Vec<PhotoId>,
    /// The project's paint.
    pub book: Arc<PaintBook>,
}

impl RoundTrip {
    /// Returns whether a dialog is open.
    pub fn is_asking(&self) -> bool {
        self.dialogs.is_open()
    }

    /// Resets the state, because another project or none is open; installed programs stay known.
    pub fn forget(&mut self) {
        // A projection that is still running belongs to the other project.
        let (found, projection) = (self.found.take(), self.projection + 1);
        *self = Self { found, projection, ..Self::default() };
    }
}

/// Formats a path for display: relative to the project where the file is inside it.
pub fn shown_path(project: &Path, file: &Path) -> String {
    file.strip_prefix(project).unwrap_or(file).display().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::State;

    #[test]
    fn another_project_forgets_imports_and_dialogs_but_not_which_programs_are_installed() {
        let mut state = State::default();
        state.choose_export();
        state.round_trip.painted.insert("a.jpg".into());
        state.round_trip.found = Some(vec![(ImageEditor::Krita, "krita".into())]);
        assert!(state.round_trip.is_asking());
        state.round_trip.forget();
        assert!(!state.round_trip.is_asking() && state.round_trip.painted.is_empty());
        assert_eq!(state.round_trip.found.map(|found| found.len()), Some(1));
    }

    #[test]
    fn a_file_of_the_project_is_shown_from_its_folder_on_and_another_one_as_a_whole() {
        let project = Path::new("house");
        assert_eq!(shown_path(project, &project.join("edited").join("a.psd")), "edited/a.psd");
        assert_eq!(shown_path(project, Path::new("elsewhere/a.psd")), "elsewhere/a.psd");
    }
}
