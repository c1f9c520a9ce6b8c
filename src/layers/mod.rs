//! The method, one file per step in reading order.

pub mod options;
pub mod rasteriser;
pub mod view;

pub use options::{BoxShape, Method, Options};
pub use rasteriser::{FragmentLists, Fragments, Occlusion, Rasteriser};
pub use view::{InverseDepth, Item, ItemId, View};
