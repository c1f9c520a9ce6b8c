//! Reads XCF as GIMP writes it: versions 0 to 14, and later ones as far as their layers have the same
//! structure.
//!
//! The reader follows *Documentation of the XCF file format* (`devel-docs/xcf.txt` of GIMP) and files of GIMP
//! 2.10. It reads the properties of the layers first; their pixels stay in the file, each layer as the
//! position of its table of tiles.

mod head;
mod layers;
mod modes;
mod precision;
mod profile;
mod properties;
mod tiles;

use std::collections::HashSet;
use std::sync::Arc;

use self::head::XcfHeader;
use self::properties::Properties;
use crate::EditedDocument;
use crate::bytes::{Cursor, FileBytes};
use quadratura_base::error::Result;
use quadratura_document::export_record::ExportFormat;

/// The signature of an XCF, which its version follows.
pub const SIGNATURE: &[u8] = b"gimp xcf ";

/// Reads the structure of an XCF, without its pixels.
///
/// # Errors
/// [`quadratura_base::Error::Input`] with the position when the file is damaged, or newer than this reader supports;
/// [`quadratura_base::Error::Io`].
pub fn read(bytes: &Arc<FileBytes>) -> Result<EditedDocument> {
    let mut cursor = bytes.cursor(0);
    let head = XcfHeader::read(&mut cursor, bytes)?;
    let mut notes = head.notes();
    let properties = Properties::read(&mut cursor, head.wide)?;
    let at = cursor.at();
    let positions = positions(&mut cursor, head.wide)?;
    if positions.is_empty() {
        // GIMP itself saves a file without layers only of an image from which all were deleted.
        return Err(bytes.damaged(at, "no layers, expected one at least"));
    }
    let layers = layers::read_all(&positions, &head, &properties, bytes, &mut notes)?;
    let icc = properties.icc;
    Ok(EditedDocument {
        format: ExportFormat::Xcf,
        width: head.width,
        height: head.height,
        depth: head.precision.depth(),
        rounding: head.precision.rounding(),
        icc: if head.precision.linear { icc.map(profile::with_tone_curve) } else { icc },
        key: properties.key.or(properties.metadata_key),
        layers,
        notes,
    })
}

/// Reads a position in the file: 8 bytes in newer versions, 4 in older ones.
fn pointer(cursor: &mut Cursor, wide: bool) -> Result<u64> {
    if wide { cursor.u64() } else { Ok(cursor.u32()?.into()) }
}

/// Reads the positions of all layers, from top to bottom, up to a 0.
fn positions(cursor: &mut Cursor, wide: bool) -> Result<Vec<u64>> {
    let (mut positions, mut seen) = (Vec::new(), HashSet::new());
    loop {
        match pointer(cursor, wide)? {
            0 => return Ok(positions),
            position if seen.insert(position) => positions.push(position),
            position => return Err(cursor.damaged(format!("two layers at byte {position}"))),
        }
    }
}

/// Reads a text behind its length, with a trailing NUL.
fn text(cursor: &mut Cursor) -> Result<String> {
    let length = cursor.u32()?;
    let bytes = cursor.take(length.into())?;
    let text = String::from_utf8_lossy(&bytes);
    Ok(crate::place::tidy_name(&text))
}
