//! Novel views, for which the edited layers are projected back onto the model: the description of a view, the
//! image layers that may texture a face, and the weighting of photos. `gpu` draws the views.

pub mod cells;
pub mod exploded;
pub mod exposure;
pub mod flight;
pub mod footprint;
pub mod framing;
pub mod frustum;
pub mod hatching;
pub mod legend;
pub mod likeness;
pub mod navigation;
pub mod reduced;
pub mod relief;
pub mod shot;
pub mod sides;
pub mod sources;
pub mod surface;
mod texels;
pub mod twin;
pub mod weights;

pub use exposure::Gains;
pub use shot::{Blend, Exposure, Mode, Picture, Quality, Renders, Shot, Shown};
pub use sources::{
    Domain, HalfPlane, PhotoId, Projector, Server, Sheet, SheetId, SheetPixels, Sources, Texels,
};
pub use texels::{confidence, halving, least_confidence, pyramid, residency, srgb, tiles};
