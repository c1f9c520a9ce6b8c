//! Reads PSD and PSB as image editors write them.
//!
//! The reader follows Adobe's *Photoshop File Formats Specification* (November 2019). It reads the properties
//! of the layers first; their pixels stay in the file, each channel as a position and a length.

mod blocks;
mod head;
mod layers;
mod masks;
mod merged;
mod names;
mod planes;
mod records;

use std::sync::Arc;

pub use self::head::SIGNATURE;
use self::head::{PsdHeader, wide};
use self::records::{Record, read_records};
use crate::EditedDocument;
use crate::bytes::{Cursor, FileBytes};
use quadratura_base::error::Result;
use quadratura_document::export_record::ExportFormat;

/// Reads the structure of a PSD or PSB, without its pixels.
///
/// # Errors
/// [`quadratura_base::Error::Input`] with the position when the file is damaged or of an unsupported kind (neither RGB
/// nor grey, neither 8 nor 16 bits); [`quadratura_base::Error::Io`].
pub fn read(bytes: &Arc<FileBytes>) -> Result<EditedDocument> {
    let mut cursor = bytes.cursor(0);
    let head = PsdHeader::read(&mut cursor, bytes)?;
    let mut notes = head.notes.clone();
    let records = layer_section(&mut cursor, &head)?;
    if records.is_empty() {
        notes.push("the file has no layers: it was flattened, or saved without them".into());
    }
    notes.extend(merged::cut_short(&mut cursor, &head));
    let layers = layers::from_records(records, &head, bytes, &mut notes);
    Ok(EditedDocument {
        format: ExportFormat::Psd,
        width: head.width,
        height: head.height,
        depth: head.depth,
        rounding: None,
        icc: head.icc,
        key: head.key,
        layers,
        notes,
    })
}

/// Reads the records of all layers, from bottom to top. With 16 bits Photoshop puts them in a block `Lr16`
/// behind an empty list; GIMP and Krita do not.
fn layer_section(cursor: &mut Cursor, head: &PsdHeader) -> Result<Vec<Record>> {
    let length = wide(cursor, head.kind)?;
    let mut section = cursor.part(length)?;
    if section.left() == 0 {
        return Ok(Vec::new());
    }
    let length = wide(&mut section, head.kind)?;
    if length > 0 {
        return read_records(&mut section.part(length)?, head);
    }
    if section.left() >= 4 {
        let global_mask = section.u32()?;
        section.skip(global_mask.into())?;
    }
    while let Some(block) = blocks::next_block(&mut section, head.kind)? {
        if matches!(&block.key, b"Layr" | b"Lr16" | b"Lr32") {
            return read_records(&mut block.content.clone(), head);
        }
    }
    Ok(Vec::new())
}
