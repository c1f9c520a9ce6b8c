//! The program without a face: open, sort, cluster, extract, save.

pub mod assemble;
pub mod budget;
pub mod build;
pub mod check;
pub mod colour;
pub mod create;
pub mod exploded;
pub mod export;
pub mod fill;
pub mod gains;
pub mod inputs;
pub mod layer_pixels;
pub mod named;
pub mod open;
pub mod paint;
mod photo_plan;
pub mod photos;
pub mod preview;
pub mod relief;
pub mod render;
pub mod score;
pub mod sheets;
mod side_by_side;
pub mod sources;
pub mod survey;
pub mod views;
