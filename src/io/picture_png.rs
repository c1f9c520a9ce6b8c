//! Writes the program's pictures as PNG files that record their own hash: a text chunk holds the hash of the
//! pixels, so that pictures that were changed are recognised and never overwritten.

use std::fs::File;
use std::io::{BufReader, Write};
use std::path::{Path, PathBuf};

use png::{BitDepth, ColorType, Compression, Decoder, Encoder};

use quadratura_base::error::{Error, Result};
use quadratura_files::atomic::{remove_dead_leftovers, write_atomically_with};
use quadratura_files::hash::hash_bytes;
use quadratura_files::png_error::io_error;

/// Keyword of the text chunk.
pub(super) const MADE_BY: &str = "quadratura";
/// Limit on decoded bytes; larger pictures are not this program's.
pub(super) const MOST_BYTES: usize = 1 << 32;

/// The extension of the files.
pub const EXTENSION: &str = "png";

/// The result of writing a picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WrittenPicture {
    /// The file that was written.
    pub path: PathBuf,
    /// Files that have the picture's name, were changed or made by others, and were therefore not
    /// overwritten.
    pub spared: Vec<PathBuf>,
}

/// Writes a picture of 8 bits per channel, RGB or RGBA (not premultiplied), as `folder/STEM.png`; where that
/// is a file that was changed or made by others, as `STEM-2.png` and so on.
///
/// `pixels` has `width * height * channels` bytes, rows from the top, channels interleaved, sRGB.
///
/// # Errors
/// [`Error::Io`]; an existing file stays.
pub fn write_picture(folder: &Path, stem: &str, size_px: [u32; 2], pixels: &[u8]) -> Result<WrittenPicture> {
    let channels = pixels.len() / (size_px[0] as usize * size_px[1] as usize);
    let color = if channels == 4 { ColorType::Rgba } else { ColorType::Rgb };
    let placed = place(folder, stem, EXTENSION, is_unchanged);
    write_atomically_with(&placed.path, |out| encode(out, size_px, color, BitDepth::Eight, pixels))?;
    Ok(placed)
}

/// As [`write_picture`], RGBA with 16 bits per channel: `width * height * 4` numbers.
///
/// # Errors
/// [`Error::Io`]; an existing file stays.
pub fn write_picture_16(
    folder: &Path,
    stem: &str,
    size_px: [u32; 2],
    pixels: &[u16],
) -> Result<WrittenPicture> {
    let placed = place(folder, stem, EXTENSION, is_unchanged);
    let bytes: Vec<u8> = pixels.iter().flat_map(|value| value.to_be_bytes()).collect();
    let (color, depth) = (ColorType::Rgba, BitDepth::Sixteen);
    write_atomically_with(&placed.path, |out| encode(out, size_px, color, depth, &bytes))?;
    Ok(placed)
}

fn encode(
    out: impl Write,
    [width, height]: [u32; 2],
    color: ColorType,
    depth: BitDepth,
    pixels: &[u8],
) -> std::io::Result<()> {
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.set_compression(Compression::Fast);
    encoder.add_text_chunk(MADE_BY.into(), hash_bytes(pixels)).map_err(io_error)?;
    let mut writer = encoder.write_header().map_err(io_error)?;
    writer.write_image_data(pixels).map_err(io_error)?;
    writer.finish().map_err(io_error)
}

/// Chooses the first name that is free or belongs to an unchanged picture of this program, which `is_unchanged` finds out.
pub(super) fn place(
    folder: &Path,
    stem: &str,
    extension: &str,
    is_unchanged: impl Fn(&Path) -> Option<bool>,
) -> WrittenPicture {
    let mut spared = Vec::new();
    let mut number = 1u64;
    loop {
        let suffix = if number == 1 { String::new() } else { format!("-{number}") };
        let path = folder.join(format!("{stem}{suffix}.{extension}"));
        if !path.exists() || is_unchanged(&path).unwrap_or(false) {
            return WrittenPicture { path, spared };
        }
        spared.push(path);
        number += 1;
    }
}

/// Returns whether this program wrote the picture in the file, pixel for pixel; `None` if that cannot be
/// determined.
fn is_unchanged(path: &Path) -> Option<bool> {
    let file = BufReader::with_capacity(1 << 16, File::open(path).ok()?);
    let mut reader = Decoder::new(file).read_info().ok()?;
    let chunks = &reader.info().uncompressed_latin1_text;
    let hash = chunks.iter().find(|chunk| chunk.keyword == MADE_BY)?.text.clone();
    let size = reader.output_buffer_size().filter(|size| *size <= MOST_BYTES)?;
    let mut pixels = vec![0; size];
    reader.next_frame(&mut pixels).ok()?;
    Some(hash_bytes(&pixels) == hash)
}

/// Creates the folder that pictures go to, and removes from it what killed writers left.
///
/// # Errors
/// [`Error::Io`].
pub fn make_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
    remove_dead_leftovers(folder);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(folder: &Path, shade: u8) -> WrittenPicture {
        write_picture(folder, "0001", [3, 2], &[shade; 24]).unwrap()
    }

    fn shade(path: &Path) -> u8 {
        image::open(path).unwrap().to_rgba8().get_pixel(2, 1).0[0]
    }

    #[test]
    fn a_picture_of_ours_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), 1);
        let again = write(folder.path(), 2);
        assert_eq!((shade(&again.path), again.spared.len()), (2, 0));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn one_that_was_painted_on_stays_with_and_without_its_text() {
        let folder = tempfile::tempdir().unwrap();
        let first = write(folder.path(), 1).path;
        image::RgbaImage::from_pixel(3, 2, image::Rgba([9; 4])).save(&first).unwrap();
        let second = write(folder.path(), 2);
        assert_eq!((second.path.clone(), second.spared), (folder.path().join("0001-2.png"), vec![first]));
        // An editor that keeps the text chunk but not the pixels.
        let mut file = File::create(&second.path).unwrap();
        let mut encoder = Encoder::new(&mut file, 3, 2);
        encoder.set_color(ColorType::Rgba);
        encoder.add_text_chunk(MADE_BY.into(), hash_bytes(&[2; 24])).unwrap();
        encoder.write_header().unwrap().write_image_data(&[7; 24]).unwrap();
        assert_eq!(write(folder.path(), 3).path, folder.path().join("0001-3.png"));
    }

    #[test]
    fn pictures_of_16_bits_keep_them_and_are_replaced_like_others() {
        let folder = tempfile::tempdir().unwrap();
        let write = |value: u16| write_picture_16(folder.path(), "view", [2, 1], &[value; 8]).unwrap();
        write(7);
        let placed = write(30_001);
        assert_eq!((placed.path.clone(), placed.spared.len()), (folder.path().join("view.png"), 0));
        let read = image::open(placed.path).unwrap();
        assert_eq!(read.color(), image::ColorType::Rgba16);
        assert_eq!(read.to_rgba16().get_pixel(1, 0).0, [30_001; 4]);
        assert_eq!(write_picture(folder.path(), "view", [2, 1], &[9; 8]).unwrap().spared.len(), 0);
    }

    #[test]
    fn rgb_pictures_are_written_too() {
        let folder = tempfile::tempdir().unwrap();
        let placed = write_picture(folder.path(), "pair", [2, 2], &[5; 12]).unwrap();
        assert_eq!(image::open(placed.path).unwrap().color(), image::ColorType::Rgb8);
    }
}
