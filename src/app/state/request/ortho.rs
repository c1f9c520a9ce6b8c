//! Requests about orthophotos.

use crate::state::orthophoto::OrthophotoDialog;

/// Requests about orthophotos.
pub enum OrthoRequest {
    /// Shows the dialog for what is selected.
    Choose,
    /// Draws a preview with the options of the dialog.
    Preview(Box<OrthophotoDialog>),
    /// Draws the orthophoto with the options of the dialog.
    Draw(Box<OrthophotoDialog>),
}
