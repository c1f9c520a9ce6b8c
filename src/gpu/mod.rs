//! The GPU passes, one file each, and their shaders of the same name in `shaders/`.
//!
//! | pass | result |
//! |---|---|
//! | *nearest* | inverse depth of the nearest fragment, per pixel |
//! | *presence* | the working set; where the other items are hidden |
//! | *count*, *scan*, *fill* | every fragment of the working set, per pixel |
//! | *pairs* | the table of occlusions |
//! | *mark* | the items behind the nearest fragments: one round of exact peeling |
//! | *farthest*, *stencil* | the items that are partly hidden: one round of the published peeling |
//!
//! [`GpuRasteriser`] holds the pipelines and runs the passes in this order. Photos are drawn in bands of
//! whole rows, so that textures and buffers stay within the limits of the adapter.
//!
//! | modules | contents |
//! |---|---|
//! | `device`, `bindings`, `readback` | the device, what is bound on it, and what is read back |
//! | `blocks`, `pyramids`, `texture_statistics`, `tile_atlas`, `tile_store` | texture memory |
//! | `frame`, `drawing`, `scan`, `workspace` | what passes of the visibility sort share: a band's rows, triangles and buffers |
//! | `nearest`, `presence`, `count`, `fill`, `pairs`, `farthest` | its passes |
//! | `run`, `rasteriser`, `lists`, `mark`, `stencil` | the order in which they run, and peeling, which runs them again |
//! | `renderer` | novel views |
//! | `ldi` | novel views from layered depth images |
//!
//! A module uses only modules of its own row and of rows above it in this table.

mod bindings;
mod blocks;
mod count;
mod device;
mod drawing;
mod farthest;
mod fill;
mod frame;
mod ldi;
mod lists;
mod mark;
mod nearest;
mod pairs;
mod presence;
mod pyramids;
mod rasteriser;
mod readback;
mod renderer;
mod run;
mod scan;
mod stencil;
mod texture_statistics;
mod tile_atlas;
mod tile_store;
mod workspace;

pub use device::Gpu;
pub use ldi::{GpuLdi, GpuWarp};
pub use rasteriser::GpuRasteriser;
pub use renderer::{Renderer, start_device};
pub use texture_statistics::TextureStatistics;
pub use tile_store::{Loaded, TileStore};

#[cfg(test)]
mod tests;

#[cfg(test)]
#[path = "../../tests/common/left_out.rs"]
mod left_out;
