//! The layering method, one file per step in reading order: the model as one photo sees it, its fragments and
//! the table of occlusions, cycles, elements and visibility layers, image layers and their content, the
//! filling of occluded texels, and the detection of transient objects (`strangers`).

pub mod options;
pub mod view;
pub mod wishes;

pub mod pairs;
pub mod rasteriser;
pub mod runs;
pub mod software;

pub mod cycles;
pub mod graph;
pub mod nodes;
pub mod parts;
pub mod quotient;
pub mod stencil;
mod tangle_pixels;

pub mod pieces;

pub mod cluster;
pub mod content;
pub mod fill;
pub mod strangers;
pub mod together;

pub mod sort;
#[cfg(test)]
mod sort_tests;

pub use options::{BoxShape, Method, Options};
pub use pairs::count_pairs;
pub use rasteriser::{FragmentLists, Fragments, Occlusion, Rasteriser, is_behind};
pub use software::SoftwareRasteriser;
pub use sort::{Sorted, sort_photo};
pub use view::{InverseDepth, Item, ItemId, View};
pub use wishes::{Faces, LayerConstraints};
