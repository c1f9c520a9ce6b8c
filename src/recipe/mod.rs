//! The program without a face: open, sort, cluster, extract, save.

pub mod assemble;
pub mod build;
pub mod create;
pub mod export;
pub mod inputs;
pub mod open;
pub mod photos;
pub mod survey;
