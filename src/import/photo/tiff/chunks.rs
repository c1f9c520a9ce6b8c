//! The strips and tiles of a TIFF: decompressed one at a time, and put into the picture.

use std::io::{Cursor, Read, Seek};

use flate2::read::ZlibDecoder;
use image::codecs::jpeg::JpegDecoder;
use image::{ColorType, ImageDecoder};
use weezl::{BitOrder, LzwStatus};

use super::directory::{Directory, TiffDefect};
use super::layout::{Colours, Compression, Layout};

/// A sample of a decoded picture.
pub trait ChannelSample: Copy + Default + TryFrom<u32> + Into<u32> {
    /// Full intensity.
    const FULL: u32;
}

impl ChannelSample for u8 {
    const FULL: u32 = 255;
}

impl ChannelSample for u16 {
    const FULL: u32 = 65535;
}

/// Reads the used samples of all pixels, interleaved; small depths of grey are spread over the range of `T`.
///
/// # Errors
/// A chunk is damaged, or needs more than `most` bytes.
pub fn samples<T: ChannelSample, R: Read + Seek>(
    file: &mut Directory<R>,
    layout: &Layout,
    most: u64,
) -> Result<Vec<T>, TiffDefect> {
    let (width, height) = (layout.width as usize, layout.height as usize);
    let [chunk_width, chunk_height] = layout.chunk.map(|side| side as usize);
    let row_bytes = layout.row_bytes().unwrap_or(usize::MAX);
    // The last strip has only the rows that are left; tiles are whole.
    let rows_of = |top: usize| if layout.is_tiled { chunk_height } else { chunk_height.min(height - top) };
    if (row_bytes as u64).saturating_mul(rows_of(0) as u64) > most {
        return Err(format!(
            "tiles of {chunk_width} x {chunk_height} pixels, larger than the picture allows"
        ));
    }
    let across = width.div_ceil(chunk_width);
    let per_plane = across * height.div_ceil(chunk_height);
    let spread = match (&layout.colours, layout.bits) {
        (Colours::Grey { .. }, bits @ (1 | 2 | 4)) => 255 / ((1 << bits) - 1),
        _ => 1,
    };
    let used = layout.used.len();
    let mut samples = vec![T::default(); width * height * used];
    for (index, place) in layout.places.iter().enumerate() {
        let plane = index / per_plane;
        // Where each used sample of a pixel is in the chunk, and in the result.
        let taken: Vec<(usize, usize)> = match layout.is_planar {
            false => layout.used.iter().copied().zip(0..).collect(),
            true => (0..used).filter(|at| layout.used[*at] == plane).map(|at| (0, at)).collect(),
        };
        if taken.is_empty() {
            continue;
        }
        let (left, top) =
            (index % per_plane % across * chunk_width, index % per_plane / across * chunk_height);
        let rows = rows_of(top);
        let mut bytes =
            decompressed(file, layout, *place, [chunk_width, rows], row_bytes * rows).map_err(|defect| {
                format!("{} {index}: {defect}", if layout.is_tiled { "tile" } else { "strip" })
            })?;
        if layout.differences {
            bytes.chunks_exact_mut(row_bytes).for_each(|row| add_up(row, layout, file.is_big_endian()));
        }
        for (row, y) in bytes.chunks_exact(row_bytes).zip(top..height) {
            for x in 0..chunk_width.min(width - left) {
                for &(from, to) in &taken {
                    let at = x * layout.samples_in_chunk() + from;
                    let value = sample(row, at, layout.bits, file.is_big_endian()) * spread;
                    // A sample has at most the bits of T, and spreading ends at its largest.
                    samples[(y * width + left + x) * used + to] = T::try_from(value).unwrap_or_default();
                }
            }
        }
    }
    Ok(samples)
}

/// Returns a sample of a row.
fn sample(row: &[u8], at: usize, bits: usize, big_endian: bool) -> u32 {
    match bits {
        8 => row[at].into(),
        16 => sixteen([row[2 * at], row[2 * at + 1]], big_endian).into(),
        _ => {
            let bit = at * bits;
            (u32::from(row[bit / 8]) >> (8 - bits - bit % 8)) & ((1 << bits) - 1)
        }
    }
}

fn sixteen(bytes: [u8; 2], big_endian: bool) -> u16 {
    if big_endian { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) }
}

/// Adds the differences of a row up.
fn add_up(row: &mut [u8], layout: &Layout, big_endian: bool) {
    let step = layout.samples_in_chunk();
    if layout.bits == 8 {
        for at in step..row.len() {
            row[at] = row[at].wrapping_add(row[at - step]);
        }
        return;
    }
    for at in step..row.len() / 2 {
        let of = |at: usize| sixteen([row[2 * at], row[2 * at + 1]], big_endian);
        let sum = of(at).wrapping_add(of(at - step));
        let bytes = if big_endian { sum.to_be_bytes() } else { sum.to_le_bytes() };
        row[2 * at..2 * at + 2].copy_from_slice(&bytes);
    }
}

/// Returns the `expected` bytes of a chunk of `size` pixels.
fn decompressed<R: Read + Seek>(
    file: &mut Directory<R>,
    layout: &Layout,
    (at, length): (u64, u64),
    size: [usize; 2],
    expected: usize,
) -> Result<Vec<u8>, TiffDefect> {
    let short = || "it ends before its pixels do".to_owned();
    if layout.compression == Compression::None {
        return if length < expected as u64 { Err(short()) } else { file.bytes_at(at, expected as u64) };
    }
    let stored = file.bytes_at(at, length)?;
    let mut bytes = vec![0; expected];
    match layout.compression {
        Compression::None => {}
        Compression::Deflate => {
            ZlibDecoder::new(stored.as_slice()).read_exact(&mut bytes).map_err(|_| short())?;
        }
        Compression::Lzw => lzw(&stored, &mut bytes).ok_or_else(short)?,
        Compression::PackBits => pack_bits(&stored, &mut bytes).ok_or_else(short)?,
        Compression::Jpeg(is_ycbcr) => jpeg(layout, &stored, is_ycbcr, size, &mut bytes)?,
    }
    Ok(bytes)
}

/// Decompresses LZW as TIFF 6.0 describes it; `None` where the code ends too early.
fn lzw(stored: &[u8], bytes: &mut [u8]) -> Option<()> {
    let mut decoder = weezl::decode::Decoder::with_tiff_size_switch(BitOrder::Msb, 8);
    let (mut read, mut written) = (0, 0);
    while written < bytes.len() {
        let step = decoder.decode_bytes(&stored[read..], &mut bytes[written..]);
        read += step.consumed_in;
        written += step.consumed_out;
        match step.status {
            Ok(LzwStatus::Ok) if step.consumed_in + step.consumed_out > 0 => {}
            _ => break,
        }
    }
    (written == bytes.len()).then_some(())
}

/// Decompresses PackBits: runs of equal bytes, and of others; `None` where the code ends too early.
fn pack_bits(stored: &[u8], bytes: &mut [u8]) -> Option<()> {
    let (mut read, mut written) = (stored.iter(), 0);
    while written < bytes.len() {
        let code = *read.next()? as i8;
        let rest = &mut bytes[written..];
        match code {
            i8::MIN => {}
            0.. => {
                let count = code as usize + 1;
                let from = read.as_slice().get(..count)?;
                let fits = count.min(rest.len());
                rest[..fits].copy_from_slice(&from[..fits]);
                read = read.as_slice()[count..].iter();
                written += fits;
            }
            _ => {
                let fits = (usize::from(code.unsigned_abs()) + 1).min(rest.len());
                rest[..fits].fill(*read.next()?);
                written += fits;
            }
        }
    }
    Some(())
}

/// Decodes a chunk that is a JPEG, whose tables may be those of the file.
fn jpeg(
    layout: &Layout,
    stored: &[u8],
    is_ycbcr: bool,
    size: [usize; 2],
    bytes: &mut [u8],
) -> Result<(), TiffDefect> {
    const START: [u8; 2] = [0xFF, 0xD8];
    // Adobe's marker, whose last byte says whether colours are YCbCr; without it decoders guess.
    const ADOBE: [u8; 15] = *b"\xFF\xEE\x00\x0EAdobe\x00\x64\x00\x00\x00\x00";
    let tables = layout.jpeg_tables.strip_prefix(&START).and_then(|it| it.strip_suffix(&[0xFF, 0xD9]));
    let body = stored.strip_prefix(&START).ok_or("it is not a JPEG")?;
    let stream = [&START[..], &ADOBE, &[u8::from(is_ycbcr)], tables.unwrap_or_default(), body].concat();
    let decoder = JpegDecoder::new(Cursor::new(stream)).map_err(|error| error.to_string())?;
    let channels = if layout.samples == 1 { ColorType::L8 } else { ColorType::Rgb8 };
    let (width, height) = decoder.dimensions();
    if (width as usize, decoder.color_type()) != (size[0], channels) || (height as usize) < size[1] {
        return Err(format!("a JPEG of {width} x {height} pixels in a chunk of {} x {}", size[0], size[1]));
    }
    let mut pixels = vec![0; width as usize * height as usize * layout.samples];
    decoder.read_image(&mut pixels).map_err(|error| error.to_string())?;
    bytes.copy_from_slice(&pixels[..bytes.len()]);
    Ok(())
}
