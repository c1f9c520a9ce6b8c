//! Edits of layer options.

use quadratura_document::decisions::PhotoOptions;
use quadratura_layers::Options;

/// An edit of layer options.
pub enum OptionsEdit {
    /// Sets the project's options, which apply to photos without their own.
    Project(Options),
    /// Sets the options of one photo, by name.
    Photo(String, PhotoOptions),
}
