//! What is selected.

use crate::scene::{FaceId, ObjectId};

/// One thing that inspector, outliner and views speak of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Selection {
    /// Nothing is.
    #[default]
    Nothing,
    /// A photo, by its place in the site.
    Photo(usize),
    /// An object of the model.
    Object(ObjectId),
    /// A face of the model.
    Face(FaceId),
    /// An image layer, by its place in the stack of a photo.
    Layer {
        /// The photo's place in the site.
        photo: usize,
        /// The layer's place in the stack.
        layer: usize,
    },
}

impl Selection {
    /// The photo that it is or belongs to.
    pub fn photo(self) -> Option<usize> {
        match self {
            Self::Photo(photo) | Self::Layer { photo, .. } => Some(photo),
            Self::Nothing | Self::Object(_) | Self::Face(_) => None,
        }
    }
}
