//! The streams of a chunk as bytes: plain, or packed with deflate.

use std::io::{Read, Write};

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;

use super::chunk_pixels::{ChunkPixels, Places, stream_sizes};
use super::header::ALIGNMENT;
use super::packing::Packing;
use super::prediction::{self, LevelPlanes};
use crate::Splat;

/// The level of deflate: 9 makes the file of a photo 3 % smaller and takes six times as long.
const COMPRESSION: u32 = 6;

/// Returns the bytes of a chunk.
///
/// # Errors
/// What was found, where a position has more depth pixels than the file can say.
pub(super) fn to_bytes(
    pixels: &ChunkPixels,
    width: u32,
    packing: Packing,
    planes: &LevelPlanes,
) -> Result<Vec<u8>, String> {
    let counts = pixels.places.counts(width)?;
    let mut bytes = Vec::new();
    let ChunkPixels { places, inverse_depths, colours, surfaces, splats } = pixels;
    if packing == Packing::Deflate {
        let streams = [
            counts,
            prediction::depth_bytes(places, surfaces, planes, inverse_depths),
            prediction::colour_bytes(places, surfaces, colours),
            prediction::surface_bytes(places, surfaces),
            prediction::splat_bytes(places, splats),
        ];
        streams.iter().for_each(|stream| add_packed(&mut bytes, stream));
        return Ok(bytes);
    }
    add(&mut bytes, counts);
    add(&mut bytes, inverse_depths.iter().flat_map(|depth| depth.to_le_bytes()));
    add(&mut bytes, colours.iter().flatten().copied());
    add(&mut bytes, surfaces.iter().flat_map(|surface| surface.to_le_bytes()));
    add(&mut bytes, splats.iter().map(|splat| splat.0));
    Ok(bytes)
}

/// Adds a stream and zeros up to a multiple of [`ALIGNMENT`].
fn add(bytes: &mut Vec<u8>, stream: impl IntoIterator<Item = u8>) {
    bytes.extend(stream);
    bytes.resize(bytes.len().next_multiple_of(ALIGNMENT), 0);
}

fn add_packed(bytes: &mut Vec<u8>, stream: &[u8]) {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(COMPRESSION));
    encoder.write_all(stream).expect("a vector takes every byte");
    let packed = encoder.finish().expect("a vector takes every byte");
    bytes.extend_from_slice(&(packed.len() as u64).to_le_bytes());
    add(bytes, packed);
}

/// Where a chunk is, and what the first line says of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct ChunkShape {
    pub first_row: u32,
    pub rows: u32,
    pub width: u32,
    pub depth_pixels: u64,
}

/// Returns the chunk that bytes hold; its content is not checked yet.
///
/// # Errors
/// What was found, and what was expected.
pub(super) fn from_bytes(
    bytes: &[u8],
    shape: ChunkShape,
    packing: Packing,
    planes: &LevelPlanes,
) -> Result<ChunkPixels, String> {
    let layered = u64::from(shape.width) * u64::from(shape.rows);
    let sizes = stream_sizes(layered, shape.depth_pixels).map(|size| size as usize);
    let mut rest = bytes;
    let mut streams = Vec::with_capacity(sizes.len());
    for size in sizes {
        streams.push(match packing {
            Packing::None => take(&mut rest, size)?.to_vec(),
            Packing::Deflate => take_packed(&mut rest, size)?,
        });
    }
    if !rest.is_empty() {
        return Err(format!("{} bytes after the last stream; expected none", rest.len()));
    }
    let counts = &streams[0];
    let sum: u64 = counts.iter().map(|count| u64::from(*count)).sum();
    if sum != shape.depth_pixels {
        return Err(format!("counts of {sum} depth pixels; expected {}", shape.depth_pixels));
    }
    let places = Places::of_counts(shape.first_row, shape.width, counts);
    Ok(match packing {
        Packing::None => plain(places, &streams),
        Packing::Deflate => predicted(places, &streams, planes),
    })
}

/// Takes a stream and what is between it and the next one.
fn take<'a>(rest: &mut &'a [u8], size: usize) -> Result<&'a [u8], String> {
    let padded = size.checked_next_multiple_of(ALIGNMENT).filter(|padded| *padded <= rest.len());
    let padded = padded.ok_or_else(|| format!("a stream of {size} bytes; only {} are left", rest.len()))?;
    let (stream, after) = rest.split_at(padded);
    *rest = after;
    Ok(&stream[..size])
}

/// Takes a packed stream of `size` unpacked bytes, which the first line justifies.
fn take_packed(rest: &mut &[u8], size: usize) -> Result<Vec<u8>, String> {
    let length = take(rest, size_of::<u64>())?.try_into().expect("that many bytes were taken");
    let length = usize::try_from(u64::from_le_bytes(length)).unwrap_or(usize::MAX);
    let packed = take(rest, length)?;
    let mut stream = Vec::with_capacity(size);
    // One byte more shows a stream that is too long.
    let read = ZlibDecoder::new(packed).take(size as u64 + 1).read_to_end(&mut stream);
    if let Err(error) = read {
        return Err(format!("a stream that cannot be unpacked: {error}"));
    }
    if stream.len() != size {
        return Err(format!("a stream of another size than {size} bytes unpacked"));
    }
    Ok(stream)
}

fn plain(places: Places, streams: &[Vec<u8>]) -> ChunkPixels {
    let [_, depths, colours, surfaces, splats] = streams else { return ChunkPixels::default() };
    ChunkPixels {
        places,
        inverse_depths: depths.as_chunks().0.iter().copied().map(f32::from_le_bytes).collect(),
        colours: colours.as_chunks().0.to_vec(),
        surfaces: surfaces.as_chunks().0.iter().copied().map(u16::from_le_bytes).collect(),
        splats: splats.iter().copied().map(Splat).collect(),
    }
}

fn predicted(places: Places, streams: &[Vec<u8>], planes: &LevelPlanes) -> ChunkPixels {
    let [_, depths, colours, surfaces, splats] = streams else { return ChunkPixels::default() };
    let surfaces = prediction::surfaces(&places, surfaces);
    ChunkPixels {
        inverse_depths: prediction::depths(&places, &surfaces, planes, depths),
        colours: prediction::colours(&places, &surfaces, colours),
        splats: prediction::splats(&places, splats),
        surfaces,
        places,
    }
}
