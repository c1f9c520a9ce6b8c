//! Requests about layered depth images to save.

use crate::state::save_image::{ImageFormat, SaveImage};

/// Requests about layered depth images to save.
pub enum ImagesRequest {
    /// Shows the dialog for the selected photo.
    Choose(ImageFormat),
    /// Saves with the options of the dialog.
    Save(SaveImage),
}
