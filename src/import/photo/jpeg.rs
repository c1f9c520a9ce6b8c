//! Checks whether a JPEG is complete. Its decoder fills the missing part of a truncated file with grey and
//! reports nothing.

use std::io::{BufRead, ErrorKind, Read, Seek, SeekFrom};

/// The first two bytes of a JPEG.
pub(super) const START: [u8; 2] = [0xFF, START_OF_IMAGE];
const START_OF_IMAGE: u8 = 0xD8;
const END_OF_IMAGE: u8 = 0xD9;
const RESTART_0: u8 = 0xD0;
/// The last two bytes of a JPEG without trailing data.
const END: [u8; 2] = [0xFF, END_OF_IMAGE];

/// Returns whether the picture of a JPEG is complete (ITU T.81, B.1 and B.2). A file that ends with an end
/// marker counts as complete; others, which may have trailing data, are scanned. `input` may be at any
/// position.
///
/// # Errors
/// The error of the system.
pub(super) fn is_whole(input: &mut (impl BufRead + Seek)) -> std::io::Result<bool> {
    if input.seek(SeekFrom::End(0))? < (START.len() + END.len()) as u64 {
        return Ok(false);
    }
    let mut last = [0; 2];
    input.seek(SeekFrom::End(-2))?;
    input.read_exact(&mut last)?;
    if last == END {
        return Ok(true);
    }
    input.seek(SeekFrom::Start(START.len() as u64))?;
    match reaches_the_end(input) {
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => Ok(false),
        reached => reached.map(|()| true),
    }
}

/// Follows the markers to the end marker. The code of a scan is skipped like anything between markers.
fn reaches_the_end(input: &mut (impl BufRead + Seek)) -> std::io::Result<()> {
    loop {
        match next_marker(input)? {
            END_OF_IMAGE => return Ok(()),
            // Markers without content; and a zero, which means that the 255 before it belongs to a scan.
            0x00 | 0x01 | RESTART_0..=START_OF_IMAGE => (),
            _ => {
                let length = u16::from_be_bytes(bytes(input)?);
                input.seek_relative(i64::from(length.saturating_sub(2)))?;
            }
        }
    }
}

/// Returns the byte behind the next 255, or behind several of them.
fn next_marker(input: &mut impl BufRead) -> std::io::Result<u8> {
    input.skip_until(0xFF)?;
    loop {
        match bytes(input)? {
            [0xFF] => (),
            [kind] => return Ok(kind),
        }
    }
}

fn bytes<const N: usize>(input: &mut impl Read) -> std::io::Result<[u8; N]> {
    let mut bytes = [0; N];
    input.read_exact(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    /// Two segments, a scan with a sample of 255 and a restart, the end.
    const PICTURE: &[u8] =
        b"\xFF\xD8\xFF\xE1\x00\x06\xFF\xD9ab\xFF\xDA\x00\x03x12\xFF\x0034\xFF\xD056\xFF\xFF\xD9";

    fn whole(bytes: &[u8]) -> bool {
        is_whole(&mut Cursor::new(bytes)).unwrap()
    }

    #[test]
    fn a_picture_is_whole_when_its_end_marker_is_reached_whatever_follows() {
        assert!(whole(PICTURE));
        assert!(whole(&[PICTURE, b"a film of the same moment"].concat()));
    }

    #[test]
    fn one_that_is_cut_anywhere_is_not_whole() {
        // Byte 8 is the end of the thumbnail in the first segment, which looks like the end of the file.
        for length in (0..PICTURE.len()).filter(|length| *length != 8) {
            assert!(!whole(&PICTURE[..length]), "{length} bytes");
        }
    }
}
