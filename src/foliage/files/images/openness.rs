//! How open a plant's crown is (`HASH.openness`): a line of JSON, then for each cell of the grid the mean and the vector, then how open
//! it is in each direction; both deflated.

use std::path::Path;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::Openness;
use crate::directions::DIRECTIONS;
use quadratura_base::error::{Error, Result};
use quadratura_files::atomic::write_atomically;
use quadratura_files::deflated::{Fault, deflated, first_line, inflated};

/// The value of `format`.
const FORMAT: &str = "quadratura-openness";
/// The version that this program writes; it reads no other.
const VERSION: u32 = 1;
/// The most cells along an axis.
const MOST_CELLS: u32 = 32;
/// What to do about a damaged file.
const REMEDY: &str = "remove the file, so that it is made again";

/// The first line of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct OpennessHeader {
    format: String,
    version: u32,
    /// Hash of everything that it was made of.
    inputs: String,
    /// The corner of the grid with the smallest coordinates, in the plant's frame.
    low: [f64; 3],
    /// The side of a cell.
    cell: f64,
    /// The number of cells along x, y and z.
    size: [u32; 3],
    /// Bytes of both arrays as they follow.
    streams: [u64; 2],
}

/// Writes the openness of a plant. `inputs` is the hash of the plant.
///
/// # Errors
/// [`Error::Io`].
pub fn write_openness(file: &Path, openness: &Openness, inputs: &str) -> Result<()> {
    let values: Vec<u8> = openness.values().iter().flatten().map(|value| value.cast_unsigned()).collect();
    let streams = [deflated(&values), deflated(openness.open().as_flattened())];
    let (low, cell, size) = openness.grid();
    let header = OpennessHeader {
        format: FORMAT.into(),
        version: VERSION,
        inputs: inputs.into(),
        low: low.to_array(),
        cell,
        size,
        streams: streams.each_ref().map(|stream| stream.len() as u64),
    };
    let mut bytes = serde_json::to_vec(&header).expect("plain data is JSON");
    bytes.push(b'\n');
    streams.iter().for_each(|stream| bytes.extend(stream));
    write_atomically(file, &bytes)
}

/// Reads the openness of the plant whose hash is `inputs`; `None` where the file is of another one, or there is none.
///
/// # Errors
/// [`Error::Input`] for a damaged file; [`Error::Io`].
pub fn read_openness(file: &Path, inputs: &str) -> Result<Option<Openness>> {
    if !file.exists() {
        return Ok(None);
    }
    let bytes = std::fs::read(file).map_err(Error::io(file, "read it"))?;
    parsed(&bytes, inputs).map_err(|(place, found)| Error::input(file, place, found, REMEDY))
}

fn parsed(bytes: &[u8], inputs: &str) -> Result<Option<Openness>, Fault> {
    let (header, rest): (OpennessHeader, &[u8]) = first_line(bytes)?;
    if header.format != FORMAT || header.version != VERSION || header.inputs != inputs {
        return Ok(None);
    }
    if header.size.iter().any(|count| !(1..=MOST_CELLS).contains(count)) {
        return Err(("size", format!("{:?} cells, expected 1 to {MOST_CELLS} along each axis", header.size)));
    }
    let cells = header.size.iter().map(|count| u64::from(*count)).product::<u64>();
    let cut = || ("streams", "the file is not as long as it says; it was cut short or added to".to_owned());
    let first = usize::try_from(header.streams[0]).map_err(|_| cut())?;
    let (values, open) = rest.split_at_checked(first).ok_or_else(cut)?;
    if open.len() as u64 != header.streams[1] {
        return Err(cut());
    }
    let inflated = |place, packed, wanted| inflated(packed, wanted).map_err(|found| (place, found));
    let values = inflated("values", values, 4 * cells)?;
    let open = inflated("open", open, DIRECTIONS as u64 * cells)?;
    let values = values.as_chunks::<4>().0.iter().map(|cell| cell.map(u8::cast_signed)).collect();
    let low = DVec3::from_array(header.low);
    let openness = Openness::of(low, header.cell, header.size, values, open.as_chunks().0.to_vec());
    openness.map(Some).ok_or_else(|| {
        ("cell", format!("cells of {} at {:?}, expected numbers above 0", header.cell, header.low))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::bushy;
    use quadratura_base::task::Task;

    #[test]
    fn openness_comes_back_and_what_is_damaged_is_refused_or_made_again() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("bush.openness");
        let openness = Openness::bake(&bushy(), &Task::silent()).unwrap();
        assert_eq!(read_openness(&file, "a").unwrap(), None);
        write_openness(&file, &openness, "a").unwrap();
        assert_eq!(read_openness(&file, "b").unwrap(), None, "of another plant");
        assert!(read_openness(&file, "a").unwrap() == Some(openness));
        let bytes = std::fs::read(&file).unwrap();
        for length in [0, 10, bytes.len() - 1] {
            std::fs::write(&file, &bytes[..length]).unwrap();
            let error = read_openness(&file, "a").unwrap_err().to_string();
            assert!(error.contains("bush.openness") && error.contains("made again"), "{error}");
        }
        for at in (0..bytes.len()).step_by(bytes.len() / 97) {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x55;
            std::fs::write(&file, &damaged).unwrap();
            // Nothing is read that was not there, and nothing breaks.
            drop(read_openness(&file, "a"));
        }
    }
}
