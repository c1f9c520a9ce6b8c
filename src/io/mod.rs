//! Files: cameras, models, photos, layered images. One file per format.

pub mod atomic;
