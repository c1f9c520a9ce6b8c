//! Layered depth images: the view of one pinhole camera that keeps, at every pixel, all surfaces along the ray. New views
//! are made by moving its pixels, at a cost that depends on their number alone. [`file`], [`layers`], [`mesh`] and [`page`] are their files.
//!
//! Gortler, He & Cohen, *Rendering Layered Depth Images* (MSR-TR-97-09, 1997), called "the paper" in this module.

pub mod blend;
pub mod combine;
pub mod cracks;
pub mod cube;
pub mod device;
pub mod file;
pub mod finish;
pub mod holes;
pub mod layout;
pub mod lean;
pub mod levels;
pub mod merge;
pub mod mesh;
pub mod occluders;
pub mod order;
pub mod page;
pub mod report;
pub mod segments;
pub mod set;
pub mod show;
pub mod spacing;
pub mod splat;
pub mod stretch;
pub mod synthetic;
#[cfg(test)]
mod tests;
pub mod tiles;
pub mod transfer;
pub mod warp;

pub use blend::{BlendSource, Blended, BlendedSurface, warp_blended};
pub use combine::{Combining, CommonCamera, SourceImage, combine};
pub use layout::{DepthPixel, DepthPixelOrigin, Ldi, LdiKind, LdiSurface, ResolutionLevel, Splat};
pub use report::LdiReport;
pub use set::{Arrangement, LdiSet};
pub use show::{Shown, coloured, warp_shown};
pub use spacing::Spacing;
pub use warp::{DrawingOrder, SplatKind, WarpOptions, Warped, warp, warp_set};
