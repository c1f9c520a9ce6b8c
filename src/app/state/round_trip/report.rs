//! The results of imports.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use quadratura_editing::import::Imported;
use quadratura_editing::import::pictures::ChangedLayer;
use quadratura_view::Picture;

/// The origin of an import.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// A file was saved in an image editor.
    Saved,
    /// The user started the import, or redid one that was undone.
    ByHand {
        /// The number of the import that was undone.
        again: Option<u32>,
    },
}

/// A question about a file of which nothing was imported, because so much has changed at once.
pub struct ImportQuestion {
    /// The file.
    pub file: PathBuf,
    /// What was found, in a sentence.
    pub found: String,
    /// Its image layers as they were exported, and as they are in the file, once they are made.
    pub pictures: Option<Arc<[Picture; 2]>>,
}

/// The report of an import.
pub struct Report {
    /// The result for each file and layer.
    pub imported: Imported,
    /// The duration.
    pub spent: Duration,
    /// The changed layers with their pictures before and after, once they are made.
    pub looks: Arc<Vec<ChangedLayer>>,
    /// Whether the import was undone.
    pub taken_back: bool,
}
