//! The preparation of a layer texture's pixels for texture memory. In reading order: `geometry::spans` lists the
//! pixels that exist, `confidence` weights each, `pyramid` makes every level of detail by `halving` in the
//! linear light of `view::srgb`, `tiles` cuts them, `residency` manages the slots; `least_confidence` is the
//! summary that answers queries without texels, and `mattes` numbers the textures of mattes.

pub mod confidence;
pub mod halving;
pub mod least_confidence;
pub mod mattes;
pub mod pyramid;
pub mod residency;
pub mod tiles;
