//! From a sheet's pixels to what lies on the device. In reading order: `geometry::spans` says which pixels there
//! are, `confidence` how far each can be trusted, `pyramid` makes every level of detail by `halving` in the linear
//! light of `srgb`, `tiles` cuts them, `residency` keeps the book of who has room; `least_confidence` is what
//! is known afterwards without looking at texels.

pub mod confidence;
pub mod halving;
pub mod least_confidence;
pub mod pyramid;
pub mod residency;

pub mod srgb;
pub mod tiles;
