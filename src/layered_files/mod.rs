//! Layered images: a model of their content, and the file formats.
//!
//! A [`LayeredDocument`] describes a file without its pixels; each layer provides them when a writer needs
//! them, so only a few layers are in memory at a time. An [`EditedDocument`] is a file as an image editor
//! saved it, whose pixels are read layer by layer as well.

mod batches;
mod bytes;
pub mod composite;
pub mod depth;
pub mod document;
pub mod edited;
pub mod folder;
pub mod format;
pub mod grey;
mod groups;
pub mod image_turn;
mod inflate;
pub mod ora;
mod place;
pub mod png;
mod png_edited;
pub mod psd;
pub mod raster;
pub mod read;
pub mod recognise;
mod sink;
pub mod srgb;
pub mod xcf;

/// Name of the file with the document key in folders and OpenRaster files.
pub const KEY_FILE: &str = "quadratura-key.txt";

pub use bytes::FileBytes;
pub use composite::composite;
pub use depth::Depth;
pub use document::{Group, LayerNode, LayeredDocument, PixelLayer, PixelSource, Tag};
pub use edited::{BlendMode, EditedDocument, EditedLayer, EditedMask, Lazy, Rounding, StoredColours};
pub use grey::Grey;
pub use image_turn::ImageTurn;
pub use raster::Raster;
pub use read::read_layered;
pub use sink::FormatFit;

/// All formats, the default first: each has its entry beside its codec.
pub static FORMATS: &[format::LayeredFormat] = &[psd::FORMAT, xcf::FORMAT, ora::FORMAT, folder::FORMAT];
