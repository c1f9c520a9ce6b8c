//! Reads and writes `cache/surroundings.bin`: how far photos confirm each other's surroundings, the factors that bring them to one
//! sky, and the dome, derived (see `docs/formats.md`).
//!
//! One line of JSON describes the file. After a line feed follow the contradicted pixels, photo after photo, 5 bytes
//! each: column and row (16 bits, little-endian) and the agreement (8 bits); then, for each photo that has them, the factors that
//! bring it to one sky, that of the whole photo and those of 32 x 32 cells, 3 logarithms each (32 bits, little-endian); then, where there is a dome, an RGBA
//! PNG of its six sides below each other, with how well each direction is known as alpha.

use std::io::Cursor;
use std::path::Path;

use png::{BitDepth, ColorType, Compression, Decoder, Encoder};
use serde::{Deserialize, Serialize};

use quadratura_base::error::{Error, Result};
use quadratura_files::atomic::write_atomically;
use quadratura_projection::dome::{BRIGHTEST, Dome, SIDES};
use quadratura_projection::exposure::surroundings::{GRID, SurroundingsFactors};
use quadratura_view::agreement::{ContradictedPixel, NO_FACE, PhotoAgreement};

/// The version that this program writes; it reads no other.
const VERSION: u32 = 2;

/// The number of bytes of a pixel.
const PIXEL: usize = 5;

/// The number of bytes of a photo's factors.
const FACTORS: usize = (1 + GRID * GRID) * 3 * size_of::<f32>();

/// The largest logarithm of a factor: larger ones are damage.
const LARGEST: f32 = 10.0;

/// What photos tell about their surroundings.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ComparedSurroundings {
    /// How far others confirm each photo's surroundings, in the site's order.
    pub agreement: Vec<PhotoAgreement>,
    /// The factors that bring each photo's surroundings to one sky, in the site's order; `None` for photos that show none.
    pub factors: Vec<Option<SurroundingsFactors>>,
    /// What is seen in every direction; `None` where no photo shows any surroundings.
    pub dome: Option<Dome>,
}

/// The first line of the file.
#[derive(Debug, Serialize, Deserialize)]
struct SurroundingsHeader {
    version: u32,
    /// Hash of everything that the content was computed from.
    inputs: String,
    photos: Vec<SurroundingsPhotoEntry>,
    /// The side of the dome's cube in pixels; 0 without a dome.
    side: u32,
    /// The light that the largest value of the dome's texels stands for.
    white: f32,
}

#[derive(Debug, Serialize, Deserialize)]
struct SurroundingsPhotoEntry {
    size: [u32; 2],
    contradicted: usize,
    /// Whether it has factors.
    factors: bool,
}

/// Writes what was compared; `inputs` is the hash of everything that it was computed from.
///
/// # Errors
/// [`Error::Io`].
pub fn write_surroundings(file: &Path, compared: &ComparedSurroundings, inputs: &str) -> Result<()> {
    let ComparedSurroundings { agreement, factors, dome } = compared;
    let entry = |(photo, factors): (&PhotoAgreement, &Option<SurroundingsFactors>)| SurroundingsPhotoEntry {
        size: photo.size,
        contradicted: photo.contradicted.len(),
        factors: factors.is_some(),
    };
    let photos = agreement.iter().zip(factors).map(entry).collect();
    let (side, white) = dome.as_ref().map_or((0, 1.0), |dome| (dome.side, dome.white));
    let header = SurroundingsHeader { version: VERSION, inputs: inputs.to_owned(), photos, side, white };
    let mut bytes = serde_json::to_vec(&header).expect("plain data is JSON");
    bytes.push(b'\n');
    for pixel in agreement.iter().flat_map(|photo| &photo.contradicted) {
        bytes.extend(pixel.at.iter().flat_map(|at| at.to_le_bytes()));
        bytes.push(pixel.agreement);
    }
    let logs = |of: &SurroundingsFactors| -> Vec<[f32; 3]> { [&[of.offset][..], &of.cells].concat() };
    let logs = factors.iter().flatten().flat_map(logs).flatten();
    bytes.extend(logs.flat_map(|log| log.to_le_bytes()));
    if let Some(dome) = dome {
        let mut encoder = Encoder::new(&mut bytes, dome.side, SIDES as u32 * dome.side);
        encoder.set_color(ColorType::Rgba);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_compression(Compression::Fast);
        let encode = encoder.write_header().and_then(|mut writer| {
            writer.write_image_data(dome.texels.as_flattened())?;
            writer.finish()
        });
        encode.expect("memory takes every byte, and the size fits");
    }
    let folder = file.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
    write_atomically(file, &bytes)
}

/// Returns the content of a file if it was computed from `inputs`, with a dome of this side if there is one. A file that is missing, damaged, of another
/// version or of other inputs gives `None`, and the caller has to compute it.
pub fn read_surroundings(file: &Path, inputs: &str, side: u32) -> Option<ComparedSurroundings> {
    let bytes = std::fs::read(file).ok()?;
    let line = bytes.iter().position(|&b| b == b'\n')?;
    let header: SurroundingsHeader = serde_json::from_slice(&bytes[..line]).ok()?;
    let is_sound = (1.0..=BRIGHTEST).contains(&header.white) && [0, side].contains(&header.side);
    if header.version != VERSION || header.inputs != inputs || !is_sound {
        return None;
    }
    let mut rest = &bytes[line + 1..];
    let mut agreement = Vec::with_capacity(header.photos.len());
    for SurroundingsPhotoEntry { size, contradicted, .. } in &header.photos {
        let size = *size;
        let (own, others) = rest.split_at_checked(contradicted.checked_mul(PIXEL)?)?;
        rest = others;
        let contradicted: Vec<ContradictedPixel> = own.as_chunks::<PIXEL>().0.iter().map(pixel).collect();
        let is_sound = |pixel: &ContradictedPixel| {
            (0..2).all(|i| u32::from(pixel.at[i]) < size[i]) && pixel.agreement > 0
        };
        if !contradicted.iter().all(is_sound) {
            return None;
        }
        agreement.push(PhotoAgreement { size, contradicted, beside: Vec::new() });
    }
    let mut factors = Vec::with_capacity(header.photos.len());
    for photo in &header.photos {
        let (own, others) = rest.split_at_checked(if photo.factors { FACTORS } else { 0 })?;
        rest = others;
        let logs: Vec<f32> = own.as_chunks::<4>().0.iter().map(|log| f32::from_le_bytes(*log)).collect();
        if !logs.iter().all(|log| log.abs() <= LARGEST) {
            return None;
        }
        let logs = logs.as_chunks::<3>().0.split_first();
        factors
            .push(logs.map(|(offset, cells)| SurroundingsFactors { offset: *offset, cells: cells.to_vec() }));
    }
    let dome = match header.side {
        0 if rest.is_empty() => None,
        0 => return None,
        side => Some(dome(rest, side, header.white)?),
    };
    Some(ComparedSurroundings { agreement, factors, dome })
}

fn pixel(bytes: &[u8; PIXEL]) -> ContradictedPixel {
    let [x0, x1, y0, y1, agreement] = *bytes;
    let at = [[x0, x1], [y0, y1]].map(u16::from_le_bytes);
    ContradictedPixel { at, face: NO_FACE, agreement }
}

/// Decodes a dome of this side; `None` where the bytes are of no such picture.
fn dome(bytes: &[u8], side: u32, white: f32) -> Option<Dome> {
    let mut reader = Decoder::new(Cursor::new(bytes)).read_info().ok()?;
    let info = reader.info();
    let height = side.checked_mul(SIDES as u32)?;
    let is_rgba = (info.color_type, info.bit_depth) == (ColorType::Rgba, BitDepth::Eight);
    if !is_rgba || (info.width, info.height) != (side, height) {
        return None;
    }
    let mut texels = vec![[0; 4]; side as usize * height as usize];
    reader.next_frame(texels.as_flattened_mut()).ok()?;
    Some(Dome { side, texels, white })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_is_read_for_the_same_inputs_alone_and_damage_is_as_good_as_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("cache/surroundings.bin");
        let at = |x, y, agreement| ContradictedPixel { at: [x, y], face: NO_FACE, agreement };
        let photo = |contradicted| PhotoAgreement { size: [9, 7], contradicted, beside: Vec::new() };
        let agreement = vec![photo(vec![at(3, 2, 26), at(8, 6, 254)]), photo(Vec::new())];
        let factors = vec![None, Some(SurroundingsFactors::constant([1.0, -0.5, 0.25]))];
        let texels = (0..6 * 4).map(|i| [i as u8, 2, 3, 255 - i as u8]).collect();
        for dome in [None, Some(Dome { side: 2, texels, white: 1.5 })] {
            let compared =
                ComparedSurroundings { agreement: agreement.clone(), factors: factors.clone(), dome };
            write_surroundings(&file, &compared, "abc").unwrap();
            assert_eq!(read_surroundings(&file, "abc", 2), Some(compared));
            assert_eq!(read_surroundings(&file, "abd", 2), None);
        }
        let bytes = std::fs::read(&file).unwrap();
        assert_eq!(read_surroundings(&file, "abc", 3), None, "a dome of another size");
        for white in ["0.5", "0", "-1", "1e300"] {
            let damaged = String::from_utf8_lossy(&bytes[..400])
                .replace("\"white\":1.5", &format!("\"white\":{white}"));
            let line = damaged.split('\n').next().unwrap().len();
            let rest = bytes.iter().position(|byte| *byte == b'\n').unwrap();
            std::fs::write(&file, [&damaged.as_bytes()[..line], &bytes[rest..]].concat()).unwrap();
            assert_eq!(read_surroundings(&file, "abc", 2), None, "{white}");
        }
        for length in [0, 20, bytes.len() / 2, bytes.len() - 20] {
            std::fs::write(&file, &bytes[..length]).unwrap();
            assert_eq!(read_surroundings(&file, "abc", 2), None, "{length} of {} bytes", bytes.len());
        }
    }
}
