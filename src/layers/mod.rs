//! The method, one file per step in reading order.

pub mod options;
pub mod pairs;
pub mod rasteriser;
pub mod software;
pub mod view;

pub use options::{BoxShape, Method, Options};
pub use pairs::count_pairs;
pub use rasteriser::{FragmentLists, Fragments, Occlusion, Rasteriser, is_behind};
pub use software::SoftwareRasteriser;
pub use view::{InverseDepth, Item, ItemId, View};
