//! What every other package stands on: errors with their causes and remedies, progress and cancellation, mathematics, pixels
//! on a grid, and the photographed scene. No files, no GPU.
//!
//! | module | contents |
//! |---|---|
//! | [`error`] | errors with their causes and remedies |
//! | [`task`] | progress and cancellation |
//! | [`geometry`] | cameras, lenses, planes, polygons, rectangles: pure mathematics |
//! | [`raster`] | pixels on a grid: image, sampling, halving, compositing, robust statistics |
//! | [`scene`] | photos, model and site: the photographed scene, immutable |
//!
//! Each module uses only modules above it in this table.

pub mod error;
pub mod geometry;
pub mod raster;
pub mod scene;
pub mod task;

pub use error::{Error, Result};
