//! The layering method, one file per step in reading order: the model as one photo sees it, its fragments and
//! the table of occlusions, cycles, elements and visibility layers, image layers and their content, the
//! surroundings, the filling of occluded texels, and the agreement of photos with each other (`agreement`).

pub mod constraints;
pub mod options;
pub mod projected_model;

pub mod pairs;
pub mod rasteriser;
pub mod runs;
pub mod software;

mod component_pixels;
pub mod cycles;
pub mod nodes;
pub mod occlusion_graph;
pub mod parts;
pub mod quotient;
pub mod stencil;
pub mod tolerated;

pub mod pieces;

pub mod leftovers;

pub mod agreement;
pub mod cluster;
pub mod content;
pub mod device;
pub mod dome;
pub mod fill;
pub mod matte;
pub mod one_sky;
pub mod sky_model;
pub mod surroundings;
pub mod together;

pub mod sort;
#[cfg(test)]
mod sort_tests;

pub use cluster::LayerIndex;
pub use constraints::{Faces, LayerConstraints};
pub use options::{BoxShape, Method, ObjectOptions, Options};
pub use pairs::count_pairs;
pub use parts::ElementIndex;
pub use projected_model::{Item, ItemId, ProjectedModel};
pub use rasteriser::{FragmentLists, Fragments, Occlusion, Rasteriser, is_behind};
pub use software::SoftwareRasteriser;
pub use sort::{Sorted, sort_photo};
