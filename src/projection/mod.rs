//! Novel views, for which the edited layers are projected back onto the model: the description of a view, the
//! image layers that may texture a face, and the weighting of photos. `gpu` draws the views.

pub mod agreement;
pub mod back_to_front;
pub mod backdrops;
pub mod best_view;
pub mod cells;
pub mod continuation;
pub mod dome;
pub mod exploded;
pub mod exposure;
pub mod flight;
pub mod footprint;
pub mod framing;
pub mod frustum;
pub mod hatching;
pub mod hidden;
pub mod legend;
pub mod linear;
pub mod metrics;
pub mod navigation;
mod one_photo;
pub mod peeling;
pub mod reduced;
mod reducer;
pub mod relief;
mod renders;
pub mod shot;
pub mod sides;
pub mod skirts;
mod sliced;
pub mod sources;
pub mod surface;
pub mod surroundings;
mod texels;
pub mod turned;
pub mod twin;
pub mod weights;

pub use exposure::Gains;
pub use linear::LinearPicture;
pub use one_photo::one_photo;
pub use renders::{Renders, SiteContent, SiteRenderer, TREE, shown_face};
pub use shot::{Blend, DisplayMode, Exposure, Mode, Picture, Quality, Shot, TreeMethod, Unseen};
pub use sliced::Sliced;
pub use sources::{
    Domain, HalfPlane, LayerTexture, LayerTextureId, LayerTexturePixels, Projector, Server, Sources, Texels,
};
pub use texels::{confidence, halving, least_confidence, mattes, pyramid, residency, srgb, tiles};
