//! Widgets that panels are composed of. They depend on the toolkit only.

pub mod behind;
pub mod dialog;
pub mod elide;
pub mod focus;
pub mod look;
pub mod sized;
pub mod spinner;
