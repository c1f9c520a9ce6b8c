//! Trees: views of a plant alone, and the trees that stand in a site.
//!
//! [`site_trees`] makes what is drawn of what `project.json` says; [`edit`] places, moves and removes trees, [`street`] places
//! those of a list; [`mask`] finds the
//! pixels of photos that show the real ones.

pub mod edit;
pub mod list;
pub mod mask;
mod site;
pub mod street;
mod views;

pub use site::{SiteTrees, plant_of, site_trees, trees_of};
pub use views::{PlantDrawing, PlantViews, plant_views};
