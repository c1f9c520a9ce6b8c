//! Reads PNG of any kind as image editors write it: grey, palette, with and without alpha, 1 to 16 bits.

use std::io::{BufRead, Seek};

use png::{BitDepth, ColorType, Decoder, Limits, Transformations};

use super::depth::Depth;
use super::edited::StoredColours;
use super::inflate::can_inflate_to;
use super::place::{is_canvas, not_a_canvas};
use super::raster::Raster;
use quadratura_base::scene::Samples;

/// The header of a PNG.
#[derive(Debug, Clone)]
pub struct PngHead {
    pub width: u32,
    pub height: u32,
    /// Bit depth; anything above 8 bits counts as 16.
    pub depth: Depth,
    pub icc: Option<Vec<u8>>,
    /// The colours that its pixels can have.
    pub colours: StoredColours,
}

/// A picture of up to this many bytes in memory is always read; a small file can be one of a single colour,
/// which deflates to almost nothing.
const HARMLESS: u64 = 32 << 20;

/// Reads the header.
///
/// # Errors
/// A sentence that says what is wrong.
pub fn head(input: impl BufRead + Seek) -> Result<PngHead, String> {
    let reader = decoder(input).read_info().map_err(|error| error.to_string())?;
    let info = reader.info();
    let depth = if info.bit_depth == BitDepth::Sixteen { Depth::Sixteen } else { Depth::Eight };
    let (width, height) = info.size();
    if !is_canvas(width, height) {
        return Err(not_a_canvas(width, height));
    }
    let colours = match info.color_type {
        ColorType::Rgb | ColorType::Rgba => StoredColours::Full,
        ColorType::Grayscale | ColorType::GrayscaleAlpha => StoredColours::Grey,
        ColorType::Indexed => StoredColours::Palette,
    };
    Ok(PngHead { width, height, depth, icc: info.icc_profile.as_deref().map(<[u8]>::to_vec), colours })
}

/// Reads a PNG of `length` bytes as RGBA; its width and height must be those in `head`. Samples of 8 bits are widened
/// where `depth` is 16 bits; samples of 16 bits are never narrowed.
///
/// # Errors
/// A sentence that says what is wrong.
pub fn raster(
    input: impl BufRead + Seek,
    length: u64,
    head: &PngHead,
    depth: Depth,
) -> Result<Raster, String> {
    let mut reader = decoder(input).read_info().map_err(|error| error.to_string())?;
    let (width, height) = reader.info().size();
    if (width, height) != (head.width, head.height) {
        return Err(format!("{width} x {height} pixels, expected {} x {}", head.width, head.height));
    }
    let bytes = 4 * depth.bytes() * u64::from(width) * u64::from(height);
    if bytes > HARMLESS && !can_inflate_to(length, bytes / 4) {
        return Err(format!("{width} x {height} pixels in {length} bytes"));
    }
    let size = reader.output_buffer_size().ok_or("more pixels than this machine can hold")?;
    let mut samples = vec![0; size];
    reader.next_frame(&mut samples).map_err(|error| error.to_string())?;
    let (colour, stored) = reader.output_color_type();
    let samples = match (stored, depth) {
        (BitDepth::Sixteen, _) => Samples::U16(rgba(&wide(&samples), colour, u16::MAX)?),
        (_, Depth::Sixteen) => {
            let wide: Vec<u16> = samples.iter().map(|sample| u16::from(*sample) * 257).collect();
            Samples::U16(rgba(&wide, colour, u16::MAX)?)
        }
        (_, Depth::Eight) => Samples::U8(rgba(&samples, colour, u8::MAX)?),
    };
    Ok(Raster::new(width, height, samples))
}

/// Returns a decoder that expands palettes to colours, fewer bits to 8, and a transparent colour to alpha.
fn decoder<R: BufRead + Seek>(input: R) -> Decoder<R> {
    let mut decoder = Decoder::new_with_limits(input, Limits { bytes: HARMLESS as usize });
    decoder.set_transformations(Transformations::EXPAND);
    decoder
}

fn wide(bytes: &[u8]) -> Vec<u16> {
    let (pairs, _) = bytes.as_chunks::<2>();
    pairs.iter().map(|pair| u16::from_be_bytes(*pair)).collect()
}

fn rgba<T: Copy>(samples: &[T], colour: ColorType, full: T) -> Result<Vec<T>, String> {
    Ok(match colour {
        ColorType::Rgba => samples.to_vec(),
        ColorType::Rgb => samples.as_chunks().0.iter().flat_map(|&[r, g, b]| [r, g, b, full]).collect(),
        ColorType::GrayscaleAlpha => samples.as_chunks().0.iter().flat_map(|&[v, a]| [v, v, v, a]).collect(),
        ColorType::Grayscale => samples.iter().flat_map(|&v| [v, v, v, full]).collect(),
        ColorType::Indexed => return Err("a palette that was not expanded".into()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn encoded(colour: ColorType, depth: BitDepth, palette: Option<&[u8]>, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        if let Some(palette) = palette {
            encoder.set_palette(palette.to_vec());
        }
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        bytes
    }

    fn read(bytes: &[u8], depth: Depth) -> Samples {
        let head = head(Cursor::new(bytes)).unwrap();
        raster(Cursor::new(bytes), bytes.len() as u64, &head, depth).unwrap().samples().clone()
    }

    #[test]
    fn every_kind_of_png_becomes_rgba() {
        let eight = |colour, palette, data: &[u8]| {
            read(&encoded(colour, BitDepth::Eight, palette, data), Depth::Eight)
        };
        let grey = Samples::U8(vec![7, 7, 7, 255, 9, 9, 9, 255]);
        assert_eq!(eight(ColorType::Grayscale, None, &[7, 9]), grey);
        assert_eq!(eight(ColorType::Indexed, Some(&[9, 9, 9, 7, 7, 7]), &[1, 0]), grey);
        assert_eq!(eight(ColorType::Rgb, None, &[7, 7, 7, 9, 9, 9]), grey);
        let clear = Samples::U8(vec![7, 7, 7, 0, 9, 9, 9, 3]);
        assert_eq!(eight(ColorType::GrayscaleAlpha, None, &[7, 0, 9, 3]), clear);
        assert_eq!(eight(ColorType::Rgba, None, &[7, 7, 7, 0, 9, 9, 9, 3]), clear);
    }

    #[test]
    fn bits_are_spread_over_the_full_range() {
        let two = encoded(ColorType::Grayscale, BitDepth::One, None, &[0b0100_0000]);
        let black_and_white = Samples::U16(vec![0, 0, 0, 65535, 65535, 65535, 65535, 65535]);
        assert_eq!(read(&two, Depth::Sixteen), black_and_white);
        let sixteen = encoded(ColorType::GrayscaleAlpha, BitDepth::Sixteen, None, &[1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(head(Cursor::new(&sixteen)).unwrap().depth, Depth::Sixteen);
        let expected = Samples::U16(vec![0x102, 0x102, 0x102, 0x304, 0x506, 0x506, 0x506, 0x708]);
        assert_eq!(read(&sixteen, Depth::Sixteen), expected);
    }

    #[test]
    fn a_file_that_is_no_png_or_has_another_size_is_refused() {
        assert!(head(Cursor::new(b"no PNG")).is_err());
        let bytes = encoded(ColorType::Grayscale, BitDepth::Eight, None, &[7, 9]);
        let other = PngHead { height: 5, ..head(Cursor::new(&bytes)).unwrap() };
        let error = raster(Cursor::new(&bytes), 99, &other, Depth::Eight).unwrap_err();
        assert!(error.contains("2 x 1 pixels, expected 2 x 5"), "{error}");
    }
}
