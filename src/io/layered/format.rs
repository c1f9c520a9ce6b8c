//! What a layered format is, and the table of those that are written and read.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::Arc;

use super::bytes::FileBytes;
use super::document::LayeredDocument;
use super::edited::EditedDocument;
use super::psd::Kind;
use super::sink::Fit;
use super::xcf::Version;
use super::{ora, psd, xcf};
use crate::document::export_record::ExportFormat;
use crate::error::Result;

/// A layered format. Export, import, watch, the window's and the command line's choices take it from [`FORMATS`]; to add
/// one, name it in [`ExportFormat`], and here with its codec.
pub struct LayeredFormat {
    /// What records of exports and the command line call it.
    pub format: ExportFormat,
    /// What lists call it, with the editor that it is for: `XCF (GIMP)`.
    pub title: &'static str,
    /// What messages call its files: `XCF`.
    pub name: &'static str,
    /// What it is and what it is good for, for help.
    pub about: &'static str,
    /// Its files; none for the folder of PNG files, which `recipe::export` fills and [`super::folder`] reads.
    pub file: Option<FileFormat>,
}

/// A format that has all in one file.
pub struct FileFormat {
    /// Extensions in lower case.
    pub extensions: &'static [&'static str],
    /// How every such file begins, within the first 16 bytes.
    pub signature: &'static [u8],
    /// The ways in which a document may be written, the most widely read first. A later one is for documents that turn
    /// out too large for the one before.
    pub variants: fn(&LayeredDocument) -> Vec<Variant>,
    /// Reads what a file says, without its pixels.
    pub read: fn(&Arc<FileBytes>) -> Result<EditedDocument>,
}

/// One way to write a document.
pub struct Variant {
    /// Of the file, in lower case.
    pub extension: &'static str,
    /// Writes the document to a file that stands at its beginning; the path is what errors call it.
    pub write: fn(&mut File, &Path, &LayeredDocument) -> Result<Fit>,
}

/// All formats, the default first.
pub static FORMATS: &[LayeredFormat] = &[
    LayeredFormat {
        format: ExportFormat::Psd,
        title: "PSD",
        name: "PSD",
        about: "One layered PSD a photo, for Photoshop, GIMP and Krita",
        file: Some(FileFormat {
            extensions: &["psd", "psb"],
            signature: psd::read::SIGNATURE,
            variants: psd_variants,
            read: psd::read::read,
        }),
    },
    LayeredFormat {
        format: ExportFormat::Xcf,
        title: "XCF (GIMP)",
        name: "XCF",
        about: "XCF, for GIMP: opens fastest, and locks hold",
        file: Some(FileFormat {
            extensions: &["xcf"],
            signature: xcf::read::SIGNATURE,
            variants: xcf_variants,
            read: xcf::read::read,
        }),
    },
    LayeredFormat {
        format: ExportFormat::Ora,
        title: "OpenRaster",
        name: "OpenRaster",
        about: "OpenRaster, for Krita",
        file: Some(FileFormat {
            extensions: &["ora"],
            signature: ora::read::SIGNATURE,
            variants: |_| vec![Variant { extension: "ora", write: write_ora }],
            read: ora::read::read,
        }),
    },
    LayeredFormat {
        format: ExportFormat::Folder,
        title: "Folder of PNG",
        name: "folder",
        about: "A folder of PNG files with stack.json",
        file: None,
    },
    #[cfg(test)]
    super::dummy::FORMAT,
];

/// A PSD, and a PSB where that is too small.
fn psd_variants(document: &LayeredDocument) -> Vec<Variant> {
    let psd = Variant {
        extension: "psd",
        write: |file, path, document| psd::write(file, path, document, Kind::Psd),
    };
    let psb = Variant {
        extension: "psb",
        write: |file, path, document| psd::write(file, path, document, Kind::Psb),
    };
    match Kind::to_try_first(document) {
        Kind::Psd => vec![psd, psb],
        Kind::Psb => vec![psb],
    }
}

/// The oldest version that holds the document, and a newer one where that is too small.
fn xcf_variants(document: &LayeredDocument) -> Vec<Variant> {
    let three: Variant = Variant {
        extension: "xcf",
        write: |file, path, document| xcf::write(file, path, document, Version::Three),
    };
    let eleven = Variant {
        extension: "xcf",
        write: |file, path, document| xcf::write(file, path, document, Version::Eleven),
    };
    let twelve = Variant {
        extension: "xcf",
        write: |file, path, document| xcf::write(file, path, document, Version::Twelve),
    };
    match Version::to_try_first(document) {
        Version::Three => vec![three, eleven],
        Version::Eleven => vec![eleven],
        Version::Twelve => vec![twelve, eleven],
    }
}

fn write_ora(file: &mut File, path: &Path, document: &LayeredDocument) -> Result<Fit> {
    ora::write(BufWriter::new(file), path, document).map(|()| Fit::Whole)
}

/// The extensions of all layered files, in lower case.
pub fn extensions() -> Vec<&'static str> {
    let files = FORMATS.iter().filter_map(|format| format.file.as_ref());
    files.flat_map(|file| file.extensions).copied().collect()
}

/// The names of all layered files for messages: `PSD, XCF or OpenRaster`.
pub fn file_names() -> String {
    let names: Vec<&str> =
        FORMATS.iter().filter(|format| format.file.is_some()).map(|format| format.name).collect();
    let (last, others) = names.split_last().expect("the table is not empty");
    format!("{} or {last}", others.join(", "))
}

/// The entry of a format.
pub fn format_of(format: ExportFormat) -> &'static LayeredFormat {
    FORMATS.iter().find(|entry| entry.format == format).expect("a test holds the table complete")
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
