//! Reads masks of photos as PNG files, or in another format of photos, and writes them as PNG files. Black is masked, white is
//! not, as in COLMAP.

use std::fs::File;
use std::io::{BufReader, Read, Write};
use std::path::Path;

use png::{BitDepth, ColorType, Compression, Decoder, Encoder, Reader, Transformations};

use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{PixelRect, Spans};
use quadratura_base::raster::in_8_bits;
use quadratura_files::guarded::guarded;
use quadratura_import::photo::{check_photo, is_photo, read_photo};

/// The middle of the range of 8 bits: darker samples are masked if alpha is at least this.
const HALF: u8 = 128;

/// The remedy for a file that cannot be read.
const SAVE: &str = "save the mask as a PNG: black where the photo is to be masked, else white";

/// Reads the pixels that a picture of `width` x `height` masks: those that are opaque (alpha of at least half)
/// and whose mean over the colour channels is darker than half. Transparent pixels are not masked, because
/// nothing was painted there.
///
/// # Errors
/// [`Error::Io`]; [`Error::Input`] for a file that is not a PNG, is damaged, or is of another size.
pub fn read_mask(file: &Path, size: [u32; 2]) -> Result<Spans> {
    guarded(file, SAVE, || decoded(file, size))
}

fn decoded(file: &Path, [width, height]: [u32; 2]) -> Result<Spans> {
    if is_another_picture(file) {
        let picture = read_photo(file, width, height)?;
        let is_masked = |x: i32, y: i32| {
            let [r, g, b, alpha] = picture.rgba16(x as u32, y as u32).map(in_8_bits);
            let sum: usize = [r, g, b].iter().map(|sample| usize::from(*sample)).sum();
            alpha >= HALF && sum < usize::from(HALF) * 3
        };
        return Ok(Spans::of_pixels(PixelRect::of_size(width, height), is_masked));
    }
    let mut reader = opened(file, [width, height])?;
    let (colour, _) = reader.output_color_type();
    let channels = colour.samples();
    let mut bytes = vec![0; width as usize * height as usize * channels];
    reader.next_frame(&mut bytes).map_err(|error| unusable(file, error.to_string()))?;
    let is_masked = |x: i32, y: i32| {
        let at = (y as usize * width as usize + x as usize) * channels;
        let pixel = &bytes[at..at + channels];
        let (colours, alpha) = match colour {
            ColorType::GrayscaleAlpha | ColorType::Rgba => pixel.split_at(channels - 1),
            _ => (pixel, &[u8::MAX][..]),
        };
        let sum: usize = colours.iter().map(|sample| usize::from(*sample)).sum();
        alpha[0] >= HALF && sum < usize::from(HALF) * colours.len()
    };
    Ok(Spans::of_pixels(PixelRect::of_size(width, height), is_masked))
}

/// Checks that the file is a PNG of this size, without decoding it.
///
/// # Errors
/// As [`read_mask`].
pub fn check_mask(file: &Path, size: [u32; 2]) -> Result<()> {
    guarded(file, SAVE, || match is_another_picture(file) {
        true => check_photo(file, size[0], size[1]).map(drop),
        false => opened(file, size).map(drop),
    })
}

/// Returns true for a file that is no PNG, and a picture in another format in which photos are read.
fn is_another_picture(file: &Path) -> bool {
    const PNG: &[u8] = b"\x89PNG";
    let mut start = [0; PNG.len()];
    let read = File::open(file).and_then(|mut file| file.read_exact(&mut start));
    read.is_ok() && start != PNG && is_photo(file)
}

/// Encodes a mask as a PNG of one bit per pixel; the same set always gives the same bytes.
///
/// # Errors
/// The encoder's error; writing to memory itself does not fail.
pub fn mask_png(masked: &Spans, [width, height]: [u32; 2]) -> std::io::Result<Vec<u8>> {
    let row_bytes = (width as usize).div_ceil(8);
    let mut data = vec![0xff_u8; row_bytes * height as usize];
    for (y, run) in masked.iter().filter(|(y, _)| (0..height as i32).contains(y)) {
        for x in run.start.clamp(0, width as i32)..run.end.clamp(0, width as i32) {
            data[y as usize * row_bytes + x as usize / 8] &= !(0x80 >> (x % 8));
        }
    }
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height);
    encoder.set_color(ColorType::Grayscale);
    encoder.set_depth(BitDepth::One);
    encoder.set_compression(Compression::Balanced);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&data)?;
    writer.finish()?;
    bytes.flush()?;
    Ok(bytes)
}

fn opened(file: &Path, [width, height]: [u32; 2]) -> Result<Reader<BufReader<File>>> {
    let open = File::open(file).map_err(Error::io(file, "read it"))?;
    let mut decoder = Decoder::new(BufReader::with_capacity(1 << 16, open));
    decoder.set_transformations(Transformations::EXPAND | Transformations::STRIP_16);
    let reader = decoder.read_info().map_err(|error| unusable(file, error.to_string()))?;
    let found = reader.info().size();
    // The size is checked before anything is allocated for it.
    if found != (width, height) {
        let found = format!("{} x {} pixels, but the photo has {width} x {height}", found.0, found.1);
        return Err(Error::input(file, "", found, "give a mask as large as the photo, pixel for pixel"));
    }
    Ok(reader)
}

fn unusable(file: &Path, found: String) -> Error {
    Error::input(file, "", found, SAVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mask_comes_back_pixel_for_pixel() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("mask.png");
        let masked = Spans::of_pixels(PixelRect::of_size(19, 7), |x, y| (x * y) % 5 == 1);
        std::fs::write(&file, mask_png(&masked, [19, 7]).unwrap()).unwrap();
        assert_eq!(read_mask(&file, [19, 7]).unwrap(), masked);
        assert_eq!(image::open(&file).unwrap().to_luma8().get_pixel(1, 1).0, [0], "black is masked");
        let message = read_mask(&file, [18, 7]).unwrap_err().to_string();
        assert!(message.contains("19 x 7") && message.contains("18 x 7"), "{message}");
    }

    #[test]
    fn dark_opaque_pixels_are_masked_in_every_kind_of_picture() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("mask.png");
        let masked = |picture: image::DynamicImage| {
            picture.save(&file).unwrap();
            let found = read_mask(&file, [4, 1]).unwrap();
            [0, 1, 2, 3].map(|x| found.holds(x, 0))
        };
        let rgba = image::RgbaImage::from_raw(
            4,
            1,
            vec![0, 0, 0, 255, 9, 9, 9, 0, 255, 255, 255, 255, 255, 0, 0, 255],
        );
        let rgba = image::DynamicImage::from(rgba.unwrap());
        assert_eq!(masked(rgba.clone()), [true, false, false, true], "a red is dark");
        assert_eq!(masked(rgba.to_rgb8().into()), [true, true, false, true]);
        assert_eq!(masked(rgba.to_luma16().into()), [true, true, false, true]);
    }

    #[test]
    fn a_mask_may_be_a_tiff_of_the_photos_size() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("mask.tif");
        let picture = image::GrayImage::from_fn(7, 5, |x, y| image::Luma([if x < y { 10 } else { 250 }]));
        picture.save(&file).unwrap();
        let masked = read_mask(&file, [7, 5]).unwrap();
        assert_eq!(masked, Spans::of_pixels(PixelRect::of_size(7, 5), |x, y| x < y));
        check_mask(&file, [7, 5]).unwrap();
        let message = check_mask(&file, [5, 7]).unwrap_err().to_string();
        assert!(message.contains("7 x 5") && message.contains("5 x 7"), "{message}");
    }

    #[test]
    fn a_file_that_is_no_png_is_refused() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), "black").unwrap();
        assert!(check_mask(file.path(), [1, 1]).unwrap_err().to_string().contains("save the mask as a PNG"));
    }
}
