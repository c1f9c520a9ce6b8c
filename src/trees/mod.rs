//! Trees: views of a plant alone, and the trees that stand in a site.
//!
//! [`site_trees`] makes what is drawn of what `project.json` says; [`edit`] places, moves and removes trees, [`street`] places
//! those of a list; [`mask`] finds the pixels of photos that show the real ones; [`light`] estimates the light on them; [`paint`] draws species
//! with what was painted on them.

pub mod baked;
pub mod edit;
mod images;
pub mod light;
pub mod list;
pub mod mask;
pub mod paint;
pub mod plant_files;
mod site;
pub mod street;
pub mod sunlight;
mod views;

pub use images::{plant_images, species_images};
pub use site::{KnownPlants, PlantParts, SiteTrees, plant_of, shine, site_trees, site_trees_with};
pub use views::{PlantDrawing, PlantMethod, PlantViews, ViewComparison, plant_views};
