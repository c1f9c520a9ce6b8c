//! The documents in the window, and what the program says about itself.

/// The state of the documents and of *About*.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Guide {
    /// Whether the documents are shown.
    pub documents_shown: bool,
    /// The document that is shown, by its index in the list.
    pub document: usize,
    /// Whether the program's name and version are shown.
    pub about_shown: bool,
}
