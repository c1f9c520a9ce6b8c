//! Reads channels of a PSD: uncompressed, in PackBits row by row, or deflated, with or without prediction.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::records::ChannelPosition;
use crate::Depth;
use crate::bytes::FileBytes;
use crate::inflate::can_inflate_to;
use crate::psd::packbits::{shortest_code, unpack_row};
use crate::psd::variant::PsdVariant;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Samples;
use quadratura_files::hash::Hashing;

/// The properties that all channels of a document share.
#[derive(Debug, Clone, Copy)]
pub struct Coding {
    pub kind: PsdVariant,
    pub depth: Depth,
}

// Numbers of the compression methods.
const RAW: u16 = 0;
const RLE: u16 = 1;
const ZIP: u16 = 2;
const ZIP_PREDICTED: u16 = 3;

/// Reads a channel of `width` x `height` samples.
///
/// # Errors
/// [`Error::Input`] with the position when its code does not produce that many samples; [`Error::Io`].
pub fn read_plane(
    bytes: &FileBytes,
    channel: ChannelPosition,
    width: u32,
    height: u32,
    coding: Coding,
) -> Result<Samples> {
    if width == 0 || height == 0 {
        return Ok(blank(coding.depth));
    }
    if channel.length < 2 {
        let found = format!("a channel of {} bytes for {width} x {height} pixels", channel.length);
        return Err(bytes.damaged(channel.at, found));
    }
    let kind = bytes.cursor(channel.at).u16()?;
    let code = ChannelCode { bytes, at: channel.at + 2, length: channel.length - 2 };
    let row = u64::from(width) * coding.depth.bytes();
    let samples = match kind {
        RAW => code.raw(row * u64::from(height))?,
        RLE => code.unpacked(row, height, coding.kind)?,
        ZIP | ZIP_PREDICTED => code.inflated(row * u64::from(height))?,
        other => {
            let found = format!("compression {other}, expected 0 to 3");
            return Err(bytes.damaged(channel.at, found));
        }
    };
    Ok(match coding.depth {
        Depth::Eight => Samples::U8(summed(samples, width, kind, u8::wrapping_add)),
        Depth::Sixteen => {
            let (pairs, _) = samples.as_chunks::<2>();
            let wide: Vec<u16> = pairs.iter().map(|pair| u16::from_be_bytes(*pair)).collect();
            Samples::U16(summed(wide, width, kind, u16::wrapping_add))
        }
    })
}

/// Returns a hash of the channels' code: equal hashes mean that [`read_plane`] returns the same.
///
/// # Errors
/// The errors of reading the file.
pub fn hash_of_code(
    bytes: &FileBytes,
    channels: &[ChannelPosition],
    (width, height): (u32, u32),
    coding: Coding,
) -> Result<String> {
    let mut hashing = Hashing::default();
    hashing.add(format!("{width} x {height} {coding:?}").as_bytes());
    for channel in channels {
        hashing.add(&channel.id.to_be_bytes());
        hashing.add(&bytes.read(channel.at, channel.length)?);
    }
    Ok(hashing.hash())
}

fn blank(depth: Depth) -> Samples {
    match depth {
        Depth::Eight => Samples::U8(Vec::new()),
        Depth::Sixteen => Samples::U16(Vec::new()),
    }
}

/// Decodes predicted samples, which are differences to the sample on the left.
fn summed<T: Copy>(mut samples: Vec<T>, width: u32, kind: u16, add: impl Fn(T, T) -> T) -> Vec<T> {
    if kind == ZIP_PREDICTED {
        for row in samples.chunks_exact_mut(width as usize) {
            for i in 1..row.len() {
                row[i] = add(row[i], row[i - 1]);
            }
        }
    }
    samples
}

/// The code of a channel.
struct ChannelCode<'f> {
    bytes: &'f FileBytes,
    at: u64,
    length: u64,
}

impl ChannelCode<'_> {
    fn raw(&self, expected: u64) -> Result<Vec<u8>> {
        if self.length < expected {
            return Err(self.too_short(expected));
        }
        self.bytes.read(self.at, expected)
    }

    fn unpacked(&self, row: u64, height: u32, kind: PsdVariant) -> Result<Vec<u8>> {
        let width_of_count = if kind == PsdVariant::Psb { 4 } else { 2 };
        let counts = u64::from(height) * width_of_count;
        let shortest = counts + u64::from(height) * shortest_code(row);
        if self.length < shortest {
            return Err(self.too_short(shortest));
        }
        let code = self.bytes.read(self.at, self.length)?;
        let (counts, mut code) = code.split_at(counts as usize);
        let mut counts = counts.chunks_exact(width_of_count as usize).map(count);
        let mut samples = vec![0; (row * u64::from(height)) as usize];
        for (y, samples) in samples.chunks_exact_mut(row as usize).enumerate() {
            let here = counts.next().and_then(|count| code.split_at_checked(count));
            let unpacked = here.filter(|(here, _)| unpack_row(here, samples));
            code = unpacked.ok_or_else(|| self.wrong(format!("row {y} has no valid PackBits code")))?.1;
        }
        Ok(samples)
    }

    fn inflated(&self, expected: u64) -> Result<Vec<u8>> {
        if !can_inflate_to(self.length, expected) {
            return Err(self.too_short(expected));
        }
        let code = self.bytes.read(self.at, self.length)?;
        let mut samples = vec![0; expected as usize];
        let read = ZlibDecoder::new(&code[..]).read_exact(&mut samples);
        read.map_err(|error| self.wrong(format!("the code cannot be inflated ({error})")))?;
        Ok(samples)
    }

    fn too_short(&self, expected: u64) -> Error {
        self.wrong(format!("{} bytes, expected at least {expected}", self.length))
    }

    fn wrong(&self, found: String) -> Error {
        self.bytes.damaged(self.at, format!("a channel's code: {found}"))
    }
}

fn count(bytes: &[u8]) -> usize {
    bytes.iter().fold(0, |number, byte| number << 8 | usize::from(*byte))
}
