//! Export to the formats of other programs.

pub mod baked;
