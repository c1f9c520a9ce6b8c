//! Reads and writes `cache/mattes/<photo>.bin`: the mattes of a photo, derived (see `docs/formats.md`).
//!
//! One line of JSON describes the file. After a line feed follow two PNGs per object: the object's own colour with the
//! matte as alpha (RGBA), and what is known of each pixel (grey: 0 the photo does not show the object's surface, 1 nothing
//! is known, 2 found, 3 solved from the pixels around).

use std::io::Cursor;
use std::path::{Path, PathBuf};

use png::{BitDepth, ColorType, Compression, Decoder, Encoder};
use serde::{Deserialize, Serialize};

use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::Image;
use quadratura_document::names::file_name_of_photo;
use quadratura_files::atomic::write_atomically;
use quadratura_layers::matte::{Known, Matte};

/// The version that this program writes; it reads no other.
const VERSION: u32 = 2;

/// The first line of the file.
#[derive(Debug, Serialize, Deserialize)]
struct MatteHeader {
    version: u32,
    /// Hash of everything that the mattes were computed from.
    inputs: String,
    mattes: Vec<MatteEntry>,
}

#[derive(Debug, Serialize, Deserialize)]
struct MatteEntry {
    object: String,
    /// Column and row of the upper left pixel in the photo, width and height.
    rect: [u32; 4],
    /// The lengths of the two PNGs.
    bytes: [usize; 2],
}

/// Returns the file of a photo's mattes in a project's folder.
pub fn matte_file(project: &Path, photo: &str) -> PathBuf {
    project.join("cache").join("mattes").join(format!("{}.bin", file_name_of_photo(photo)))
}

/// Writes the mattes of a photo; `inputs` is the hash of everything that they were computed from.
///
/// # Errors
/// [`Error::Io`].
pub fn write_mattes(file: &Path, mattes: &[Matte], inputs: &str) -> Result<()> {
    let mut pictures = Vec::new();
    let entry = |matte: &Matte| {
        let rect = matte.texels.rect();
        let known: Vec<u8> = matte.known.pixels().iter().map(|known| *known as u8).collect();
        let colours = encoded(rect, ColorType::Rgba, matte.texels.pixels().as_flattened());
        let known = encoded(rect, ColorType::Grayscale, &known);
        let bytes = [colours.len(), known.len()];
        pictures.extend([colours, known]);
        MatteEntry {
            object: matte.object.clone(),
            rect: [rect.x as u32, rect.y as u32, rect.w, rect.h],
            bytes,
        }
    };
    let mattes = mattes.iter().map(entry).collect();
    let header = MatteHeader { version: VERSION, inputs: inputs.to_owned(), mattes };
    let mut bytes = serde_json::to_vec(&header).expect("plain data is JSON");
    bytes.push(b'\n');
    pictures.iter().for_each(|picture| bytes.extend_from_slice(picture));
    let folder = file.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
    write_atomically(file, &bytes)
}

/// Returns the mattes in a file if they were computed from `inputs`. A file that is missing, damaged, of another
/// version or of other inputs gives `None`, and the caller has to compute them.
pub fn read_mattes(file: &Path, inputs: &str) -> Option<Vec<Matte>> {
    let bytes = std::fs::read(file).ok()?;
    let line = bytes.iter().position(|&b| b == b'\n')?;
    let header: MatteHeader = serde_json::from_slice(&bytes[..line]).ok()?;
    if header.version != VERSION || header.inputs != inputs {
        return None;
    }
    let mut rest = &bytes[line + 1..];
    let mut mattes = Vec::with_capacity(header.mattes.len());
    for MatteEntry { object, rect: [x, y, w, h], bytes: [colours, known] } in header.mattes {
        let rect = PixelRect { x: i32::try_from(x).ok()?, y: i32::try_from(y).ok()?, w, h };
        let (own, others) = rest.split_at_checked(colours)?;
        let texels = decoded(own, rect, ColorType::Rgba)?.as_chunks::<4>().0.to_vec();
        let (own, others) = others.split_at_checked(known)?;
        let known = decoded(own, rect, ColorType::Grayscale)?;
        let known: Vec<Known> = known.into_iter().map(state).collect::<Option<_>>()?;
        mattes.push(Matte { object, texels: Image::new(rect, texels), known: Image::new(rect, known) });
        rest = others;
    }
    rest.is_empty().then_some(mattes)
}

fn state(value: u8) -> Option<Known> {
    let all = [Known::NotShown, Known::Unknown, Known::Found, Known::Solved];
    all.into_iter().find(|known| *known as u8 == value)
}

fn encoded(rect: PixelRect, colours: ColorType, samples: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, rect.w, rect.h);
    encoder.set_color(colours);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Fast);
    let encode = encoder.write_header().and_then(|mut writer| {
        writer.write_image_data(samples)?;
        writer.finish()
    });
    encode.expect("memory takes every byte, and the size fits");
    bytes
}

/// Decodes a picture of this size and kind; `None` where the bytes are of no such picture.
fn decoded(bytes: &[u8], rect: PixelRect, colours: ColorType) -> Option<Vec<u8>> {
    let mut reader = Decoder::new(Cursor::new(bytes)).read_info().ok()?;
    let info = reader.info();
    let is_such = (info.color_type, info.bit_depth) == (colours, BitDepth::Eight);
    if !is_such || (info.width, info.height) != (rect.w, rect.h) {
        return None;
    }
    let mut samples = vec![0; rect.area() as usize * colours.samples()];
    reader.next_frame(&mut samples).ok()?;
    Some(samples)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_is_read_for_the_same_inputs_alone_and_damage_is_as_good_as_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let file = matte_file(folder.path(), "day 1/a.jpg");
        let matte = |object: &str, x, y, w, h| {
            let rect = PixelRect { x, y, w, h };
            let texels = Image::from_fn(rect, |(x, y)| [x as u8, y as u8, 7, (x * y) as u8]);
            let known = Image::from_fn(rect, |(x, y)| state(((x + y) % 4) as u8).unwrap());
            Matte { object: object.to_owned(), texels, known }
        };
        for mattes in [vec![], vec![matte("tree", 3, 0, 5, 4), matte("a \"hedge\"\n", 0, 9, 1, 1)]] {
            write_mattes(&file, &mattes, "abc").unwrap();
            assert_eq!(read_mattes(&file, "abc"), Some(mattes));
            assert_eq!(read_mattes(&file, "abd"), None);
        }
        let bytes = std::fs::read(&file).unwrap();
        for length in [0, 20, bytes.len() / 2, bytes.len() - 1] {
            std::fs::write(&file, &bytes[..length]).unwrap();
            assert_eq!(read_mattes(&file, "abc"), None, "{length} of {} bytes", bytes.len());
        }
    }
}
