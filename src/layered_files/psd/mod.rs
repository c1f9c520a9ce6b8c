//! Writes PSD and PSB, the formats of Photoshop, which GIMP and Krita read and write as well.
//!
//! The writer follows Adobe's *Photoshop File Formats Specification* (November 2019). The layers' pixels are
//! fetched, compressed and written a few at a time; the lengths that precede them in the file are known only
//! afterwards and are written at the end.

mod packbits;
mod planes;
pub mod read;
mod records;
pub(super) mod resources;
#[cfg(test)]
mod tests;
mod variant;

use std::fs::File;
use std::io::{Seek, Write};
use std::path::Path;

use rayon::prelude::*;

use self::planes::Planes;
use self::records::{CHANNELS, ChannelLengths, EMPTY_CHANNEL, WrittenRecord, record_list, records};
pub use self::variant::PsdVariant;
use super::batches::batches;
use super::format::{FileFormat, LayeredFormat, Variant};
use super::sink::{FileSink, FormatFit};
use super::{Depth, LayeredDocument};
use quadratura_base::error::{Error, Result};
use quadratura_document::export_record::ExportFormat;

/// Maximum size of a PSD in bytes.
const LARGEST_PSD: u64 = (1 << 31) - 1;
/// Maximum side of a PSD in pixels.
const LONGEST_PSD_SIDE: u32 = 30_000;
/// Maximum side of a PSB in pixels.
const LONGEST_PSB_SIDE: u32 = 300_000;

/// The entry in the table of formats.
pub const FORMAT: LayeredFormat = LayeredFormat {
    format: ExportFormat::Psd,
    title: "PSD",
    name: "PSD",
    about: "One layered PSD a photo, for Photoshop, GIMP and Krita",
    file: Some(FileFormat {
        extensions: &["psd", "psb"],
        signature: read::SIGNATURE,
        variants,
        read: read::read,
    }),
};

/// Returns a PSD, and a PSB where that is too small.
fn variants(document: &LayeredDocument) -> Vec<Variant> {
    let psd = Variant { extension: PsdVariant::Psd.extension(), write: write_psd };
    let psb = Variant { extension: PsdVariant::Psb.extension(), write: write_psb };
    match PsdVariant::to_try_first(document) {
        PsdVariant::Psd => vec![psd, psb],
        PsdVariant::Psb => vec![psb],
    }
}

fn write_psd(file: &mut File, path: &Path, document: &LayeredDocument) -> Result<FormatFit> {
    write(file, path, document, PsdVariant::Psd)
}

fn write_psb(file: &mut File, path: &Path, document: &LayeredDocument) -> Result<FormatFit> {
    write(file, path, document, PsdVariant::Psb)
}

impl PsdVariant {
    /// Returns the smaller variant that may hold the document; whether it does shows only in writing.
    pub fn to_try_first(document: &LayeredDocument) -> Self {
        let longest = document.layers().map(|layer| layer.rect.w.max(layer.rect.h));
        let longest = longest.chain([document.width, document.height]).max();
        if longest <= Some(LONGEST_PSD_SIDE) { Self::Psd } else { Self::Psb }
    }

    /// Returns the extension of the file's name, without a dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Psd => "psd",
            Self::Psb => "psb",
        }
    }

    fn version(self) -> u16 {
        match self {
            Self::Psd => 1,
            Self::Psb => 2,
        }
    }

    fn largest_file(self) -> u64 {
        match self {
            Self::Psd => LARGEST_PSD,
            Self::Psb => u64::MAX,
        }
    }

    fn put_length(self, out: &mut Vec<u8>, length: u64) {
        match self {
            // A file with longer ones is abandoned as too large.
            Self::Psd => out.extend((length as u32).to_be_bytes()),
            Self::Psb => out.extend(length.to_be_bytes()),
        }
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
    kind: PsdVariant,
) -> Result<FormatFit> {
    write_within(out, path, document, kind, kind.largest_file())
}

fn write_within(
    out: impl Write + Seek,
    path: &Path,
    document: &LayeredDocument,
    kind: PsdVariant,
    largest: u64,
) -> Result<FormatFit> {
    check(document)?;
    let list = records(document);
    let mut out = FileSink::new(out, path);

    out.bytes(&resources::head(document, kind))?;
    let section_at = out.written;
    let nothing_known = vec![[0; 4]; list.len()];
    out.bytes(&LayerSection::new(document, &list, &nothing_known, kind).head)?;
    let Some(lengths) = write_channels(&mut out, document, &list, kind, largest)? else {
        return Ok(FormatFit::TooLarge);
    };
    let section = LayerSection::new(document, &list, &lengths, kind);
    out.bytes(&section.tail)?;
    write_merged(&mut out, document, kind)?;
    if out.written > largest {
        return Ok(FormatFit::TooLarge);
    }
    out.rewrite(section_at, &section.head)?;
    Ok(FormatFit::Whole)
}

fn check(document: &LayeredDocument) -> Result<()> {
    document.check()?;
    let (w, h) = (document.width, document.height);
    let longest = document.layers().map(|layer| layer.rect.w.max(layer.rect.h)).max().unwrap_or(0);
    if w.min(h) == 0 || w.max(h).max(longest) > LONGEST_PSB_SIDE {
        let title = &document.title;
        return Err(Error::Request(format!(
            "{title}: {w} x {h} pixels; a side of a PSB has 1 to 300,000 pixels"
        )));
    }
    if document.layers().count() + 2 * document.nodes.len() > i16::MAX as usize {
        return Err(Error::Request(format!("{}: more layers than a PSD can list", document.title)));
    }
    Ok(())
}

/// The parts of the layer section before and behind the pixels.
struct LayerSection {
    /// The part before the pixels. Its length does not depend on the channels' lengths.
    head: Vec<u8>,
    tail: Vec<u8>,
}

impl LayerSection {
    /// Builds the section. With 16 bits per sample the layers are in a block `Lr16` behind two empty parts,
    /// where Photoshop expects them.
    fn new(
        document: &LayeredDocument,
        list: &[WrittenRecord],
        lengths: &ChannelLengths,
        kind: PsdVariant,
    ) -> Self {
        let info = record_list(list, lengths, kind);
        let unpadded = info.len() as u64 + lengths.iter().flatten().sum::<u64>();
        let padded = unpadded.next_multiple_of(4);
        let mut layers = Vec::new();
        let mut tail = vec![0; (padded - unpadded) as usize];
        if document.depth == Depth::Sixteen {
            kind.put_length(&mut layers, 0);
            layers.extend(NO_GLOBAL_MASK);
            layers.extend(b"8BIMLr16");
            kind.put_length(&mut layers, padded);
        } else {
            kind.put_length(&mut layers, padded);
            tail.extend(NO_GLOBAL_MASK);
        }
        let rest = layers.len() as u64 + unpadded + tail.len() as u64;
        let mut head = Vec::new();
        kind.put_length(&mut head, rest);
        head.extend(layers);
        head.extend(info);
        Self { head, tail }
    }
}

/// The length field of an absent global mask.
const NO_GLOBAL_MASK: [u8; 4] = [0; 4];

/// Writes the pixels of all records and returns the channels' lengths; `None` when the file exceeds `largest`
/// bytes.
fn write_channels<W: Write + Seek>(
    out: &mut FileSink<W>,
    document: &LayeredDocument,
    list: &[WrittenRecord],
    kind: PsdVariant,
    largest: u64,
) -> Result<Option<ChannelLengths>> {
    let mut lengths = Vec::with_capacity(list.len());
    let bytes_of = |record: &WrittenRecord| match record {
        WrittenRecord::Layer(layer) => document.bytes_of(layer),
        WrittenRecord::GroupEnd | WrittenRecord::GroupStart(_) => 0,
    };
    for batch in batches(list, bytes_of) {
        let compressed: Vec<_> =
            batch.par_iter().map(|record| planes_of(document, record)).collect::<Result<_>>()?;
        for planes in compressed {
            lengths.push(write_planes(out, planes.as_ref(), kind)?);
        }
        if out.written > largest {
            return Ok(None);
        }
    }
    Ok(Some(lengths))
}

/// Writes the four channels of a record and returns their lengths; they are empty for a record without
/// pixels.
fn write_planes<W: Write + Seek>(
    out: &mut FileSink<W>,
    planes: Option<&Planes>,
    kind: PsdVariant,
) -> Result<[u64; 4]> {
    let Some(planes) = planes else {
        out.bytes(&[EMPTY_CHANNEL; 4].concat())?;
        return Ok([EMPTY_CHANNEL.len() as u64; 4]);
    };
    let path = out.path;
    for channel in 0..4 {
        planes.write_channel(channel, kind, out).map_err(Error::io(path, "write it"))?;
    }
    Ok([0, 1, 2, 3].map(|channel| planes.channel_length(channel, kind)))
}

fn planes_of(document: &LayeredDocument, record: &WrittenRecord) -> Result<Option<Planes>> {
    match record {
        WrittenRecord::Layer(layer) => Ok(Some(Planes::new(&*document.pixels_of(layer)?, &CHANNELS))),
        WrittenRecord::GroupEnd | WrittenRecord::GroupStart(_) => Ok(None),
    }
}

fn write_merged<W: Write + Seek>(
    out: &mut FileSink<W>,
    document: &LayeredDocument,
    kind: PsdVariant,
) -> Result<()> {
    let planes = Planes::new(&document.merged_pixels()?.on_white(), &[0, 1, 2]);
    let path = out.path;
    planes.write_merged(kind, out).map_err(Error::io(path, "write it"))
}
