//! Checks whether a PNG is complete, by the lengths of its chunks and without decoding it.

use std::io::{BufRead, ErrorKind, Seek, SeekFrom};

/// The first bytes of a PNG.
pub(super) const START: [u8; 8] = *b"\x89PNG\r\n\x1A\n";

/// The length of a chunk's checksum, in bytes.
const CHECKSUM: u64 = 4;

/// Returns whether a PNG reaches its last chunk (W3C, Portable Network Graphics, 5.3): each chunk says how long it is. `input` may be at
/// any position.
///
/// # Errors
/// The error of the system.
pub(super) fn is_whole(input: &mut (impl BufRead + Seek)) -> std::io::Result<bool> {
    let length = input.seek(SeekFrom::End(0))?;
    let mut at = input.seek(SeekFrom::Start(START.len() as u64))?;
    while at < length {
        let mut chunk = [0; 8];
        match input.read_exact(&mut chunk) {
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(false),
            read => read?,
        }
        let [a, b, c, d, kind @ ..] = chunk;
        if kind == *b"IEND" {
            return Ok(true);
        }
        at += chunk.len() as u64 + u64::from(u32::from_be_bytes([a, b, c, d])) + CHECKSUM;
        input.seek(SeekFrom::Start(at))?;
    }
    Ok(false)
}
