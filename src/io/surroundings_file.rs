//! Reads and writes `cache/surroundings.bin`: how far photos confirm each other's surroundings, and the dome, derived
//! (see `docs/formats.md`).
//!
//! One line of JSON describes the file. After a line feed follow the contradicted pixels, photo after photo, 5 bytes
//! each: column and row (16 bits, little-endian) and the agreement (8 bits); then, where there is a dome, an RGBA
//! PNG of its six sides below each other, with how well each direction is known as alpha.

use std::io::Cursor;
use std::path::Path;

use png::{BitDepth, ColorType, Compression, Decoder, Encoder};
use serde::{Deserialize, Serialize};

use super::atomic::write_atomically;
use crate::error::{Error, Result};
use crate::projection::agreement::{ContradictedPixel, PhotoAgreement};
use crate::projection::dome::{Dome, SIDES};
use crate::scene::FaceId;

/// The version that this program writes; it reads no other.
const VERSION: u32 = 1;

/// The number of bytes of a pixel.
const PIXEL: usize = 5;

/// Stands for the face of pixels that show none.
const NO_FACE: FaceId = FaceId(u32::MAX);

/// The first line of the file.
#[derive(Debug, Serialize, Deserialize)]
struct Header {
    version: u32,
    /// Hash of everything that the content was computed from.
    inputs: String,
    photos: Vec<PhotoEntry>,
    /// The side of the dome's cube in pixels; 0 without a dome.
    side: u32,
}

#[derive(Debug, Serialize, Deserialize)]
struct PhotoEntry {
    size: [u32; 2],
    contradicted: usize,
}

/// Writes the agreement of all photos and the dome; `inputs` is the hash of everything that they were computed from.
///
/// # Errors
/// [`Error::Io`].
pub fn write_surroundings(
    file: &Path,
    agreement: &[PhotoAgreement],
    dome: Option<&Dome>,
    inputs: &str,
) -> Result<()> {
    let entry =
        |photo: &PhotoAgreement| PhotoEntry { size: photo.size, contradicted: photo.contradicted.len() };
    let photos = agreement.iter().map(entry).collect();
    let side = dome.map_or(0, |dome| dome.side);
    let header = Header { version: VERSION, inputs: inputs.to_owned(), photos, side };
    let mut bytes = serde_json::to_vec(&header).expect("plain data is JSON");
    bytes.push(b'\n');
    for pixel in agreement.iter().flat_map(|photo| &photo.contradicted) {
        bytes.extend(pixel.at.iter().flat_map(|at| at.to_le_bytes()));
        bytes.push(pixel.agreement);
    }
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

/// Returns the content of a file if it was computed from `inputs`. A file that is missing, damaged, of another
/// version or of other inputs gives `None`, and the caller has to compute it.
pub fn read_surroundings(file: &Path, inputs: &str) -> Option<(Vec<PhotoAgreement>, Option<Dome>)> {
    let bytes = std::fs::read(file).ok()?;
    let line = bytes.iter().position(|&b| b == b'\n')?;
    let header: Header = serde_json::from_slice(&bytes[..line]).ok()?;
    if header.version != VERSION || header.inputs != inputs {
        return None;
    }
    let mut rest = &bytes[line + 1..];
    let mut photos = Vec::with_capacity(header.photos.len());
    for PhotoEntry { size, contradicted } in header.photos {
        let (own, others) = rest.split_at_checked(contradicted.checked_mul(PIXEL)?)?;
        rest = others;
        let contradicted: Vec<ContradictedPixel> = own.as_chunks::<PIXEL>().0.iter().map(pixel).collect();
        let is_sound = |pixel: &ContradictedPixel| {
            (0..2).all(|i| u32::from(pixel.at[i]) < size[i]) && pixel.agreement > 0
        };
        if !contradicted.iter().all(is_sound) {
            return None;
        }
        photos.push(PhotoAgreement { size, contradicted, beside: Vec::new() });
    }
    match header.side {
        0 => rest.is_empty().then_some((photos, None)),
        side => Some((photos, Some(dome(rest, side)?))),
    }
}

fn pixel(bytes: &[u8; PIXEL]) -> ContradictedPixel {
    let [x0, x1, y0, y1, agreement] = *bytes;
    let at = [[x0, x1], [y0, y1]].map(u16::from_le_bytes);
    ContradictedPixel { at, face: NO_FACE, agreement }
}

/// Decodes a dome of this side; `None` where the bytes are of no such picture.
fn dome(bytes: &[u8], side: u32) -> Option<Dome> {
    let mut reader = Decoder::new(Cursor::new(bytes)).read_info().ok()?;
    let info = reader.info();
    let height = side.checked_mul(SIDES as u32)?;
    let is_rgba = (info.color_type, info.bit_depth) == (ColorType::Rgba, BitDepth::Eight);
    if !is_rgba || (info.width, info.height) != (side, height) {
        return None;
    }
    let mut texels = vec![[0; 4]; side as usize * height as usize];
    reader.next_frame(texels.as_flattened_mut()).ok()?;
    Some(Dome { side, texels })
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
        let photos = vec![photo(vec![at(3, 2, 26), at(8, 6, 254)]), photo(Vec::new())];
        let texels = (0..6 * 4).map(|i| [i as u8, 2, 3, 255 - i as u8]).collect();
        for dome in [None, Some(Dome { side: 2, texels })] {
            write_surroundings(&file, &photos, dome.as_ref(), "abc").unwrap();
            assert_eq!(read_surroundings(&file, "abc"), Some((photos.clone(), dome)));
            assert_eq!(read_surroundings(&file, "abd"), None);
        }
        let bytes = std::fs::read(&file).unwrap();
        for length in [0, 20, bytes.len() / 2, bytes.len() - 20] {
            std::fs::write(&file, &bytes[..length]).unwrap();
            assert_eq!(read_surroundings(&file, "abc"), None, "{length} of {} bytes", bytes.len());
        }
    }
}
