//! What is saved: the authored project and the derived stacks.

pub mod names;
pub mod stack;

pub use stack::{Element, ImageLayer, Stack};
