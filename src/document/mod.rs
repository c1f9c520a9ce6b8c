//! The saved documents: the authored project and the derived stacks.

pub mod bookmark;
pub mod camera_path;
pub mod colour;
pub mod decisions;
pub mod export_record;
pub mod frame;
pub mod history;
mod in_use;
pub mod masks;
pub mod model_change;
pub mod names;
pub mod page;
pub mod paint;
mod path_edit;
pub mod project;
pub mod stack;
pub mod stroke;
pub mod surroundings;
pub mod tree_paint;
pub mod trees;

pub use bookmark::Bookmark;
pub use camera_path::CameraPath;
pub use colour::ColourDecisions;
pub use decisions::{Decisions, PhotoDecisions};
pub use frame::SiteFrame;
pub use history::History;
pub use in_use::FilesInUse;
pub use masks::Masks;
pub use page::{PageDecisions, PlaceText};
pub use project::Project;
pub use stack::{Element, ImageLayer, Stack};
pub use surroundings::SurroundingsPicture;
pub use trees::Trees;
