//! The program without a face: open, sort, cluster, extract, save.

pub mod photos;
