//! Novel views, for which the edited layers are projected back onto the model: the image layers that may texture a face, exposure,
//! relief, surroundings. `gpu` draws the views.

pub mod agreement;
pub mod back_to_front;
pub mod backdrops;
pub mod best_view;
pub mod cells;
pub mod continuation;
pub mod dome;
pub mod exploded;
pub mod exposure;
pub mod footprint;
pub mod framing;
pub mod frustum;
pub mod hatching;
mod one_photo;
pub mod peeling;
pub mod reduced;
mod reducer;
pub mod relief;
mod renders;
pub mod sides;
pub mod skirts;
mod sliced;
pub mod sources;
pub mod surface;
pub mod surroundings;
mod texels;
mod texture_memory;
pub mod turned;
pub mod twin;

pub use exposure::Gains;
pub use one_photo::one_photo;
pub use renders::{Renders, SiteContent, SiteRenderer, TREE, shown_face};
pub use sliced::Sliced;
pub use sources::{
    Domain, HalfPlane, LayerTexture, LayerTextureId, LayerTexturePixels, Projector, Server, Sources, Texels,
};
pub use texels::{confidence, halving, least_confidence, mattes, pyramid, residency, tiles};
pub use texture_memory::{Storage, TextureOptions};
