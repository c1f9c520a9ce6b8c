//! Paint of species on its way to image editors and back: [`export_species`] writes what six directions see of a plant as a layered
//! file, [`import_tree_paint`] keeps what was painted there.

mod content;
mod export;
mod import;
mod layers;

pub use export::{TreeExportOptions, export_species};
pub use import::{TreeImportOptions, TreeImported, import_tree_paint, tree_import_history, undo_tree_import};
