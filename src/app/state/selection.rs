//! The selection.

use super::facts::Inspect;
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

/// What is selected: the thing that inspector and views show, and what belongs to it.
#[derive(Default)]
pub struct SelectionState {
    /// The main selection.
    pub main: Selection,
    /// The photo that was selected last, to which commands on a photo apply.
    pub photo: Option<PhotoId>,
    /// The image layers selected beside `main`: photo, and index in its stack.
    pub more_layers: Vec<(PhotoId, LayerIndex)>,
    /// Cached facts about the selected face or object.
    pub facts: Inspect,
}

impl SelectionState {
    /// Returns whether this is selected, alone or with others.
    pub fn includes(&self, this: Selection) -> bool {
        self.main == this
            || matches!(this, Selection::Layer { photo, layer } if self.more_layers.contains(&(photo, layer)))
    }

    /// Returns the photo whose image layers are selected and their indices in its stack, in order: the selected layer and
    /// those that were added to it.
    pub fn layers(&self) -> (PhotoId, Vec<LayerIndex>) {
        let Selection::Layer { photo, layer } = self.main else { return Default::default() };
        let more = self.more_layers.iter().filter(|(other, _)| *other == photo).map(|(_, layer)| *layer);
        let mut layers: Vec<LayerIndex> = more.chain([layer]).collect();
        layers.sort_unstable();
        layers.dedup();
        (photo, layers)
    }
}
