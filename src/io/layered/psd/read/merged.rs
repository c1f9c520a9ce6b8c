//! The merged picture behind the layers. Nothing is taken from it, but it tells whether the file is whole.

use super::head::Head;
use crate::error::Result;
use crate::io::layered::bytes::Cursor;
use crate::io::layered::psd::Kind;

const RAW: u16 = 0;
const RLE: u16 = 1;

/// What to say of a file that ends before its merged picture does; `cursor` stands in front of that.
pub fn cut_short(cursor: &mut Cursor, head: &Head) -> Option<String> {
    let is_whole = length(cursor, head).is_ok_and(|length| length <= cursor.left());
    (!is_whole).then(|| {
        "the file ends within its merged picture: it was cut short. All layers are there; save it once more to be \
         sure of them"
            .to_owned()
    })
}

/// Of its code from where the cursor stands then, in bytes; 0 where the kind of code does not say.
fn length(cursor: &mut Cursor, head: &Head) -> Result<u64> {
    let rows = u64::from(head.height) * u64::from(head.channels);
    match cursor.u16()? {
        RAW => Ok(rows * u64::from(head.width) * head.depth.bytes()),
        RLE => {
            let counts = cursor.take(rows * if head.kind == Kind::Psb { 4 } else { 2 })?;
            Ok(match head.kind {
                Kind::Psd => counts.as_chunks().0.iter().map(|c| u64::from(u16::from_be_bytes(*c))).sum(),
                Kind::Psb => counts.as_chunks().0.iter().map(|c| u64::from(u32::from_be_bytes(*c))).sum(),
            })
        }
        _ => Ok(0),
    }
}
