//! Novel views, for which the edited layers are projected back onto the model: the image layers that may texture a face, exposure,
//! relief, surroundings. `gpu` draws the views.
//!
//! | modules | contents |
//! |---|---|
//! | [`frustum`], [`footprint`], [`framing`], [`backdrops`], [`exploded`], [`hatching`], [`back_to_front`], [`peeling`], [`continuation`], [`reduced`], `reducer` | what knows no layer textures: projections, orders and layers of a view, images at smaller sizes |
//! | [`sources`], `one_photo`, [`sides`], [`turned`], [`agreement`], `texels`, `texture_memory` | photos and their layer textures, which of these may texture which side of a face, and their texels |
//! | [`model_surface`], [`best_view`], [`relief`], [`skirts`] | the surface: rays, heights over coarse faces, strips along outlines |
//! | [`dome`], [`surroundings`], [`cells`] | what is seen where no face is; shortlists of photos |
//! | [`exposure`] | the brightness of photos and views |
//! | `sliced`, `renders` | the interface of renderers |
//! | [`twin`] | the CPU reference of the renderer |
//!
//! A module uses only modules of its own row and of rows above it in this table.

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
pub mod model_surface;
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
