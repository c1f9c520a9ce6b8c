//! The part of the selection that concerns one photo.

use crate::state::selection::Selection;
use crate::state::session::Session;
use quadratura_base::scene::{FaceId, FaceIndex, ObjectId, PhotoId};
use quadratura_editing::peel::PeelShape;
use quadratura_layers::LayerIndex;

/// The part of a selection that concerns one photo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Picked<'a> {
    /// Nothing.
    Nothing,
    /// An image layer, by its index in the stack.
    Layer(LayerIndex),
    /// An object, by its name.
    Object(&'a str),
    /// A face, by its object's name and its index.
    Face(&'a str, FaceIndex),
}

impl<'a> Picked<'a> {
    /// Returns the part of a selection that concerns the photo `photo`.
    pub fn new(selection: Selection, session: &'a Session, photo: PhotoId) -> Self {
        let model = session.model();
        let name = |object: ObjectId| model.object(object).name.as_str();
        match selection {
            Selection::Layer { photo: other, layer } if other == photo => Self::Layer(layer),
            Selection::Object(object) => Self::Object(name(object)),
            Selection::Face(face) => Self::Face(name(model.face(face).object), model.face(face).index),
            Selection::Layer { .. } | Selection::Photo(_) | Selection::Tree(_) | Selection::Trees => {
                Self::Nothing
            }
            Selection::Nothing => Self::Nothing,
        }
    }

    /// Returns whether no shape can belong to it.
    pub fn is_nothing(self) -> bool {
        self == Self::Nothing
    }

    /// Returns whether a shape belongs to it.
    pub fn has(self, shape: &PeelShape) -> bool {
        match self {
            Self::Nothing => false,
            Self::Layer(layer) => shape.layer == layer,
            Self::Object(object) => shape.object == object,
            Self::Face(object, face) => shape.object == object && shape.face == Some(face),
        }
    }
}

/// Returns the face of the model that a shape belongs to; `None` for the surroundings.
pub fn face_of(shape: &PeelShape, session: &Session) -> Option<FaceId> {
    session.model().face_named(&shape.object, shape.face?)
}
