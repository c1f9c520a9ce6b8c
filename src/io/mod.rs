//! Reads and writes the files of a project: cameras, models, photos, stacks, paint, layered images. Each
//! format has a file or a folder of its own.

pub mod atomic;
pub mod baselines;
pub mod camera_path;
pub mod cameras;
pub mod colour;
pub mod documents;
pub mod exports;
pub mod film;
pub mod hash;
pub mod import_ledger;
pub mod inbox;
pub mod json;
pub mod layer_png;
pub mod layer_reader;
pub mod layered;
pub mod lock;
pub mod mask_file;
pub mod mask_store;
pub mod models;
pub mod overlay;
pub mod paint_store;
pub mod photo;
pub mod photo_list;
pub mod picture_png;
pub mod programs;
pub mod project;
pub mod recovery;
pub mod reference;
pub mod relief_file;
pub mod stack_files;
pub mod stack_store;
pub mod stamp;
pub mod stroke_file;
pub mod thumbnails;
pub mod watch;
