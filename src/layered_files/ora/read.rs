//! Reads OpenRaster as image editors write it.
//!
//! `stack.xml` is read first; each layer's PNG stays in the archive until it is requested.

use std::io::{Cursor, Read};
use std::sync::Arc;

use zip::ZipArchive;
use zip::read::ZipFile;

use super::stack_xml::{OraImage, parse};
use crate::bytes::{FileBytes, FileReader, SAVE_AGAIN};
use crate::place::rect_at;
use crate::png_edited::{self, PngHead};
use crate::{Depth, EditedDocument, EditedLayer, KEY_FILE, Lazy, StoredColours};
use quadratura_base::error::{Error, Result};
use quadratura_document::export_record::ExportFormat;
use quadratura_files::hash::Hashing;

/// The signature of a ZIP archive.
pub const SIGNATURE: &[u8] = b"PK\x03\x04";

/// Limit on the size of `stack.xml` and of the key in bytes.
const LONGEST_TEXT: u64 = 1 << 24;
/// Number of bytes of a PNG that reach to its pixels, unless its colour profile is large.
const BEGINNING: u64 = 1 << 14;
/// Maximum number of bytes that a byte of the archive can produce.
const MOST_INFLATED: u64 = 1032;

/// Reads the structure of an OpenRaster file, without its pixels.
///
/// # Errors
/// [`Error::Input`] when it is not an OpenRaster file or is damaged; [`Error::Io`].
pub fn read(bytes: &Arc<FileBytes>) -> Result<EditedDocument> {
    let mut archive = OraArchive::open(bytes)?;
    if archive.zip.index_for_name("stack.xml").is_none() {
        // Krita's own .kra is an archive of this kind, too.
        let found = "an archive without stack.xml, which is not an OpenRaster file";
        let remedy = "save it from the image editor as PSD or OpenRaster";
        return Err(Error::input(bytes.path(), "", found, remedy));
    }
    let xml = archive.text("stack.xml")?;
    let mut notes = Vec::new();
    let image = parse(&xml, &mut notes)
        .map_err(|found| Error::input(bytes.path(), "stack.xml", found, SAVE_AGAIN))?;
    let (found, depth, icc) = pictures(&mut archive, &image, &mut notes);
    let key = archive.text(KEY_FILE).ok().map(|key| key.trim().to_owned()).filter(|key| !key.is_empty());
    let layers = found.into_iter().map(|picture| picture.layer(&archive, depth, &mut notes));
    let mut layers: Vec<EditedLayer> = layers.collect::<Vec<_>>().into_iter().flatten().collect();
    layers.reverse();
    let (width, height) = (image.width, image.height);
    Ok(EditedDocument {
        format: ExportFormat::Ora,
        width,
        height,
        depth,
        rounding: None,
        icc,
        key,
        layers,
        notes,
    })
}

/// A layer of `stack.xml` with the header of its PNG, or why that cannot be read.
struct OraPicture<'x> {
    described: &'x super::stack_xml::LayerAttributes,
    head: Result<PngHead, String>,
}

/// Returns the layers from top to bottom, the bit depth, and the colour profile that is used for all.
fn pictures<'x>(
    archive: &mut OraArchive,
    image: &'x OraImage,
    notes: &mut Vec<String>,
) -> (Vec<OraPicture<'x>>, Depth, Option<Vec<u8>>) {
    let mut found = Vec::new();
    let mut depth = Depth::Eight;
    let mut icc = None;
    let mut is_first = true;
    for described in &image.layers {
        match archive.png_head(&described.file) {
            Ok(mut head) => {
                let profile = head.icc.take();
                if !std::mem::replace(&mut is_first, false) && profile != icc {
                    notes.push(format!(
                        "layer \"{}\" has another colour profile than the first layer; the first one is used for all",
                        described.name
                    ));
                } else {
                    icc = profile;
                }
                if head.depth == Depth::Sixteen {
                    depth = Depth::Sixteen;
                }
                found.push(OraPicture { described, head: Ok(head) });
            }
            Err(problem) => found.push(OraPicture { described, head: Err(problem) }),
        }
    }
    (found, depth, icc)
}

impl OraPicture<'_> {
    fn layer(self, archive: &OraArchive, depth: Depth, notes: &mut Vec<String>) -> Option<EditedLayer> {
        let Self { described, head } = self;
        let (x, y) = described.place;
        let (width, height) = head.as_ref().map_or((0, 0), |head| (head.width.into(), head.height.into()));
        let colours = head.as_ref().map_or(StoredColours::Full, |head| head.colours);
        let Some(rect) = rect_at(x, y, width, height) else {
            notes.push(format!("layer \"{}\" is left out: its position is ({x}, {y})", described.name));
            return None;
        };
        let (archive, file) = (archive.clone(), described.file.clone());
        let (same, stored) = (archive.clone(), file.clone());
        let code = move || Ok(format!("{} {depth:?}", same.clone().hash_of_code(&stored)?));
        let pixels = Lazy::new(move || match &head {
            Ok(head) => archive.clone().raster(&file, head, depth),
            Err(found) => Err(Error::input(archive.bytes.path(), file.as_str(), found, SAVE_AGAIN)),
        })
        .with_stored_hash(code);
        Some(EditedLayer {
            name: described.name.clone(),
            groups: described.groups.clone(),
            rect,
            visible: described.visible,
            hidden_by_group: described.hidden_by_group,
            opacity: described.opacity,
            blend: described.blend.clone(),
            masks: Vec::new(),
            id: None,
            locked: described.locked,
            colours,
            pixels,
        })
    }
}

/// The archive; copies share its directory.
#[derive(Clone)]
struct OraArchive {
    bytes: Arc<FileBytes>,
    zip: ZipArchive<FileReader>,
}

impl OraArchive {
    fn open(bytes: &Arc<FileBytes>) -> Result<Self> {
        let zip = ZipArchive::new(FileReader::new(bytes.clone())).map_err(|error| {
            let found = format!("the archive cannot be read ({error})");
            Error::input(bytes.path(), "", found, SAVE_AGAIN)
        })?;
        Ok(Self { bytes: bytes.clone(), zip })
    }

    fn wrong(&self, file: &str, found: impl ToString) -> Error {
        Error::input(self.bytes.path(), file, found.to_string(), SAVE_AGAIN)
    }

    /// Reads a short file of the archive as text.
    fn text(&mut self, name: &str) -> Result<String> {
        let bytes = self.content(name, LONGEST_TEXT)?;
        String::from_utf8(bytes).map_err(|error| self.wrong(name, error))
    }

    /// Reads at most the first `most` bytes of a file of the archive. Memory is allocated as they arrive.
    fn content(&mut self, name: &str, most: u64) -> Result<Vec<u8>> {
        let read = |file: ZipFile<FileReader>| {
            let most = most.min(file.compressed_size().saturating_mul(MOST_INFLATED));
            let mut content = Vec::new();
            file.take(most).read_to_end(&mut content).map(|_| content).map_err(|error| error.to_string())
        };
        let content = self.zip.by_name(name).map_err(|error| error.to_string()).and_then(read);
        content.map_err(|found| self.wrong(name, found))
    }

    /// Reads the header of a PNG, or returns what is wrong with this layer alone.
    fn png_head(&mut self, name: &str) -> Result<PngHead, String> {
        let length = match self.zip.by_name(name) {
            Ok(file) => file.size(),
            Err(error) => return Err(error.to_string()),
        };
        for most in [BEGINNING, length.max(BEGINNING)] {
            let beginning = match self.content(name, most) {
                Ok(beginning) => beginning,
                Err(error) => return Err(error.to_string()),
            };
            let head = png_edited::head(Cursor::new(&beginning));
            if head.is_ok() || most >= length {
                return head;
            }
        }
        Err("its header is longer than it claims".into())
    }

    /// Returns a hash of a file as it is stored in the archive.
    fn hash_of_code(&mut self, name: &str) -> Result<String> {
        let index = self.zip.index_for_name(name);
        let read = |index: usize| -> Result<String, String> {
            let mut file = self.zip.by_index_raw(index).map_err(|error| error.to_string())?;
            let (mut code, method) = (Vec::new(), format!("{:?}", file.compression()));
            file.read_to_end(&mut code).map_err(|error| error.to_string())?;
            let mut hashing = Hashing::default();
            hashing.add(method.as_bytes());
            hashing.add(&code);
            Ok(hashing.hash())
        };
        let hash = index.ok_or_else(|| "it is not in the archive".to_owned()).and_then(read);
        hash.map_err(|found| self.wrong(name, found))
    }

    fn raster(&mut self, name: &str, head: &PngHead, depth: Depth) -> Result<crate::Raster> {
        let content = self.content(name, u64::MAX)?;
        let length = content.len() as u64;
        png_edited::raster(Cursor::new(&content), length, head, depth)
            .map_err(|found| self.wrong(name, found))
    }
}
