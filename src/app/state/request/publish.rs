//! Requests about the site as a web page.

use std::path::PathBuf;

use crate::state::publish::PublishDialog;

/// Requests about the site as a web page.
pub enum PublishRequest {
    /// Shows the dialog.
    Choose,
    /// Keeps what the page says in the project.
    Keep(Box<PublishDialog>),
    /// Keeps it, and writes the page.
    Publish(Box<PublishDialog>),
    /// Writes the page with small photos into the project's cache.
    Preview(Box<PublishDialog>),
    /// Opens the page in this folder in the user's browser.
    Open(PathBuf),
}
