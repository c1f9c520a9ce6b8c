//! Files: cameras, models, photos, layered images. One file per format.

pub mod atomic;
pub mod baselines;
pub mod camera_path;
pub mod cameras;
pub mod colour;
pub mod exports;
pub mod film;
pub mod hash;
pub mod inbox;
pub mod json;
pub mod layer_png;
pub mod layer_reader;
pub mod layered;
pub mod lock;
pub mod models;
pub mod overlay;
pub mod paint_store;
pub mod photo;
pub mod photo_list;
pub mod picture_png;
pub mod project;
pub mod reference;
pub mod relief_file;
pub mod stack_files;
pub mod stack_store;
pub mod watch;
