//! One view of a sub-object (`OBJECT-COPY.LATITUDE.LONGITUDE.mb`): a line of JSON, then a byte a pixel that says how many surfaces it
//! has, then in the order of the pixels, nearest first, all depths, all colours, all normals, all masks; each of the five deflated.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::REMEDY;
use crate::{MBuffer, MSample, NormalCode};
use quadratura_base::error::{Error, Result};
use quadratura_files::atomic::write_atomically;
use quadratura_files::deflated::{Fault, deflated, first_line, inflated};

/// The value of `format`.
pub const FORMAT: &str = "quadratura-mbuffer";
/// The version that this program writes; it reads no other.
pub const VERSION: u32 = 1;
/// The largest number of columns and rows.
const MOST_SIDE: u32 = 16_384;

/// The first line of the file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Header {
    format: String,
    version: u32,
    /// Columns and rows.
    side: u32,
    samples: u64,
    /// Bytes of counts, depths, colours, normals and masks.
    streams: [u64; 5],
}

/// Bytes of a sample in each stream after the counts.
const BYTES: [u64; 4] = [2, 3, 2, 2];

/// Writes a view of `side` columns and rows.
///
/// # Errors
/// [`Error::Io`].
pub fn write_mbuffer(file: &Path, view: &MBuffer, side: u32) -> Result<u64> {
    let bytes = mbuffer_bytes(view, side);
    write_atomically(file, &bytes)?;
    Ok(bytes.len() as u64)
}

/// Returns the bytes of the file of a view of `side` columns and rows.
pub fn mbuffer_bytes(view: &MBuffer, side: u32) -> Vec<u8> {
    let of = |bytes: &mut dyn FnMut(&MSample, &mut Vec<u8>)| {
        let mut stream = Vec::with_capacity(3 * view.samples.len());
        view.samples.iter().for_each(|sample| bytes(sample, &mut stream));
        deflated(&stream)
    };
    let streams = [
        deflated(&view.counts),
        of(&mut |sample, stream| stream.extend(sample.depth.to_le_bytes())),
        of(&mut |sample, stream| stream.extend(sample.colour)),
        of(&mut |sample, stream| stream.extend(sample.normal.0.to_le_bytes())),
        of(&mut |sample, stream| stream.extend(sample.mask.to_le_bytes())),
    ];
    let header = Header {
        format: FORMAT.into(),
        version: VERSION,
        side,
        samples: view.samples.len() as u64,
        streams: streams.each_ref().map(|stream| stream.len() as u64),
    };
    let mut bytes = serde_json::to_vec(&header).expect("plain data is JSON");
    bytes.push(b'\n');
    streams.iter().for_each(|stream| bytes.extend(stream));
    bytes
}

/// Reads a view of `side` columns and rows.
///
/// # Errors
/// [`Error::Input`] for what is no such view; [`Error::Io`].
pub fn read_mbuffer(file: &Path, side: u32) -> Result<MBuffer> {
    let bytes = std::fs::read(file).map_err(Error::io(file, "read it"))?;
    parse_mbuffer(file, &bytes, side)
}

/// Reads a view of `side` columns and rows from the bytes of a file.
///
/// # Errors
/// [`Error::Input`] for what is no such view.
pub fn parse_mbuffer(file: &Path, bytes: &[u8], side: u32) -> Result<MBuffer> {
    parsed(bytes, side).map_err(|(place, found)| Error::input(file, place, found, REMEDY))
}

fn parsed(bytes: &[u8], side: u32) -> Result<MBuffer, Fault> {
    let (header, mut rest) = header(bytes)?;
    if header.side != side {
        return Err(("side", format!("{} columns and rows, expected {side} as in images.json", header.side)));
    }
    let pixels = u64::from(side) * u64::from(side);
    let mut stream = |index: usize, wanted: u64| {
        let place = ["counts", "depths", "colours", "normals", "masks"][index];
        let length = header.streams[index];
        let cut = || (place, format!("the file ends within its {length} bytes; it was cut short"));
        let (packed, left) =
            usize::try_from(length).ok().and_then(|length| rest.split_at_checked(length)).ok_or_else(cut)?;
        rest = left;
        inflated(packed, wanted).map_err(|found| (place, found))
    };
    let counts = stream(0, pixels)?;
    let sum: u64 = counts.iter().map(|count| u64::from(*count)).sum();
    if sum != header.samples {
        return Err(("counts", format!("{sum} samples, expected {} as in the first line", header.samples)));
    }
    let mut of = |index: usize| stream(index, BYTES[index - 1] * header.samples);
    let (depths, colours, normals, masks) = (of(1)?, of(2)?, of(3)?, of(4)?);
    if !rest.is_empty() {
        return Err(("", format!("{} bytes after the last mask, expected none", rest.len())));
    }
    let word = |[low, high]: [u8; 2]| u16::from_le_bytes([low, high]);
    let words =
        |bytes: &[u8]| bytes.as_chunks::<2>().0.iter().map(|bytes| word(*bytes)).collect::<Vec<u16>>();
    let (depths, normals, masks) = (words(&depths), words(&normals), words(&masks));
    if depths.contains(&0) || masks.contains(&0) {
        return Err(("depths", "a depth or a mask of 0, expected at least 1".into()));
    }
    let colours = colours.as_chunks::<3>().0;
    let sample = |index: usize| MSample {
        depth: depths[index],
        colour: colours[index],
        normal: NormalCode(normals[index]),
        mask: masks[index],
    };
    Ok(MBuffer { samples: (0..depths.len()).map(sample).collect(), counts })
}

/// Reads the first line; returns it with what follows.
fn header(bytes: &[u8]) -> Result<(Header, &[u8]), Fault> {
    let (header, rest): (Header, &[u8]) = first_line(bytes)?;
    if header.format != FORMAT || header.version != VERSION {
        let found =
            format!("{:?} version {}, expected {FORMAT:?} version {VERSION}", header.format, header.version);
        return Err(("format", found));
    }
    if !(1..=MOST_SIDE).contains(&header.side) {
        return Err(("side", format!("{} columns and rows, expected 1 to {MOST_SIDE}", header.side)));
    }
    Ok((header, rest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    fn any_view(rng: &mut Rng, side: u32) -> MBuffer {
        let counts: Vec<u8> = (0..side * side).map(|_| rng.between(0.0, 3.9) as u8).collect();
        let count: usize = counts.iter().map(|count| usize::from(*count)).sum();
        let samples = (0..count).map(|_| MSample {
            depth: (rng.bits() as u16).max(1),
            colour: [rng.bits() as u8, rng.bits() as u8, rng.bits() as u8],
            normal: NormalCode(rng.bits() as u16),
            mask: (rng.bits() as u16).max(1),
        });
        MBuffer { samples: samples.collect(), counts }
    }

    fn written(view: &MBuffer, side: u32) -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("view.mb");
        let size = write_mbuffer(&file, view, side).unwrap();
        let bytes = std::fs::read(file).unwrap();
        assert_eq!(bytes.len() as u64, size);
        bytes
    }

    #[test]
    fn what_is_read_is_what_was_written() {
        let mut rng = Rng::new(20);
        for side in [1, 2, 7, 24] {
            let view = any_view(&mut rng, side);
            assert_eq!(parsed(&written(&view, side), side), Ok(view));
        }
    }

    #[test]
    fn a_file_that_was_cut_short_or_changed_is_refused_or_another_view_and_never_a_panic() {
        let mut rng = Rng::new(21);
        let view = any_view(&mut rng, 9);
        let bytes = written(&view, 9);
        for end in 0..bytes.len() {
            let (_, found) = parsed(&bytes[..end], 9).unwrap_err();
            assert!(!found.is_empty());
        }
        for at in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[at] ^= 1 << (at % 8);
            if let Ok(other) = parsed(&changed, 9) {
                assert_eq!((other.counts.len(), other.samples.iter().any(|s| s.mask == 0)), (81, false));
            }
        }
    }

    #[test]
    fn a_small_file_that_says_it_is_large_takes_no_memory() {
        let line = r#"{"format":"quadratura-mbuffer","version":1,"side":16384,"samples":900000000,"streams":[9,9,9,9,9]}"#;
        let bytes = [line.as_bytes(), b"\n", &[7; 45]].concat();
        let (place, found) = parsed(&bytes, 16384).unwrap_err();
        assert!(place == "counts" && found.contains("cannot hold"), "{place}: {found}");
    }
}
