//! Orthophotos as TIFF and PNG, strip by strip.
//!
//! TIFF 6.0 with deflated strips; the GeoTIFF tags are those of OGC 19-008r4, sections 7 and 8: a scale, one tie point at the upper left
//! corner, and the number of a projected system. A picture of more than 4 GB is a BigTIFF.

use std::io::{BufWriter, Seek, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use png::{BitDepth, ColorType, Encoder, PixelDimensions, Unit};
use tiff::encoder::{DirectoryEncoder, Rational, TiffEncoder, TiffKind, TiffKindBig, TiffKindStandard};
use tiff::tags::{CompressionMethod, ExtraSamples, PhotometricInterpretation, ResolutionUnit, Tag};
use tiff::{TiffError, TiffResult};

use super::rows::RowsFile;
use quadratura_base::error::Result;
use quadratura_files::atomic::write_atomically_with;
use quadratura_files::png_error::io_error;

/// What is written into a picture beside its pixels.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PictureTags {
    /// Pixels per inch in which the picture is printed at its scale.
    pub dpi: f64,
    /// What the picture shows, in words.
    pub description: String,
    /// The place on a map; `None` where the picture has none.
    pub map: Option<MapTags>,
}

/// The place of a picture on a map, whose rows run to the east, from the north.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapTags {
    /// The side of a pixel, in metres.
    pub pixel_m: f64,
    /// East and north of the upper left corner, in metres.
    pub corner: [f64; 2],
    /// The number of the projected system in EPSG's register; `None` for a system of the site's own.
    pub epsg: Option<u32>,
}

/// The rows of a strip.
const STRIP: u32 = 64;

/// The most bytes of pixels of a file with offsets of 32 bits; tags and strips that deflate enlarges need a little more.
const LARGEST: u64 = 4_000_000_000;

/// Writes the picture as a TIFF with alpha that is not multiplied into the colours.
///
/// # Errors
/// [`quadratura_base::error::Error::Io`]; an existing file stays.
pub fn write_tiff(target: &Path, rows: &RowsFile, tags: &PictureTags) -> Result<()> {
    let [width, height] = rows.size_px();
    let is_big = 4 * u64::from(width) * u64::from(height) > LARGEST;
    // The writer of TIFF goes back to its header.
    let mut file = quadratura_files::atomic::AtomicFile::create(target)?;
    let out = BufWriter::with_capacity(1 << 20, file.file());
    let written = match is_big {
        true => TiffEncoder::new_big(out).and_then(|encoder| tiff::<_, TiffKindBig>(encoder, rows, tags)),
        false => TiffEncoder::new(out).and_then(|encoder| tiff::<_, TiffKindStandard>(encoder, rows, tags)),
    };
    written.map_err(|error| quadratura_base::error::Error::io(target, "write")(io_of(error)))?;
    file.commit()
}

fn io_of(error: TiffError) -> std::io::Error {
    match error {
        TiffError::IoError(error) => error,
        other => std::io::Error::other(other),
    }
}

fn tiff<W: Write + Seek, K: TiffKind>(
    mut encoder: TiffEncoder<W, K>,
    rows: &RowsFile,
    tags: &PictureTags,
) -> TiffResult<()> {
    let mut directory = encoder.image_directory()?;
    let (mut offsets, mut sizes) = (Vec::new(), Vec::new());
    let write = |strip: &[u8]| -> std::io::Result<()> {
        let mut deflated = ZlibEncoder::new(Vec::new(), Compression::fast());
        deflated.write_all(&differences(strip, rows.size_px()[0]))?;
        let deflated = deflated.finish()?;
        let offset = directory.write_data(deflated.as_slice()).map_err(io_of)?;
        offsets.push(K::convert_offset(offset).map_err(io_of)?);
        sizes.push(K::convert_offset(deflated.len() as u64).map_err(io_of)?);
        Ok(())
    };
    rows.read(STRIP, write)?;
    write_layout(&mut directory, rows.size_px())?;
    directory.write_tag(Tag::StripOffsets, K::convert_slice(&offsets))?;
    directory.write_tag(Tag::StripByteCounts, K::convert_slice(&sizes))?;
    write_meaning(&mut directory, tags)?;
    directory.finish()
}

/// Replaces channels by their differences to the pixel on the left (TIFF 6.0, section 14), which deflates better.
fn differences(strip: &[u8], width: u32) -> Vec<u8> {
    let mut out = strip.to_vec();
    for row in out.chunks_exact_mut(4 * width as usize) {
        for at in (4..row.len()).rev() {
            row[at] = row[at].wrapping_sub(row[at - 4]);
        }
    }
    out
}

fn write_layout<W: Write + Seek, K: TiffKind>(
    directory: &mut DirectoryEncoder<'_, W, K>,
    [width, height]: [u32; 2],
) -> TiffResult<()> {
    /// Differences along rows.
    const HORIZONTAL: u16 = 2;
    directory.write_tag(Tag::ImageWidth, width)?;
    directory.write_tag(Tag::ImageLength, height)?;
    directory.write_tag(Tag::BitsPerSample, &[8u16; 4][..])?;
    directory.write_tag(Tag::Compression, CompressionMethod::Deflate.to_u16())?;
    directory.write_tag(Tag::PhotometricInterpretation, PhotometricInterpretation::RGB.to_u16())?;
    directory.write_tag(Tag::SamplesPerPixel, 4u16)?;
    directory.write_tag(Tag::RowsPerStrip, STRIP)?;
    directory.write_tag(Tag::Predictor, HORIZONTAL)?;
    directory.write_tag(Tag::ExtraSamples, ExtraSamples::UnassociatedAlpha.to_u16())
}

fn write_meaning<W: Write + Seek, K: TiffKind>(
    directory: &mut DirectoryEncoder<'_, W, K>,
    tags: &PictureTags,
) -> TiffResult<()> {
    /// A thousandth of a pixel per inch.
    const STEPS: f64 = 1000.0;
    let dpi = || Rational { n: (tags.dpi * STEPS).round() as u32, d: STEPS as u32 };
    directory.write_tag(Tag::XResolution, dpi())?;
    directory.write_tag(Tag::YResolution, dpi())?;
    directory.write_tag(Tag::ResolutionUnit, ResolutionUnit::Inch.to_u16())?;
    directory.write_tag(Tag::Software, concat!("Quadratura ", env!("CARGO_PKG_VERSION")))?;
    // TIFF knows ASCII alone.
    let ascii: String = tags.description.chars().map(|c| if c.is_ascii() { c } else { '?' }).collect();
    directory.write_tag(Tag::ImageDescription, ascii.as_str())?;
    if let Some(map) = &tags.map {
        let [east, north] = map.corner;
        directory.write_tag(Tag::ModelPixelScaleTag, &[map.pixel_m, map.pixel_m, 0.0][..])?;
        directory.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, east, north, 0.0][..])?;
        directory.write_tag(Tag::GeoKeyDirectoryTag, &geo_keys(map.epsg)[..])?;
    }
    Ok(())
}

/// Returns the directory of keys of GeoTIFF: a projected system, pixels as areas, metres.
fn geo_keys(epsg: Option<u32>) -> Vec<u16> {
    const USER_DEFINED: u16 = 32767;
    const METRE: u16 = 9001;
    let number = epsg.and_then(|number| u16::try_from(number).ok()).unwrap_or(USER_DEFINED);
    let keys = [[1024, 1], [1025, 1], [3072, number], [3076, METRE]];
    let mut words = vec![1, 1, 0, keys.len() as u16];
    keys.iter().for_each(|[key, value]| words.extend([*key, 0, 1, *value]));
    words
}

/// Writes the picture as a PNG with its resolution.
///
/// # Errors
/// [`quadratura_base::error::Error::Io`]; an existing file stays.
pub fn write_png(target: &Path, rows: &RowsFile, tags: &PictureTags) -> Result<()> {
    let [width, height] = rows.size_px();
    write_atomically_with(target, |out| {
        let mut encoder = Encoder::new(out, width, height);
        encoder.set_color(ColorType::Rgba);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_compression(png::Compression::Fast);
        let per_metre = (tags.dpi / 0.0254).round() as u32;
        encoder.set_pixel_dims(Some(PixelDimensions { xppu: per_metre, yppu: per_metre, unit: Unit::Meter }));
        encoder.add_itxt_chunk("Description".into(), tags.description.clone()).map_err(io_error)?;
        let mut writer = encoder.write_header().map_err(io_error)?;
        let mut stream = writer.stream_writer().map_err(io_error)?;
        rows.read(STRIP, |strip| stream.write_all(strip))?;
        stream.finish().map_err(io_error)?;
        writer.finish().map_err(io_error)
    })
}

/// A picture of a few colours, drawn row by row: each pixel is the index of its colour.
#[derive(Debug)]
pub struct IndexedPicture {
    /// Width in pixels.
    pub width: u32,
    /// The indices, row by row from the top.
    pub indices: Vec<u8>,
    /// The colours, sRGB.
    pub colours: Vec<[u8; 3]>,
}

/// Writes a picture of a few colours as a PNG.
///
/// # Errors
/// [`quadratura_base::error::Error::Io`]; an existing file stays.
pub fn write_indexed_png(target: &Path, picture: &IndexedPicture, description: &str) -> Result<()> {
    let height = picture.indices.len() as u32 / picture.width.max(1);
    write_atomically_with(target, |out| {
        let mut encoder = Encoder::new(out, picture.width, height);
        encoder.set_color(ColorType::Indexed);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_palette(picture.colours.concat());
        encoder.add_itxt_chunk("Description".into(), description.into()).map_err(io_error)?;
        let mut writer = encoder.write_header().map_err(io_error)?;
        writer.write_image_data(&picture.indices).map_err(io_error)?;
        writer.finish().map_err(io_error)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shaded(folder: &Path) -> RowsFile {
        let mut rows = RowsFile::create(folder, 70).unwrap();
        for y in 0..150u8 {
            let row = (0..70u8).flat_map(|x| [x.wrapping_mul(3), y, x ^ y, 255 - y]).collect::<Vec<_>>();
            rows.append(&row).unwrap();
        }
        rows
    }

    #[test]
    fn a_tiff_has_its_pixels_resolution_and_place_on_the_map() {
        let folder = tempfile::tempdir().unwrap();
        let (rows, target) = (shaded(folder.path()), folder.path().join("plan.tif"));
        let map = MapTags { pixel_m: 0.004, corner: [412_345.25, 5_654_321.5], epsg: Some(25832) };
        let tags = PictureTags { dpi: 317.5, description: "a roof, 1:50".into(), map: Some(map) };
        write_tiff(&target, &rows, &tags).unwrap();
        let picture = image::open(&target).unwrap().to_rgba8();
        assert_eq!(picture.dimensions(), (70, 150));
        assert_eq!(picture.get_pixel(69, 149).0, [207, 149, 69 ^ 149, 106]);
        let file = std::fs::File::open(&target).unwrap();
        let mut decoder = ::tiff::decoder::Decoder::new(std::io::BufReader::new(file)).unwrap();
        let mut numbers = |tag| decoder.get_tag_f64_vec(tag).unwrap();
        assert_eq!(numbers(Tag::ModelPixelScaleTag), [0.004, 0.004, 0.0]);
        assert_eq!(numbers(Tag::ModelTiepointTag)[3..5], [412_345.25, 5_654_321.5]);
        let keys = decoder.get_tag_u16_vec(Tag::GeoKeyDirectoryTag).unwrap();
        assert_eq!((keys[..4].to_vec(), keys.len()), (vec![1, 1, 0, 4], 20));
        assert!(keys.chunks(4).any(|key| key == [3072, 0, 1, 25832]));
        assert_eq!(decoder.get_tag_u32_vec(Tag::XResolution).unwrap(), [317_500, 1000]);
    }

    #[test]
    fn a_png_has_the_same_pixels_and_its_resolution() {
        let folder = tempfile::tempdir().unwrap();
        let (rows, target) = (shaded(folder.path()), folder.path().join("wall.png"));
        write_png(&target, &rows, &PictureTags { dpi: 254.0, ..PictureTags::default() }).unwrap();
        let picture = image::open(&target).unwrap().to_rgba8();
        assert_eq!(picture.get_pixel(1, 2).0, [3, 2, 3, 253]);
        let reader = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&target).unwrap()));
        let dims = reader.read_info().unwrap().info().pixel_dims.unwrap();
        assert_eq!((dims.xppu, dims.yppu), (10_000, 10_000));
    }

    #[test]
    fn indices_become_their_colours() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("known.png");
        let picture =
            IndexedPicture { width: 2, indices: vec![0, 1, 1, 0], colours: vec![[1, 2, 3], [9, 8, 7]] };
        write_indexed_png(&target, &picture, "sources").unwrap();
        assert_eq!(image::open(&target).unwrap().to_rgb8().get_pixel(1, 0).0, [9, 8, 7]);
    }
}
