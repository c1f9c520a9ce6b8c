//! XCF as GIMP writes it, versions 0 to 14; later ones as far as their layers are built the same.
//!
//! Read from *Documentation of the XCF file format* (`devel-docs/xcf.txt` of GIMP) and from files of GIMP
//! 2.10. First all that is said of the layers; their pixels stay in the file, each layer as the place of
//! its table of tiles.

mod head;
mod layers;
mod modes;
mod precision;
mod profile;
mod properties;
mod tiles;

use std::collections::HashSet;
use std::sync::Arc;

use self::head::Head;
use self::properties::Properties;
use crate::document::export_record::ExportFormat;
use crate::error::Result;
use crate::io::layered::EditedDocument;
use crate::io::layered::bytes::{Cursor, FileBytes};

/// How every XCF begins; its version follows.
pub const SIGNATURE: &[u8] = b"gimp xcf ";

/// Reads what an XCF says, without its pixels.
///
/// # Errors
/// [`crate::Error::Input`] with the place when it is damaged, or newer than this reader understands;
/// [`crate::Error::Io`].
pub fn read(bytes: &Arc<FileBytes>) -> Result<EditedDocument> {
    let mut cursor = bytes.cursor(0);
    let head = Head::read(&mut cursor, bytes)?;
    let mut notes = head.notes();
    let properties = Properties::read(&mut cursor, head.wide)?;
    let places = places(&mut cursor, head.wide)?;
    if places.is_empty() {
        notes.push("it has no layers".into());
    }
    let layers = layers::read_all(&places, &head, &properties, bytes, &mut notes)?;
    let icc = properties.icc;
    Ok(EditedDocument {
        format: ExportFormat::Xcf,
        width: head.width,
        height: head.height,
        depth: head.precision.depth(),
        icc: if head.precision.linear { icc.map(profile::with_tone_curve) } else { icc },
        key: properties.key.or(properties.metadata_key),
        layers,
        notes,
    })
}

/// A place in the file: 8 bytes in newer versions, 4 in older ones.
fn pointer(cursor: &mut Cursor, wide: bool) -> Result<u64> {
    if wide { cursor.u64() } else { Ok(cursor.u32()?.into()) }
}

/// The places of all layers, from the top, up to a 0.
fn places(cursor: &mut Cursor, wide: bool) -> Result<Vec<u64>> {
    let (mut places, mut seen) = (Vec::new(), HashSet::new());
    loop {
        match pointer(cursor, wide)? {
            0 => return Ok(places),
            place if seen.insert(place) => places.push(place),
            place => return Err(cursor.damaged(format!("two layers at byte {place}"))),
        }
    }
}

/// A text behind its length, closed by a NUL.
fn text(cursor: &mut Cursor) -> Result<String> {
    let length = cursor.u32()?;
    let bytes = cursor.take(length.into())?;
    let text = String::from_utf8_lossy(&bytes);
    Ok(crate::io::layered::place::tidy_name(&text))
}
