//! Reads and writes `cache/relief.bin`: the relief of a site's faces, derived (see `docs/formats.md`).
//!
//! One line of JSON describes the file; after a line feed follow the heights of all faces as 32-bit floats,
//! little-endian, face after face.

use std::path::Path;

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::polygon::PlaneFrame;
use quadratura_files::atomic::write_atomically;
use quadratura_projection::relief::{FaceRelief, Relief};

/// The version that this program writes; it reads no other.
const VERSION: u32 = 1;

/// The first line of the file.
#[derive(Debug, Serialize, Deserialize)]
struct ReliefHeader {
    version: u32,
    /// Hash of everything that the relief was computed from.
    inputs: String,
    /// Number of faces in the model.
    faces: u32,
    reliefs: Vec<ReliefEntry>,
}

#[derive(Debug, Serialize, Deserialize)]
struct ReliefEntry {
    face: u32,
    origin: [f64; 3],
    u: [f64; 3],
    v: [f64; 3],
    low: [f64; 2],
    cell: f64,
    size: [u32; 2],
}

/// Writes the relief; `inputs` is the hash of everything that it was computed from.
///
/// # Errors
/// [`Error::Io`].
pub fn write_relief(file: &Path, relief: &Relief, inputs: &str) -> Result<()> {
    let reliefs_of_faces = || (0..).zip(&relief.of_face).filter_map(|(face, r)| Some((face, r.as_ref()?)));
    let reliefs = reliefs_of_faces().map(|(face, r)| entry(face, r)).collect();
    let faces = relief.of_face.len() as u32;
    let header = ReliefHeader { version: VERSION, inputs: inputs.to_owned(), faces, reliefs };
    let mut bytes = serde_json::to_vec(&header).expect("plain data is JSON");
    bytes.push(b'\n');
    for (_, relief) in reliefs_of_faces() {
        bytes.extend(relief.heights.iter().flat_map(|h| h.to_le_bytes()));
    }
    let folder = file.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
    write_atomically(file, &bytes)
}

/// Returns the relief in a file if it was computed from `inputs`, a hash as in [`write_relief`]. A file that is
/// missing, damaged, of another version or of other inputs gives `None`, and the caller has to compute the relief.
pub fn read_relief(file: &Path, inputs: &str) -> Option<Relief> {
    let bytes = std::fs::read(file).ok()?;
    let line = bytes.iter().position(|&b| b == b'\n')?;
    let header: ReliefHeader = serde_json::from_slice(&bytes[..line]).ok()?;
    if header.version != VERSION || header.inputs != inputs {
        return None;
    }
    let mut heights = bytes[line + 1..].chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let mut relief = Relief { of_face: vec![None; header.faces as usize] };
    for entry in header.reliefs {
        let count = entry.size[0] as usize * entry.size[1] as usize;
        let values: Vec<f32> = heights.by_ref().take(count).filter(|h| h.is_finite()).collect();
        if values.len() != count || count == 0 {
            return None;
        }
        *relief.of_face.get_mut(entry.face as usize)? = Some(relief_of(&entry, values));
    }
    Some(relief)
}

fn entry(face: u32, relief: &FaceRelief) -> ReliefEntry {
    let FaceRelief { frame, low, cell, size, .. } = relief;
    ReliefEntry {
        face,
        origin: frame.origin.to_array(),
        u: frame.u.to_array(),
        v: frame.v.to_array(),
        low: low.to_array(),
        cell: *cell,
        size: *size,
    }
}

fn relief_of(entry: &ReliefEntry, heights: Vec<f32>) -> FaceRelief {
    let [origin, u, v] = [entry.origin, entry.u, entry.v].map(DVec3::from);
    let frame = PlaneFrame { origin, u, v };
    FaceRelief { frame, low: DVec2::from(entry.low), cell: entry.cell, size: entry.size, heights }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn invented() -> Relief {
        let frame = PlaneFrame { origin: DVec3::new(1.0, 2.0, 3.0), u: DVec3::X, v: DVec3::Z };
        let face = FaceRelief {
            frame,
            low: DVec2::new(-0.1, 1.0 / 3.0),
            cell: 0.07,
            size: [3, 2],
            heights: vec![0.0, 0.1, -0.2, 1e-3, 5.0, -0.0],
        };
        Relief { of_face: vec![None, Some(face), None] }
    }

    #[test]
    fn a_relief_comes_back_as_it_was_and_only_for_what_it_was_made_of() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("cache/relief.bin");
        write_relief(&file, &invented(), "abc").unwrap();
        assert_eq!(read_relief(&file, "abc"), Some(invented()));
        assert_eq!(read_relief(&file, "abd"), None);
    }

    #[test]
    fn a_broken_relief_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("relief.bin");
        write_relief(&file, &invented(), "abc").unwrap();
        let bytes = std::fs::read(&file).unwrap();
        for length in [0, 10, bytes.len() - 5] {
            std::fs::write(&file, &bytes[..length]).unwrap();
            assert_eq!(read_relief(&file, "abc"), None, "{length} bytes");
        }
        let mut wrong = bytes.clone();
        let last = wrong.len() - 4;
        wrong[last..].copy_from_slice(&f32::NAN.to_le_bytes());
        std::fs::write(&file, &wrong).unwrap();
        assert_eq!(read_relief(&file, "abc"), None);
    }
}
