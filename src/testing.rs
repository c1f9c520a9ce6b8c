//! The packages below this one as its tests, benchmarks and examples see them, a tiny site to try the library on, and a model that
//! one photo shows.
//! Names and signatures here may change in any version.

#[cfg(feature = "gui")]
pub use quadratura_app as app;
pub use quadratura_base::{geometry, raster, scene};
pub use quadratura_document as document;
pub use quadratura_editing as editing;
pub use quadratura_exports as exports;
pub use quadratura_files as files;
pub use quadratura_foliage as foliage;
pub use quadratura_gpu as gpu;
pub use quadratura_handover as handover;
pub use quadratura_images as images;
pub use quadratura_import as import;
pub use quadratura_io as io;
pub use quadratura_layered_files as layered_files;
pub use quadratura_layers as layers;
pub use quadratura_ldi as ldi;
pub use quadratura_projection as projection;
pub use quadratura_projection::one_photo;
pub use quadratura_sites as sites;
pub use quadratura_stacks as stacks;
pub use quadratura_stacks::tiny_site::{tiny_project, tiny_site, tiny_stacks};
pub use quadratura_trees as trees;
pub use quadratura_view as view;
pub use quadratura_views as views;
