//! Writes OpenRaster, which Krita and MyPaint read and write (GIMP before version 3 does not, on Debian;
//! Krita 5 reads it in 8 bits only, so 16-bit photos are exported as PSD).
//!
//! The file is a ZIP archive: `mimetype` first, `stack.xml`, a PNG per layer, the merged picture and a
//! thumbnail. Nothing is compressed a second time. (OpenRaster 0.0.6, openraster.org.)

pub mod read;
mod stack_xml;

use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Seek, Write};
use std::path::Path;

use rayon::prelude::*;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use crate::FormatFit;
use crate::batches::batches;
use crate::document::{LayerNode, LayeredDocument, PixelLayer};
use crate::format::{FileFormat, LayeredFormat, Variant};
use crate::png::write_rgba;
use crate::psd::resources::escaped;
use crate::raster::Raster;
use quadratura_base::error::{Error, Result};
use quadratura_document::export_record::ExportFormat;

/// The entry in the table of formats.
pub const FORMAT: LayeredFormat = LayeredFormat {
    format: ExportFormat::Ora,
    title: "OpenRaster",
    name: "OpenRaster",
    about: "OpenRaster, for Krita",
    file: Some(FileFormat {
        extensions: &["ora"],
        signature: read::SIGNATURE,
        variants: |_| vec![Variant { extension: "ora", write: write_file }],
        read: read::read,
    }),
};

fn write_file(file: &mut File, path: &Path, document: &LayeredDocument) -> Result<FormatFit> {
    write(BufWriter::new(file), path, document).map(|()| FormatFit::Whole)
}

/// The longest side of the thumbnail in pixels, by the standard.
const THUMBNAIL: u32 = 256;

/// Writes the document to `out`, which must be at its beginning. The same document gives the same bytes.
/// `path` is named in errors.
///
/// # Errors
/// [`Error::Request`] when names do not fit the format (see [`LayeredDocument::check`]); [`Error::Io`] when
/// writing fails; the errors of the layers' sources.
pub fn write(out: impl Write + Seek, path: &Path, document: &LayeredDocument) -> Result<()> {
    document.check()?;
    let mut archive = Archive { zip: ZipWriter::new(out).set_auto_large_file(), path };
    archive.add("mimetype", b"image/openraster")?;
    archive.add("stack.xml", stack_xml(document).as_bytes())?;
    archive.add(crate::KEY_FILE, document.key.as_bytes())?;
    let layers: Vec<(usize, &PixelLayer)> = document.layers().enumerate().collect();
    for batch in batches(&layers, |(_, layer)| document.bytes_of(layer)) {
        let encoded: Vec<_> = batch
            .par_iter()
            .map(|(index, layer)| Ok((*index, png(path, document, &*document.pixels_of(layer)?)?)))
            .collect::<Result<_>>()?;
        encoded.iter().try_for_each(|(index, bytes)| archive.add(&layer_file(*index), bytes))?;
    }
    let merged = document.merged_pixels()?.on_white();
    let bytes = png(path, document, &merged)?;
    archive.add("mergedimage.png", &bytes)?;
    let bytes = png(path, document, &merged.thumbnail(THUMBNAIL))?;
    archive.add("Thumbnails/thumbnail.png", &bytes)?;
    archive.finish()
}

/// Returns the file's name by index, because names of layers contain characters that file names must not.
fn layer_file(index: usize) -> String {
    format!("data/layer{index:04}.png")
}

fn png(path: &Path, document: &LayeredDocument, raster: &Raster) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    write_rgba(&mut bytes, raster, document.icc.as_deref()).map_err(Error::io(path, "write it"))?;
    Ok(bytes)
}

struct Archive<'p, W: Write + Seek> {
    zip: ZipWriter<W>,
    path: &'p Path,
}

impl<W: Write + Seek> Archive<'_, W> {
    /// Adds a file uncompressed and without a time, so that the same document gives the same bytes.
    fn add(&mut self, name: &str, bytes: &[u8]) -> Result<()> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(DateTime::default())
            .unix_permissions(0o644);
        let started = self.zip.start_file(name, options).map_err(std::io::Error::other);
        started.and_then(|()| self.zip.write_all(bytes)).map_err(Error::io(self.path, "write it"))
    }

    fn finish(self) -> Result<()> {
        let finished = self.zip.finish().map_err(std::io::Error::other);
        finished.and_then(|mut out| out.flush()).map_err(Error::io(self.path, "write it"))
    }
}

/// Returns `stack.xml` with layers from top to bottom. Groups stay at 0, 0, because readers disagree whether
/// a group's position moves its layers.
fn stack_xml(document: &LayeredDocument) -> String {
    let mut index = document.layers().count();
    let mut next = |layer: &PixelLayer, indent: usize| {
        index -= 1;
        layer_xml(layer, &layer_file(index), indent)
    };
    let mut nodes = String::new();
    for node in document.nodes.iter().rev() {
        match node {
            LayerNode::Layer(layer) => nodes += &next(layer, 2),
            LayerNode::Group(group) => {
                let layers: String = group.layers.iter().rev().map(|layer| next(layer, 3)).collect();
                let name = escaped(&group.name);
                let _ = write!(nodes, "  <stack name=\"{name}\" x=\"0\" y=\"0\">\n{layers}  </stack>\n");
            }
        }
    }
    let (w, h) = (document.width, document.height);
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <image version=\"0.0.3\" w=\"{w}\" h=\"{h}\" xres=\"72\" yres=\"72\">\n \
         <stack x=\"0\" y=\"0\">\n{nodes} </stack>\n</image>\n"
    )
}

fn layer_xml(layer: &PixelLayer, file: &str, indent: usize) -> String {
    let name = escaped(&layer.name);
    let x = layer.rect.x;
    let y = layer.rect.y;
    let visibility = if layer.visible { "visible" } else { "hidden" };
    let locked = if layer.locked { " edit-locked=\"true\"" } else { "" };
    let selected = if layer.selected { " selected=\"true\"" } else { "" };
    format!(
        "{:indent$}<layer name=\"{name}\" src=\"{file}\" x=\"{x}\" y=\"{y}\" opacity=\"1.0\" \
         visibility=\"{visibility}\" composite-op=\"svg:src-over\"{locked}{selected}/>\n",
        ""
    )
}
