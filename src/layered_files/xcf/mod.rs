//! Writes XCF, the format of GIMP, which it saves and opens faster than any other, with all locks.
//!
//! The writer follows *Documentation of the XCF file format* (`devel-docs/xcf.txt` of GIMP) and uses the
//! oldest version that can hold the document, as that page recommends: version 3 for 8 bits, which Krita
//! reads as well; 11 where the file exceeds 4 GB; 12 for 16 bits. Layers are fetched, compressed and written
//! a few at a time; the list of their positions, which precedes them, is written at the end.

mod items;
mod properties;
pub mod read;
mod tiles;

use std::fs::File;
use std::io::{Seek, Write};
use std::path::Path;

use rayon::prelude::*;

use self::items::{XcfItem, items};
use self::properties::{image_properties, layer_properties, put_text};
use self::tiles::{TILE, Tiles};
use super::batches::batches;
use super::format::{FileFormat, LayeredFormat, Variant};
use super::sink::{FileSink, FormatFit};
use super::{Depth, LayeredDocument, Raster};
use quadratura_base::error::{Error, Result};
use quadratura_document::export_record::ExportFormat;

/// The version of the format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum XcfVersion {
    /// 8 bits, up to 4 GB; read by all programs that read XCF.
    Three,
    /// 8 bits, of any size; read by GIMP 2.10 and later.
    Eleven,
    /// 16 bits; read by GIMP 2.10 and later.
    Twelve,
}

/// Maximum side in pixels.
const LONGEST_SIDE: u32 = 524_288;
/// The colour model of images (RGB) and layers (RGB with alpha).
const RGB_IMAGE: u32 = 0;
const RGBA_LAYER: u32 = 1;
/// The precision: samples of 8 or 16 bits with the tone curve of the profile.
const PRECISION_8: u32 = 150;
const PRECISION_16: u32 = 250;

/// The entry in the table of formats.
pub const FORMAT: LayeredFormat = LayeredFormat {
    format: ExportFormat::Xcf,
    title: "XCF (GIMP)",
    name: "XCF",
    about: "XCF, for GIMP: opens fastest, and locks hold",
    file: Some(FileFormat { extensions: &["xcf"], signature: read::SIGNATURE, variants, read: read::read }),
};

/// Returns the oldest version that can hold the document, and a newer one where that is too small.
fn variants(document: &LayeredDocument) -> Vec<Variant> {
    let variant = |write| Variant { extension: "xcf", write };
    match XcfVersion::to_try_first(document) {
        XcfVersion::Three => vec![variant(write_three), variant(write_eleven)],
        XcfVersion::Eleven => vec![variant(write_eleven)],
        XcfVersion::Twelve => vec![variant(write_twelve)],
    }
}

fn write_three(file: &mut File, path: &Path, document: &LayeredDocument) -> Result<FormatFit> {
    write(file, path, document, XcfVersion::Three)
}

fn write_eleven(file: &mut File, path: &Path, document: &LayeredDocument) -> Result<FormatFit> {
    write(file, path, document, XcfVersion::Eleven)
}

fn write_twelve(file: &mut File, path: &Path, document: &LayeredDocument) -> Result<FormatFit> {
    write(file, path, document, XcfVersion::Twelve)
}

impl XcfVersion {
    /// Returns the oldest version that may hold the document; whether it does shows only in writing.
    pub fn to_try_first(document: &LayeredDocument) -> Self {
        match document.depth {
            Depth::Eight => Self::Three,
            Depth::Sixteen => Self::Twelve,
        }
    }

    fn mark(self) -> &'static [u8; 4] {
        match self {
            Self::Three => b"v003",
            Self::Eleven => b"v011",
            Self::Twelve => b"v012",
        }
    }

    fn precision(self) -> Option<u32> {
        match self {
            Self::Three => None,
            Self::Eleven => Some(PRECISION_8),
            Self::Twelve => Some(PRECISION_16),
        }
    }

    fn largest_file(self) -> u64 {
        match self {
            Self::Three => u32::MAX.into(),
            Self::Eleven | Self::Twelve => u64::MAX,
        }
    }

    fn put_pointer(self, out: &mut Vec<u8>, at: u64) {
        match self {
            // A file with larger ones is abandoned as too large.
            Self::Three => out.extend((at as u32).to_be_bytes()),
            Self::Eleven | Self::Twelve => out.extend(at.to_be_bytes()),
        }
    }

    fn pointers(self, list: &[u64]) -> Vec<u8> {
        let mut out = Vec::new();
        list.iter().chain([&0]).for_each(|at| self.put_pointer(&mut out, *at));
        out
    }
}

/// Writes the document to `out`, which must be at its beginning. The same document gives the same bytes.
/// `path` is named in errors.
///
/// # Errors
/// [`Error::Request`] when the document does not fit the format (see [`LayeredDocument::check`]);
/// [`Error::Io`] when writing fails; the errors of the layers' sources.
pub fn write(
    out: impl Write + Seek,
    path: &Path,
    document: &LayeredDocument,
    version: XcfVersion,
) -> Result<FormatFit> {
    write_within(out, path, document, version, version.largest_file())
}

fn write_within(
    out: impl Write + Seek,
    path: &Path,
    document: &LayeredDocument,
    version: XcfVersion,
    largest: u64,
) -> Result<FormatFit> {
    check(document, version)?;
    let list = items(document);
    let mut out = FileSink::new(out, path);
    out.bytes(&head(document, version))?;
    let places_at = out.written;
    let nothing_known = vec![0; list.len()];
    out.bytes(&version.pointers(&nothing_known))?;
    out.bytes(&version.pointers(&[]))?; // no channels
    let Some(places) = write_items(&mut out, document, &list, version, largest)? else {
        return Ok(FormatFit::TooLarge);
    };
    out.rewrite(places_at, &version.pointers(&places))?;
    Ok(FormatFit::Whole)
}

fn check(document: &LayeredDocument, version: XcfVersion) -> Result<()> {
    document.check()?;
    let (w, h) = (document.width, document.height);
    let longest = document.layers().map(|layer| layer.rect.w.max(layer.rect.h)).max().unwrap_or(0);
    if w.min(h) == 0 || w.max(h).max(longest) > LONGEST_SIDE {
        let title = &document.title;
        return Err(Error::Request(format!(
            "{title}: {w} x {h} pixels; a side of an XCF has 1 to 524,288 pixels"
        )));
    }
    if (version == XcfVersion::Twelve) != (document.depth == Depth::Sixteen) {
        let bits = document.depth.bits();
        return Err(Error::Request(format!("{}: {bits} bits in {version:?}", document.title)));
    }
    Ok(())
}

fn head(document: &LayeredDocument, version: XcfVersion) -> Vec<u8> {
    let mut out = [read::SIGNATURE, version.mark(), &[0]].concat();
    for number in [document.width, document.height, RGB_IMAGE].into_iter().chain(version.precision()) {
        out.extend(number.to_be_bytes());
    }
    out.extend(image_properties(document));
    out
}

/// Writes the layers and groups and returns the positions of their heads; `None` when the file exceeds
/// `largest` bytes.
fn write_items<W: Write + Seek>(
    out: &mut FileSink<W>,
    document: &LayeredDocument,
    list: &[XcfItem],
    version: XcfVersion,
    largest: u64,
) -> Result<Option<Vec<u64>>> {
    let bytes_of = |item: &XcfItem| item.layer().map_or(0, |layer| document.bytes_of(layer));
    let mut places = Vec::with_capacity(list.len());
    for batch in batches(list, bytes_of) {
        let compressed: Vec<Tiles> =
            batch.par_iter().map(|item| tiles_of(document, item)).collect::<Result<_>>()?;
        for (item, tiles) in batch.iter().zip(&compressed) {
            places.push(out.written);
            write_item(out, item, tiles, version)?;
        }
        if out.written > largest {
            return Ok(None);
        }
    }
    Ok(Some(places))
}

/// Returns the tiles of an entry. A group or a layer without pixels gets a transparent one, because XCF has
/// no empty layers.
fn tiles_of(document: &LayeredDocument, item: &XcfItem) -> Result<Tiles> {
    match item.layer() {
        Some(layer) if !layer.rect.is_empty() => Ok(Tiles::from_raster(&*document.pixels_of(layer)?)),
        _ => Ok(Tiles::from_raster(&Raster::blank(1, 1, document.depth))),
    }
}

/// Writes a layer's head, its hierarchy with one level, and that level's tiles.
fn write_item<W: Write + Seek>(
    out: &mut FileSink<W>,
    item: &XcfItem,
    tiles: &Tiles,
    version: XcfVersion,
) -> Result<()> {
    let mut head = Vec::new();
    for number in [tiles.width, tiles.height, RGBA_LAYER] {
        head.extend(number.to_be_bytes());
    }
    put_text(&mut head, item.name());
    head.extend(layer_properties(item));
    let pointer = if version == XcfVersion::Three { 4 } else { 8 };
    let hierarchy_at = out.written + head.len() as u64 + 2 * pointer;
    version.put_pointer(&mut head, hierarchy_at);
    version.put_pointer(&mut head, 0); // no mask
    for number in [tiles.width, tiles.height, tiles.bytes_per_pixel()] {
        head.extend(number.to_be_bytes());
    }
    let level_at = hierarchy_at + 12 + 2 * pointer;
    head.extend(version.pointers(&[level_at]));
    for number in [tiles.width, tiles.height] {
        head.extend(number.to_be_bytes());
    }
    let count = tiles.lengths().count() as u64;
    let mut at = level_at + 8 + (count + 1) * pointer;
    let mut places = Vec::with_capacity(count as usize);
    for length in tiles.lengths() {
        places.push(at);
        at += length;
    }
    head.extend(version.pointers(&places));
    out.bytes(&head)?;
    tiles.codes().try_for_each(|code| out.bytes(code))?;
    debug_assert_eq!(out.written, at, "tiles of {TILE} pixels lie where the level says");
    Ok(())
}
