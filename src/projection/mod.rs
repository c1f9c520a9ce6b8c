//! Novel views: the edited layers projected back onto the model. What a shot is, which image layers
//! may serve a face, and how photos are weighed; `gpu` draws it.

pub mod cells;
#[cfg(test)]
mod cells_tests;
pub mod confidence;
pub mod exposure;
pub mod flight;
pub mod framing;
pub mod frustum;
pub mod halving;
pub mod least_confidence;
pub mod likeness;
pub mod pyramid;
pub mod relief;
pub mod residency;
pub mod shot;
pub mod sources;
pub mod spans;
pub mod srgb;
pub mod surface;
pub mod tiles;
pub mod twin;
pub mod weights;

pub use exposure::Gains;
pub use shot::{Blend, Exposure, Mode, Picture, Quality, Renders, Shot, Shown};
pub use sources::{
    Domain, HalfPlane, PhotoId, Projector, Server, Sheet, SheetId, SheetPixels, Sources, Texels,
};
