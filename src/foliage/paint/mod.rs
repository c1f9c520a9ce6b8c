//! Paint of a species: what an artist changed in images of slabs of a sub-object ([`frame`]), kept as points of the sub-object
//! ([`PaintedSlab`]), found again at any point of its surfaces ([`PaintField`]), and carried to the parts that it reaches
//! ([`painted`]).

mod change;
mod field;
mod frame;
mod graph;
mod slabs;

#[cfg(test)]
mod tests;

use std::sync::Arc;

use glam::DAffine3;

pub use change::Change;
pub use field::PaintField;
pub use frame::{DIRECTION_NAMES, SlabFrame};
pub use graph::{PaintedPlant, painted};
pub use slabs::{BesidePixel, PaintPoint, PaintedSlab, SlabTally, painted_slabs, slab_pictures};

/// Paint that reaches a sub-object.
#[derive(Debug, Clone, PartialEq)]
pub struct PaintAt {
    /// The paint of the sub-object itself, or of one that uses it, directly or not.
    pub field: Arc<PaintField>,
    /// The map from the frame of the sub-object that it reaches to that of the one that was painted.
    pub field_from_object: DAffine3,
}
