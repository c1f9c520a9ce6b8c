//! The selection.

use quadratura_base::scene::{FaceId, ObjectId, PhotoId};
use quadratura_document::trees::TreeIndex;
use quadratura_layers::LayerIndex;

/// The thing that inspector, outliner and views show as selected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Selection {
    /// Nothing.
    #[default]
    Nothing,
    /// A photo, by its index in the site.
    Photo(PhotoId),
    /// An object of the model.
    Object(ObjectId),
    /// A face of the model.
    Face(FaceId),
    /// An image layer, by its index in the stack of a photo.
    Layer {
        /// The photo's index in the site.
        photo: PhotoId,
        /// The layer's index in the stack.
        layer: LayerIndex,
    },
    /// A tree of the project.
    Tree(TreeIndex),
    /// All trees, and the light on them.
    Trees,
}

impl Selection {
    /// Returns the photo that is selected or that the selected layer belongs to.
    pub fn photo(self) -> Option<PhotoId> {
        match self {
            Self::Photo(photo) | Self::Layer { photo, .. } => Some(photo),
            Self::Nothing | Self::Object(_) | Self::Face(_) | Self::Tree(_) | Self::Trees => None,
        }
    }
}
