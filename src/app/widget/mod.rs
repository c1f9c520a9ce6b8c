//! Parts that panels are drawn of. They know the toolkit only.

pub mod dialog;
pub mod look;
