//! Reads layers of stacks and writes layers of exports as PNG files.

use std::borrow::Cow;
use std::fs::File;
use std::io::{BufReader, Write};
use std::path::Path;

use png::{BitDepth, ColorType, Compression, Decoder, Encoder, Info, Reader, Transformations};

use super::depth::Depth;
use super::raster::Raster;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::Image;
use quadratura_base::scene::Samples;

type PngReader = Reader<BufReader<File>>;

/// The remedy for a file of a stack that cannot be used.
const REBUILD: &str = "the stack is damaged: build the photo's stack again";

/// Reads an RGBA PNG of 8 or 16 bits, which must have `width` x `height` pixels. Transparent pixels are
/// returned black: the colours that stacks store beside outlines are for textures, not for image editors.
///
/// # Errors
/// [`Error::Input`] when the file cannot be opened, or is not such a PNG.
pub fn read_rgba(file: &Path, width: u32, height: u32) -> Result<Raster> {
    let samples = match samples_of(file, width, height).map_err(of_stack(file))? {
        Samples::U8(samples) => Samples::U8(blackened(samples)),
        Samples::U16(samples) => Samples::U16(blackened(samples)),
    };
    Ok(Raster::new(width, height, samples))
}

/// Reads the same with the colours of transparent pixels as stored in the file.
///
/// # Errors
/// A sentence that says what is wrong; the caller knows whose file it is and what to do about it.
pub fn read_rgba_as_stored(file: &Path, width: u32, height: u32) -> Result<Raster, String> {
    Ok(Raster::new(width, height, samples_of(file, width, height)?))
}

fn samples_of(file: &Path, width: u32, height: u32) -> Result<Samples, String> {
    let mut reader = opened(file, width, height, Transformations::IDENTITY)?;
    match reader.output_color_type() {
        (ColorType::Rgba, BitDepth::Eight) => Ok(Samples::U8(bytes_of(&mut reader)?)),
        (ColorType::Rgba, BitDepth::Sixteen) => {
            let bytes = bytes_of(&mut reader)?;
            let (pairs, _) = bytes.as_chunks::<2>();
            Ok(Samples::U16(pairs.iter().map(|pair| u16::from_be_bytes(*pair)).collect()))
        }
        (colour, depth) => Err(format!("{colour:?} of {depth:?} bits, expected RGBA of 8 or 16")),
    }
}

/// Makes fully transparent pixels black.
fn blackened<T: Copy + Default + PartialEq>(mut rgba: Vec<T>) -> Vec<T> {
    let clear = T::default();
    rgba.as_chunks_mut::<4>()
        .0
        .iter_mut()
        .filter(|texel| texel[3] == clear)
        .for_each(|texel| *texel = [clear; 4]);
    rgba
}

/// Reads the area in which a layer needs pixels: where a grey PNG of 1 to 8 bits is not black. It must be as large as
/// `rect`, where the layer lies.
///
/// # Errors
/// As [`read_rgba`].
pub fn read_mask(file: &Path, rect: PixelRect) -> Result<Image<bool>> {
    let bytes = grey_of(file, rect.w, rect.h).map_err(of_stack(file))?;
    Ok(Image::new(rect, bytes.iter().map(|byte| *byte != 0).collect()))
}

fn grey_of(file: &Path, width: u32, height: u32) -> Result<Vec<u8>, String> {
    let mut reader = opened(file, width, height, Transformations::EXPAND)?;
    match reader.output_color_type() {
        (ColorType::Grayscale, BitDepth::Eight) => bytes_of(&mut reader),
        (colour, depth) => Err(format!("{colour:?} of {depth:?} bits, expected black and white")),
    }
}

fn opened(file: &Path, width: u32, height: u32, transform: Transformations) -> Result<PngReader, String> {
    let open = File::open(file).map_err(|error| format!("the file cannot be opened ({error})"))?;
    let mut decoder = Decoder::new(BufReader::with_capacity(1 << 16, open));
    decoder.set_transformations(transform);
    let reader = decoder.read_info().map_err(|error| error.to_string())?;
    let found = reader.info().size();
    // The size is checked before anything is allocated for it.
    if found != (width, height) {
        return Err(format!("{} x {} pixels, expected {width} x {height}", found.0, found.1));
    }
    Ok(reader)
}

fn bytes_of(reader: &mut PngReader) -> Result<Vec<u8>, String> {
    let size = reader.output_buffer_size().ok_or("too large for this machine")?;
    let mut bytes = vec![0; size];
    reader.next_frame(&mut bytes).map_err(|error| error.to_string())?;
    Ok(bytes)
}

fn of_stack(file: &Path) -> impl FnOnce(String) -> Error {
    move |found| Error::input(file, "", found, REBUILD)
}

/// Writes an RGBA PNG with fast compression: slower levels take twenty times as long and do not make layers
/// of photos smaller.
///
/// # Errors
/// The error of `out`.
pub fn write_rgba(out: impl Write, raster: &Raster, icc: Option<&[u8]>) -> std::io::Result<()> {
    let mut info = Info::with_size(raster.width(), raster.height());
    info.color_type = ColorType::Rgba;
    info.icc_profile = icc.map(Cow::Borrowed);
    info.bit_depth = if raster.depth() == Depth::Sixteen { BitDepth::Sixteen } else { BitDepth::Eight };
    let mut encoder = Encoder::with_info(out, info)?;
    encoder.set_compression(Compression::Fast);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&raster.samples().big_endian())?;
    writer.finish()?;
    Ok(())
}

/// Reads the bit depth of the PNG `file` from its header.
///
/// # Errors
/// As [`read_rgba`].
pub fn depth_of(file: &Path) -> Result<Depth> {
    let open = File::open(file).map_err(Error::io(file, "open it"))?;
    let read = Decoder::new(BufReader::new(open)).read_info();
    let reader = read.map_err(|error| of_stack(file)(error.to_string()))?;
    Ok(if reader.info().bit_depth == BitDepth::Sixteen { Depth::Sixteen } else { Depth::Eight })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(folder: &Path, raster: &Raster) -> std::path::PathBuf {
        let file = folder.join("layer.png");
        write_rgba(File::create(&file).unwrap(), raster, Some(b"a profile")).unwrap();
        file
    }

    #[test]
    fn pixels_of_8_and_16_bits_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let eight = Raster::new(3, 2, Samples::U8((0..24).collect()));
        let sixteen = Raster::new(3, 2, Samples::U16((0..24).map(|i| i * 2621).collect()));
        for raster in [eight, sixteen] {
            let file = written(folder.path(), &raster);
            assert_eq!(read_rgba(&file, 3, 2).unwrap(), raster);
            assert_eq!(depth_of(&file).unwrap(), raster.depth());
        }
    }

    #[test]
    fn another_size_than_the_stack_says_is_an_error_that_names_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let file = written(folder.path(), &Raster::blank(3, 2, Depth::Eight));
        let error = read_rgba(&file, 2, 3).unwrap_err().to_string();
        assert!(error.contains("layer.png") && error.contains("3 x 2"), "{error}");
    }

    #[test]
    fn a_file_that_is_no_png_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("layer.png");
        std::fs::write(&file, "no picture").unwrap();
        assert!(matches!(read_rgba(&file, 1, 1), Err(Error::Input { .. })));
        assert!(matches!(read_mask(&file, PixelRect::of_size(1, 1)), Err(Error::Input { .. })));
    }
}
