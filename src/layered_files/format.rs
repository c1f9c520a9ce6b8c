//! The description of a layered format, and searches in the table of formats.

use std::fs::File;
use std::path::Path;
use std::sync::{Arc, OnceLock};

use super::FORMATS;
use super::bytes::FileBytes;
use super::document::LayeredDocument;
use super::edited::EditedDocument;
use super::sink::FormatFit;
use quadratura_base::error::Result;
use quadratura_document::export_record::ExportFormat;

/// A layered format. Export, import, watch, and the choices in the window and on the command line use the table
/// [`FORMATS`]; a new format is a codec with one of these, an entry there, and a value of [`ExportFormat`].
pub struct LayeredFormat {
    /// The value in records of exports and on the command line.
    pub format: ExportFormat,
    /// The name in lists, with the editor that it is for: `XCF (GIMP)`.
    pub title: &'static str,
    /// The name of its files in messages: `XCF`.
    pub name: &'static str,
    /// The description in help texts.
    pub about: &'static str,
    /// The reader and writer of the format; `None` for the folder of PNG files, which the package `editing` writes and
    /// [`super::folder`] reads.
    pub file: Option<FileFormat>,
}

/// A format with a single file.
pub struct FileFormat {
    /// The extensions, in lower case.
    pub extensions: &'static [&'static str],
    /// The bytes with which every such file begins, at most 16.
    pub signature: &'static [u8],
    /// Returns the variants in which a document may be written, the most widely read first. A later one is for
    /// documents that turn out too large for the one before.
    pub variants: fn(&LayeredDocument) -> Vec<Variant>,
    /// Reads the document, without its pixels.
    pub read: fn(&Arc<FileBytes>) -> Result<EditedDocument>,
}

/// A variant of a format.
pub struct Variant {
    /// The file's extension, in lower case.
    pub extension: &'static str,
    /// Writes the document to an empty file; the path is for errors.
    pub write: fn(&mut File, &Path, &LayeredDocument) -> Result<FormatFit>,
}

static PLUGGED_IN: OnceLock<LayeredFormat> = OnceLock::new();

/// Puts an entry into the table, in the place of the one with its value; the first one of a process counts. A test shows by it that a
/// format needs nothing else.
pub fn plug_in(format: LayeredFormat) {
    let _ = PLUGGED_IN.set(format);
}

/// The table, with the entry that was plugged in.
pub(super) fn formats() -> impl Iterator<Item = &'static LayeredFormat> {
    let plugged_in = PLUGGED_IN.get();
    let is_kept = move |entry: &&LayeredFormat| plugged_in.is_none_or(|other| other.format != entry.format);
    FORMATS.iter().filter(is_kept).chain(plugged_in)
}

/// Lists the extensions of all layered files, in lower case.
pub fn extensions() -> Vec<&'static str> {
    let files = formats().filter_map(|format| format.file.as_ref());
    files.flat_map(|file| file.extensions).copied().collect()
}

/// Returns the names of all layered files for messages: `PSD, XCF or OpenRaster`.
pub fn file_names() -> String {
    let names: Vec<&str> =
        formats().filter(|format| format.file.is_some()).map(|format| format.name).collect();
    let (last, others) = names.split_last().expect("the table is not empty");
    format!("{} or {last}", others.join(", "))
}

/// Returns the entry of a format.
pub fn format_of(format: ExportFormat) -> &'static LayeredFormat {
    formats().find(|entry| entry.format == format).expect("a test holds the table complete")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_format_has_one_entry_and_no_two_share_an_extension_or_a_signature() {
        for &format in ExportFormat::ALL {
            assert_eq!(FORMATS.iter().filter(|entry| entry.format == format).count(), 1, "{format}");
        }
        assert_eq!(FORMATS.len(), ExportFormat::ALL.len());
        let mut all = extensions();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), extensions().len());
        let signatures: Vec<&[u8]> =
            FORMATS.iter().filter_map(|entry| Some(entry.file.as_ref()?.signature)).collect();
        for (index, signature) in signatures.iter().enumerate() {
            assert!((1..=16).contains(&signature.len()));
            assert!(signatures[index + 1..].iter().all(|other| !other.starts_with(signature)));
        }
        assert!(file_names().starts_with("PSD, XCF"));
    }
}
