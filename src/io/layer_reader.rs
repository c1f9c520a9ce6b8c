//! Reads what `layer_png` writes: an image layer's texels and its needed area, cropped.
//!
//! Colours are returned as 8 bits in the photo's own encoding; an ICC profile in the file is not applied.
//! (Photos of one site nearly always share a profile, and its curve is sRGB's or close to it.)

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use png::{BitDepth, ColorType, Decoder, Reader};

use quadratura_base::error::{Error, Remedy, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::in_8_bits;

/// The remedy for damaged stacks.
const REMEDY: (&str, Remedy, &str) = ("run ", Remedy::Build, " to make it again");

/// Reads texels of an image layer: RGBA of 8 bits, not premultiplied, `crop.w * crop.h * 4` samples, rows
/// from the top. `rect` is the rectangle of the file and `crop` a part of it, both in photo pixels. 16 bits
/// are rounded to 8.
///
/// # Errors
/// [`Error::Io`], and [`Error::Input`] for a file that is not an RGBA PNG of that size.
pub fn read_layer(path: &Path, rect: PixelRect, crop: PixelRect) -> Result<Vec<u8>> {
    let mut reader = open(path, rect)?;
    let mut texels = Vec::with_capacity(4 * crop.area() as usize);
    let (skipped, count) = ((crop.x - rect.x) as usize, crop.w as usize);
    match reader.output_color_type() {
        (ColorType::Rgba, BitDepth::Eight) => rows(path, &mut reader, rect, crop, |row| {
            texels.extend_from_slice(&row[4 * skipped..4 * (skipped + count)]);
        })?,
        (ColorType::Rgba, BitDepth::Sixteen) => rows(path, &mut reader, rect, crop, |row| {
            let samples = row[8 * skipped..8 * (skipped + count)].as_chunks().0;
            texels.extend(samples.iter().map(|sample| in_8_bits(u16::from_be_bytes(*sample))));
        })?,
        (colour, depth) => return Err(unexpected(path, format!("{colour:?} of {depth:?} bits, not RGBA"))),
    }
    Ok(texels)
}

/// Reads texels of an image layer as [`read_layer`] does, in the full range of 16 bits: 8 bits are scaled to it.
///
/// # Errors
/// As [`read_layer`].
pub fn read_layer_16(path: &Path, rect: PixelRect, crop: PixelRect) -> Result<Vec<u16>> {
    let mut reader = open(path, rect)?;
    let mut texels = Vec::with_capacity(4 * crop.area() as usize);
    let (skipped, count) = ((crop.x - rect.x) as usize, crop.w as usize);
    match reader.output_color_type() {
        (ColorType::Rgba, BitDepth::Eight) => rows(path, &mut reader, rect, crop, |row| {
            let samples = &row[4 * skipped..4 * (skipped + count)];
            texels.extend(samples.iter().map(|sample| u16::from(*sample) * 257));
        })?,
        (ColorType::Rgba, BitDepth::Sixteen) => rows(path, &mut reader, rect, crop, |row| {
            let samples = row[8 * skipped..8 * (skipped + count)].as_chunks().0;
            texels.extend(samples.iter().map(|sample| u16::from_be_bytes(*sample)));
        })?,
        (colour, depth) => return Err(unexpected(path, format!("{colour:?} of {depth:?} bits, not RGBA"))),
    }
    Ok(texels)
}

/// Reads a mask: 1 where the 1-bit PNG is white, 0 elsewhere; `crop.w * crop.h` values, rows from the top.
///
/// # Errors
/// [`Error::Io`], and [`Error::Input`] for a file that is not a 1-bit PNG of the size of `rect`.
pub fn read_mask(path: &Path, rect: PixelRect, crop: PixelRect) -> Result<Vec<u8>> {
    let mut reader = open(path, rect)?;
    if reader.output_color_type() != (ColorType::Grayscale, BitDepth::One) {
        return Err(unexpected(path, "not a mask of 1 bit".into()));
    }
    let mut mask = Vec::with_capacity(crop.area() as usize);
    let columns = (crop.x - rect.x) as usize..(crop.right() - rect.x) as usize;
    rows(path, &mut reader, rect, crop, |row| {
        mask.extend(columns.clone().map(|x| row[x / 8] >> (7 - x % 8) & 1));
    })?;
    Ok(mask)
}

/// Reads grey samples of 8 or 16 bits, unscaled; `crop.w * crop.h` values, rows from the top.
///
/// # Errors
/// [`Error::Io`], and [`Error::Input`] for a file that is not a grey PNG of the size of `rect`.
pub fn read_grey(path: &Path, rect: PixelRect, crop: PixelRect) -> Result<Vec<u16>> {
    let mut reader = open(path, rect)?;
    let mut grey = Vec::with_capacity(crop.area() as usize);
    let (skipped, count) = ((crop.x - rect.x) as usize, crop.w as usize);
    match reader.output_color_type() {
        (ColorType::Grayscale, BitDepth::Eight) => rows(path, &mut reader, rect, crop, |row| {
            grey.extend(row[skipped..skipped + count].iter().map(|sample| u16::from(*sample)));
        })?,
        (ColorType::Grayscale, BitDepth::Sixteen) => rows(path, &mut reader, rect, crop, |row| {
            let samples = row[2 * skipped..2 * (skipped + count)].as_chunks().0;
            grey.extend(samples.iter().map(|sample| u16::from_be_bytes(*sample)));
        })?,
        (colour, depth) => return Err(unexpected(path, format!("{colour:?} of {depth:?} bits, not grey"))),
    }
    Ok(grey)
}

type Png = Reader<BufReader<File>>;

fn open(path: &Path, rect: PixelRect) -> Result<Png> {
    let file = File::open(path).map_err(Error::io(path, "read it"))?;
    let mut decoder = Decoder::new(BufReader::with_capacity(1 << 16, file));
    // Samples stay as the file has them: nothing is expanded or stripped.
    decoder.set_transformations(png::Transformations::IDENTITY);
    let reader = decoder.read_info().map_err(|error| broken(path, error))?;
    let (width, height) = (reader.info().width, reader.info().height);
    if (width, height) != (rect.w, rect.h) {
        let found = format!("{width} x {height} pixels, `stack.json` says {} x {}", rect.w, rect.h);
        return Err(unexpected(path, found));
    }
    // Interlaced rows come in another order.
    if reader.info().interlaced {
        return Err(unexpected(path, "an interlaced PNG".into()));
    }
    Ok(reader)
}

/// Reads all rows of the file and calls `take` with those within the crop, at the file's full width.
fn rows(
    path: &Path,
    reader: &mut Png,
    rect: PixelRect,
    crop: PixelRect,
    mut take: impl FnMut(&[u8]),
) -> Result<()> {
    for y in rect.y..crop.bottom() {
        let row = reader.next_row().map_err(|error| broken(path, error))?;
        let row = row.ok_or_else(|| unexpected(path, format!("the file ends after row {}", y - rect.y)))?;
        if y >= crop.y {
            take(row.data());
        }
    }
    Ok(())
}

fn unexpected(path: &Path, found: String) -> Error {
    Error::input(path, "", found, REMEDY)
}

fn broken(path: &Path, error: png::DecodingError) -> Error {
    match error {
        png::DecodingError::IoError(source) if source.kind() != std::io::ErrorKind::UnexpectedEof => {
            Error::io(path, "read it")(source)
        }
        error => unexpected(path, error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layer_png::{LayerSpans, write_layer, write_mask};
    use quadratura_base::scene::pixels::{PhotoPixels, Samples};
    use quadratura_layers::content::PixelSpan;

    const RECT: PixelRect = PixelRect { x: -3, y: 2, w: 32, h: 8 };
    const CROP: PixelRect = PixelRect { x: 1, y: 3, w: 20, h: 4 };

    fn spans() -> Vec<PixelSpan> {
        (3..7).map(|y| PixelSpan { y, x0: y, x1: 21 }).collect()
    }

    fn photo(samples: Samples) -> PhotoPixels {
        PhotoPixels { width: 40, height: 12, channels: 3, samples, icc: None }
    }

    #[test]
    fn a_written_layer_is_read_cropped_in_8_and_in_16_bits() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("layer.png");
        let value = |i: usize| (i * 7 % 256) as u8;
        let bytes = photo(Samples::U8((0..40 * 12 * 3).map(value).collect()));
        let words = photo(Samples::U16((0..40 * 12 * 3).map(|i| u16::from(value(i)) * 257 + 100).collect()));
        for pixels in [&bytes, &words] {
            write_layer(&path, pixels, RECT, LayerSpans { visible: &spans(), beside: &[] }).unwrap();
            let texels = read_layer(&path, RECT, CROP).unwrap();
            for (i, texel) in texels.as_chunks::<4>().0.iter().enumerate() {
                let (x, y) = (1 + i % 20, 3 + i / 20);
                let at = 3 * (y * 40 + x);
                let opaque = [value(at), value(at + 1), value(at + 2), 255];
                assert_eq!(*texel, if x >= y && x < 21 { opaque } else { [0; 4] }, "{x}, {y}");
            }
        }
    }

    #[test]
    fn a_mask_is_read_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mask.png");
        write_mask(&path, RECT, &spans()).unwrap();
        let mask = read_mask(&path, RECT, CROP).unwrap();
        assert!(mask.iter().enumerate().all(|(i, &set)| (set == 1) == (1 + i % 20 >= 3 + i / 20)));
    }

    #[test]
    fn a_file_that_does_not_fit_its_stack_says_what_to_do() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mask.png");
        write_mask(&path, RECT, &spans()).unwrap();
        let larger = read_mask(&path, PixelRect { w: 64, ..RECT }, CROP).unwrap_err().to_string();
        assert!(larger.contains("32 x 8 pixels") && larger.contains("run “build”"), "{larger}");
        let colours = read_layer(&path, RECT, CROP).unwrap_err().to_string();
        assert!(colours.contains("not RGBA"), "{colours}");
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() - 30]).unwrap();
        assert!(matches!(read_mask(&path, RECT, RECT), Err(Error::Input { .. })));
        assert!(matches!(read_mask(&path.join("x"), RECT, CROP), Err(Error::Io { .. })));
    }
}
