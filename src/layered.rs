//! Layered files are written for image editors (PSD, XCF, OpenRaster, folders of PNG), and imported again once they
//! were painted on.
//!
//! # Write a PSD
//!
//! The writers take any [`LayeredDocument`], whether it comes from a project or not. Pixels are asked for one layer at
//! a time, so a document may be larger than the memory.
//!
//! ```
//! use std::fs::File;
//! use std::sync::Arc;
//!
//! use quadratura::cameras::PixelRect;
//! use quadratura::layered::{
//!     Depth, FormatFit, Group, LayerNode, LayeredDocument, PixelLayer, PsdVariant, Raster, read_layered, write_psd,
//! };
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let temporary = tempfile::tempdir()?;
//! # let folder = temporary.path();
//! let rect = PixelRect { x: 10, y: 5, w: 20, h: 10 };
//! let red = move || {
//!     let mut raster = Raster::blank(rect.w, rect.h, Depth::Eight);
//!     raster.set_rgba16(0, 0, [u16::MAX, 0, 0, u16::MAX]);
//!     Ok(Arc::new(raster))
//! };
//! let group = Group { name: "tower".into(), layers: vec![PixelLayer::new("window", rect, Box::new(red))] };
//! let document = LayeredDocument {
//!     width: 64,
//!     height: 48,
//!     depth: Depth::Eight,
//!     icc: None, // sRGB
//!     key: "a-key-of-your-own".into(),
//!     title: "left.png".into(),
//!     nodes: vec![LayerNode::Group(group)],
//!     merged: Box::new(|| Ok(Arc::new(Raster::blank(64, 48, Depth::Eight)))),
//! };
//! let file = folder.join("left.psd");
//! let fit = write_psd(File::create(&file)?, &file, &document, PsdVariant::to_try_first(&document))?;
//! assert_eq!(fit, FormatFit::Whole, "write it again as a PSB where this is not so");
//!
//! let read = read_layered(&file)?;
//! assert_eq!((read.layers[0].name.as_str(), read.layers[0].rect), ("window", rect));
//! assert_eq!(read.layers[0].pixels.read()?.rgba16(0, 0), [u16::MAX, 0, 0, u16::MAX]);
//! # Ok(())
//! # }
//! ```
//!
//! # Export the stacks of a project
//!
//! ```
//! use quadratura::layered::{ExportFormat, ExportOptions, export};
//! use quadratura::project::open;
//! use quadratura::task::Task;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let temporary = tempfile::tempdir()?;
//! # let (project, _) = quadratura::testing::tiny_stacks(temporary.path())?;
//! # let out = temporary.path().join("layers");
//! let task = Task::silent();
//! let opened = open(&project, &task)?;
//! let options = ExportOptions {
//!     format: ExportFormat::Ora,
//!     decisions: Some(opened.project.decisions.clone()),
//!     ..ExportOptions::default()
//! };
//! let photos = opened.photos_named(&[])?; // all
//! let exported = export(&project, &photos, &out, &options, &task)?;
//! for report in &exported.done {
//!     println!("{}: {} layers in {}", report.photo, report.layers, report.path.display());
//! }
//! assert!(exported.failed.is_empty());
//! # assert!(out.join("left.png.ora").is_file());
//! # Ok(())
//! # }
//! ```
//!
//! # Paint on a file and import it
//!
//! Any program that keeps the names of the layers and the document key may stand in for the image editor.
//!
//! ```
//! use std::fs::File;
//! use std::sync::Arc;
//!
//! use quadratura::layered::{
//!     ExportOptions, ImportOptions, LayerNode, LayerState, LayeredDocument, PixelLayer, PsdVariant, Raster, export,
//!     import, read_layered, write_psd,
//! };
//! use quadratura::project::ProjectLock;
//! use quadratura::task::Task;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let temporary = tempfile::tempdir()?;
//! # let (project, opened) = quadratura::testing::tiny_stacks(temporary.path())?;
//! # let out = temporary.path().join("layers");
//! let task = Task::silent();
//! let photo = &opened.site.photos[0];
//! let exported = export(&project, &[photo], &out, &ExportOptions::default(), &task)?;
//! let file = &exported.done[0].path;
//!
//! let document = read_layered(file)?;
//! let mut nodes = Vec::new();
//! for layer in &document.layers {
//!     let mut pixels = layer.pixels.read()?;
//!     if layer.name.starts_with("box") {
//!         let rows = 0..pixels.height();
//!         rows.for_each(|y| pixels.set_rgba16(pixels.width() / 2, y, [0, 0, u16::MAX, u16::MAX]));
//!     }
//!     let pixels = Arc::new(pixels);
//!     let source = Box::new(move || Ok(pixels.clone()));
//!     nodes.push(LayerNode::Layer(PixelLayer::new(&layer.name, layer.rect, source)));
//! }
//! let (width, height, depth) = (document.width, document.height, document.depth);
//! let painted = LayeredDocument {
//!     width,
//!     height,
//!     depth,
//!     icc: document.icc.clone(),
//!     key: document.key.clone().expect("an export has a key"),
//!     title: photo.name.clone(),
//!     nodes,
//!     merged: Box::new(move || Ok(Arc::new(Raster::blank(width, height, depth)))),
//! };
//! let edited = out.join("edited.psd");
//! write_psd(File::create(&edited)?, &edited, &painted, PsdVariant::Psd)?;
//!
//! let lock = ProjectLock::take(&project)?;
//! let imported = import(&project, &[edited], ImportOptions::default(), &task)?;
//! drop(lock);
//! for layer in imported.files.iter().flat_map(|file| &file.layers) {
//!     println!("{}: {}, {} pixels changed", layer.name, layer.state.word(), layer.changed);
//! }
//! let layers = &imported.files[0].layers;
//! assert!(layers.iter().any(|layer| layer.state == LayerState::Painted && layer.name.starts_with("box")));
//! # Ok(())
//! # }
//! ```

#[doc(inline)]
pub use quadratura_document::export_record::ExportFormat;
#[doc(inline)]
pub use quadratura_document::paint::PaintImport;
#[doc(inline)]
pub use quadratura_editing::export::{ExportOptions, ExportReport, Exported, export};
#[doc(inline)]
pub use quadratura_editing::import::question::Question;
#[doc(inline)]
pub use quadratura_editing::import::report::{Conflict, FileReport, LayerImportReport, LayerState};
#[doc(inline)]
pub use quadratura_editing::import::{
    ImportOptions, Imported, history as import_history, import_once as import, take_back as undo_import,
};
#[doc(inline)]
pub use quadratura_layered_files::ora::write as write_ora;
#[doc(inline)]
pub use quadratura_layered_files::psd::{PsdVariant, write as write_psd};
#[doc(inline)]
pub use quadratura_layered_files::xcf::{XcfVersion, write as write_xcf};
#[doc(inline)]
pub use quadratura_layered_files::{
    BlendMode, Depth, EditedDocument, EditedLayer, EditedMask, FormatFit, Grey, Group, LayerNode,
    LayeredDocument, Lazy, PixelLayer, PixelSource, Raster, Rounding, StoredColours, Tag, read_layered,
};
