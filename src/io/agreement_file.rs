//! Reads and writes `cache/agreement.bin`: how far a site's photos confirm each other, derived (see `docs/formats.md`).
//!
//! One line of JSON describes the file; after a line feed follow the contradicted pixels of all photos, those beside
//! them, and in the same way what is sky within outlines, photo after photo, 9 bytes each: column and row (16 bits), the face (32 bits), and the agreement (8 bits), little-endian.

use std::path::Path;

use serde::{Deserialize, Serialize};

use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::Spans;
use quadratura_base::scene::FaceId;
use quadratura_files::atomic::write_atomically;
use quadratura_layers::agreement::{PhotoEvidence, Thing};
use quadratura_view::agreement::{ContradictedPixel, NO_FACE, PhotoAgreement};

/// The version that this program writes; it reads no other.
const VERSION: u32 = 4;

/// The number of bytes of a pixel.
const PIXEL: usize = 9;

/// The first line of the file.
#[derive(Debug, Serialize, Deserialize)]
struct AgreementHeader {
    version: u32,
    /// Hash of everything that the agreement was computed from.
    inputs: String,
    photos: Vec<PhotoEntry>,
}

#[derive(Debug, Serialize, Deserialize)]
struct PhotoEntry {
    size: [u32; 2],
    /// The number of contradicted pixels.
    contradicted: usize,
    /// The number of pixels beside them.
    beside: usize,
    /// The same of its outlines.
    outlines: [usize; 2],
    /// See [`PhotoEvidence::undecided`].
    undecided: f64,
    things: Vec<ThingEntry>,
}

#[derive(Debug, Serialize, Deserialize)]
struct ThingEntry {
    distance: f32,
    likelihood: f32,
    is_light: bool,
    /// Row, first column, and one past the last column of each run, by row, then column.
    runs: Vec<[i32; 3]>,
}

/// Writes the evidence of all photos; `inputs` is the hash of everything that it was computed from.
///
/// # Errors
/// [`Error::Io`].
pub fn write_agreement(file: &Path, photos: &[PhotoEvidence], inputs: &str) -> Result<()> {
    let header = AgreementHeader {
        version: VERSION,
        inputs: inputs.to_owned(),
        photos: photos.iter().map(entry).collect(),
    };
    let mut bytes = serde_json::to_vec(&header).expect("plain data is JSON");
    bytes.push(b'\n');
    let both = |photo: &'_ PhotoEvidence| [photo.agreement.clone(), photo.outlines.clone()];
    for pixel in photos.iter().flat_map(both).flat_map(|of| [of.contradicted, of.beside].concat()) {
        bytes.extend(pixel.at.iter().flat_map(|at| at.to_le_bytes()));
        bytes.extend(pixel.face.0.to_le_bytes());
        bytes.push(pixel.agreement);
    }
    let folder = file.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
    write_atomically(file, &bytes)
}

/// Returns the evidence in a file if it was computed from `inputs`, a hash as in [`write_agreement`]. A file that is
/// missing, damaged, of another version, of other inputs or of a model without `faces` faces gives `None`, and the caller
/// has to compute it.
pub fn read_agreement(file: &Path, inputs: &str, faces: usize) -> Option<Vec<PhotoEvidence>> {
    let bytes = std::fs::read(file).ok()?;
    let line = bytes.iter().position(|&b| b == b'\n')?;
    let header: AgreementHeader = serde_json::from_slice(&bytes[..line]).ok()?;
    if header.version != VERSION || header.inputs != inputs {
        return None;
    }
    let (mut pixels, rest) = bytes[line + 1..].as_chunks::<PIXEL>();
    let mut counts = header
        .photos
        .iter()
        .flat_map(|photo| [photo.contradicted, photo.beside, photo.outlines[0], photo.outlines[1]]);
    let counted = counts.try_fold(0usize, usize::checked_add);
    if counted != Some(pixels.len()) || !rest.is_empty() {
        return None;
    }
    let mut photos = Vec::with_capacity(header.photos.len());
    for PhotoEntry { size, contradicted, beside, outlines, undecided, things } in header.photos {
        let is_sound = |pixel: &ContradictedPixel| {
            let inside = (0..2).all(|i| u32::from(pixel.at[i]) < size[i]);
            let is_face = (pixel.face.0 as usize) < faces || pixel.face == NO_FACE;
            inside && is_face && pixel.agreement > 0
        };
        let mut next = |counts: [usize; 2]| {
            let [contradicted, beside] = counts.map(|count| {
                let own;
                (own, pixels) = pixels.split_at(count);
                own.iter().map(pixel).collect::<Vec<ContradictedPixel>>()
            });
            let are_sound = contradicted.iter().chain(&beside).all(is_sound);
            are_sound.then_some(PhotoAgreement { size, contradicted, beside })
        };
        let (agreement, outlines) = (next([contradicted, beside])?, next(outlines)?);
        let things = things.into_iter().map(|entry| thing(entry, size)).collect::<Option<_>>()?;
        photos.push(PhotoEvidence { agreement, outlines, things, undecided });
    }
    Some(photos)
}

fn entry(photo: &PhotoEvidence) -> PhotoEntry {
    let thing = |thing: &Thing| ThingEntry {
        distance: thing.distance,
        likelihood: thing.likelihood,
        is_light: thing.is_light,
        runs: thing.pixels.iter().map(|(y, run)| [y, run.start, run.end]).collect(),
    };
    PhotoEntry {
        size: photo.agreement.size,
        contradicted: photo.agreement.contradicted.len(),
        beside: photo.agreement.beside.len(),
        outlines: [photo.outlines.contradicted.len(), photo.outlines.beside.len()],
        undecided: photo.undecided,
        things: photo.things.iter().map(thing).collect(),
    }
}

/// Returns the thing of an entry; `None` where it lies outside the reduced photo or its runs are not in order.
fn thing(entry: ThingEntry, [width, height]: [u32; 2]) -> Option<Thing> {
    let inside = |[y, from, to]: &[i32; 3]| {
        (0..height as i32).contains(y) && *from >= 0 && from < to && *to <= width as i32
    };
    let in_order = entry.runs.is_sorted_by(|a, b| (a[0], a[2]) < (b[0], b[1]));
    if !in_order || !entry.runs.iter().all(inside) {
        return None;
    }
    let first = entry.runs.first().map_or(0, |[y, ..]| *y);
    let last = entry.runs.last().map_or(first, |[y, ..]| *y + 1);
    let mut runs = entry.runs.iter().peekable();
    let pixels = Spans::from_rows(first..last, |y, out| {
        while let Some(run) = runs.next_if(|run| run[0] == y) {
            out.push(run[1]..run[2]);
        }
    });
    let ThingEntry { distance, likelihood, is_light, .. } = entry;
    Some(Thing { pixels, distance, likelihood, is_light })
}

fn pixel(&[x0, x1, y0, y1, a, b, c, d, agreement]: &[u8; PIXEL]) -> ContradictedPixel {
    ContradictedPixel {
        at: [u16::from_le_bytes([x0, x1]), u16::from_le_bytes([y0, y1])],
        face: FaceId(u32::from_le_bytes([a, b, c, d])),
        agreement,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::geometry::PixelRect;

    fn invented() -> Vec<PhotoEvidence> {
        let pixel =
            |x: u16, y: u16| ContradictedPixel { at: [x, y], face: FaceId(700 + u32::from(x)), agreement: 3 };
        let pixels = Spans::of_pixels(PixelRect { x: 2, y: 3, w: 5, h: 4 }, |x, y| (x + y) % 3 > 0);
        let contradicted = vec![pixel(2, 3), pixel(8, 399)];
        let agreement = PhotoAgreement { size: [9, 400], contradicted, beside: vec![pixel(7, 398)] };
        let outlines =
            PhotoAgreement { size: [9, 400], contradicted: vec![pixel(5, 7)], beside: vec![pixel(6, 7)] };
        let things = vec![Thing { pixels, distance: 0.75, likelihood: 0.5, is_light: false }];
        vec![PhotoEvidence::default(), PhotoEvidence { agreement, outlines, things, undecided: 0.25 }]
    }

    #[test]
    fn evidence_comes_back_as_it_was_and_only_for_what_it_was_made_of() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("cache/agreement.bin");
        write_agreement(&file, &invented(), "abc").unwrap();
        assert_eq!(read_agreement(&file, "abc", 800), Some(invented()));
        assert_eq!(read_agreement(&file, "abd", 800), None);
        assert_eq!(read_agreement(&file, "abc", 705), None, "a face that the model does not have");
    }

    #[test]
    fn a_damaged_file_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("agreement.bin");
        write_agreement(&file, &invented(), "abc").unwrap();
        let bytes = std::fs::read(&file).unwrap();
        for length in [0, 10, bytes.len() - 5, bytes.len() - PIXEL] {
            std::fs::write(&file, &bytes[..length]).unwrap();
            assert_eq!(read_agreement(&file, "abc", 800), None, "{length} bytes");
        }
        let mut outside = bytes.clone();
        let last = outside.len() - PIXEL;
        outside[last] = 9;
        std::fs::write(&file, &outside).unwrap();
        assert_eq!(read_agreement(&file, "abc", 800), None, "a column that the photo does not have");
    }
}
