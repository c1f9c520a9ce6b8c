//! Checks the merged picture behind the layers. Its pixels are not used, but it shows whether the file is
//! complete.

use super::head::PsdHeader;
use crate::bytes::Cursor;
use crate::psd::variant::PsdVariant;
use quadratura_base::error::Result;

const RAW: u16 = 0;
const RLE: u16 = 1;

/// Returns a note if the file ends before its merged picture does; `cursor` must be at the start of that
/// picture.
pub fn cut_short(cursor: &mut Cursor, head: &PsdHeader) -> Option<String> {
    let is_whole = length(cursor, head).is_ok_and(|length| length <= cursor.left());
    (!is_whole).then(|| {
        "the file ends within its merged picture: it was cut short. All layers are there; save it again to be \
         sure of them"
            .to_owned()
    })
}

/// Returns the length of the picture's code in bytes; 0 where the compression method does not tell.
fn length(cursor: &mut Cursor, head: &PsdHeader) -> Result<u64> {
    let rows = u64::from(head.height) * u64::from(head.channels);
    match cursor.u16()? {
        RAW => Ok(rows * u64::from(head.width) * head.depth.bytes()),
        RLE => {
            let counts = cursor.take(rows * if head.kind == PsdVariant::Psb { 4 } else { 2 })?;
            Ok(match head.kind {
                PsdVariant::Psd => {
                    counts.as_chunks().0.iter().map(|c| u64::from(u16::from_be_bytes(*c))).sum()
                }
                PsdVariant::Psb => {
                    counts.as_chunks().0.iter().map(|c| u64::from(u32::from_be_bytes(*c))).sum()
                }
            })
        }
        _ => Ok(0),
    }
}
