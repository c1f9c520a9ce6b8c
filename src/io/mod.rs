//! Reads and writes the files of a project: stacks, paint, masks, videos. Each format has a file or a folder of its
//! own.

pub mod baselines;
pub mod camera_path;
pub mod colour;
pub mod depth_image;
pub mod documents;
pub mod dome_picture;
pub mod exports;
pub mod failures;
pub mod film;
pub mod import_ledger;
mod in_use;
pub mod known_projects;
pub mod layer_png;
pub mod layer_reader;
pub mod layers_exr;
pub mod mask_file;
pub mod mask_store;
#[cfg(test)]
mod mutated;
pub mod ortho;
pub mod overlay;
pub mod paint_store;
pub mod photo_list;
pub mod photo_lock;
pub mod picture_exr;
pub mod picture_png;
pub mod programs;
pub mod project;
pub mod recovery;
pub mod reference;
pub mod stack_files;
pub mod stack_readers;
pub mod stack_store;
pub mod stroke_file;
pub mod thumbnails;
pub mod tree_paint;
pub mod unmasked;
pub mod watch;

#[cfg(test)]
#[path = "../../tests/common/mutations.rs"]
mod mutations;
