//! The rows of the lists.

use quadratura_base::scene::{FaceIndex, ObjectId};
use quadratura_document::trees::TreeIndex;
use quadratura_layers::LayerIndex;

/// A row. Object indices refer to the whole model, including excluded objects, so that they are stable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ListRow {
    /// The title of the image layers of the selected photo.
    Layers,
    /// The headings of the table of layers.
    Head,
    /// The title of the layers of one depth, 0 nearest.
    Depth(u32),
    /// An image layer, by its index in the stack.
    Layer(LayerIndex),
    /// The title of the trees.
    Trees,
    /// A species, by its number in the order of names.
    Species(u32),
    /// A tree.
    Tree(TreeIndex),
    /// The title of the model's objects.
    Objects,
    /// An object, by its index in the whole model.
    Object(ObjectId),
    /// A face of an object, by its index within the object.
    Face(ObjectId, FaceIndex),
    /// A remark where there is nothing to list.
    Say(&'static str),
}

impl ListRow {
    /// Returns whether the row is open by default.
    pub fn is_open_at_first(self) -> bool {
        matches!(self, Self::Layers | Self::Depth(_) | Self::Trees | Self::Species(_) | Self::Objects)
    }

    /// Returns whether a row may have rows below it.
    pub fn opens(self) -> bool {
        self.is_open_at_first() || matches!(self, Self::Object(_))
    }

    /// Returns the indentation, in levels.
    pub fn level(self, as_table: bool) -> usize {
        match self {
            Self::Layers | Self::Trees | Self::Objects => 0,
            Self::Head | Self::Depth(_) | Self::Species(_) | Self::Object(_) | Self::Say(_) => 1,
            Self::Layer(_) => {
                if as_table {
                    1
                } else {
                    2
                }
            }
            Self::Face(..) | Self::Tree(_) => 2,
        }
    }

    /// Returns whether the keyboard cursor stops at the row.
    pub fn is_stop(self) -> bool {
        !matches!(self, Self::Head | Self::Say(_))
    }
}
