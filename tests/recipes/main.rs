//! What the program does without a face, from files on disk to files on disk: building, filling, exporting, and what
//! is estimated from real photos.

mod build;
mod castle_check;
mod castle_model;
#[path = "../common/mod.rs"]
mod common;
mod export;
mod fill;
mod gains;
#[path = "../invented/mod.rs"]
mod invented;
mod page;
mod site_page;
mod stack_store;
mod strangers;
