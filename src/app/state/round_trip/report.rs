//! The results of imports.

use std::sync::Arc;
use std::time::Duration;

use crate::recipe::import::Imported;
use crate::recipe::import::pictures::ChangedLayer;

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
