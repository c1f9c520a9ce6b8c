//! Reads the pixels of a layer or mask: a table of tiles of 64 x 64 pixels, encoded in one of three ways.

use std::sync::Arc;

use flate2::{Decompress, FlushDecompress, Status};
use rayon::prelude::*;

use super::head::XcfHeader;
use super::pointer;
use super::precision::{Precision, SampleKind};
use crate::bytes::FileBytes;
use crate::xcf::tiles::{TILE, unpack};
use crate::{Depth, Grey, Raster, StoredColours};
use quadratura_base::error::Result;
use quadratura_base::scene::Samples;
use quadratura_files::hash::Hashing;

/// The meaning of the samples of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelModel {
    Rgb,
    Rgba,
    Grey,
    GreyAlpha,
    Indexed,
    IndexedAlpha,
    Mask,
}

impl PixelModel {
    /// Returns the model of a number in a layer's head.
    pub fn from_kind(kind: u32) -> Option<Self> {
        [Self::Rgb, Self::Rgba, Self::Grey, Self::GreyAlpha, Self::Indexed, Self::IndexedAlpha]
            .get(kind as usize)
            .copied()
    }

    /// Returns the colours that pixels of this model can have.
    pub fn colours(self) -> StoredColours {
        match self {
            Self::Rgb | Self::Rgba => StoredColours::Full,
            Self::Grey | Self::GreyAlpha | Self::Mask => StoredColours::Grey,
            Self::Indexed | Self::IndexedAlpha => StoredColours::Palette,
        }
    }

    fn samples(self) -> usize {
        match self {
            Self::Rgb => 3,
            Self::Rgba => 4,
            Self::GreyAlpha | Self::IndexedAlpha => 2,
            Self::Grey | Self::Indexed | Self::Mask => 1,
        }
    }
}

/// The compression method of tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TileCompression {
    None,
    Rle,
    Zlib,
}

/// The positions of a drawable's tiles.
#[derive(Debug, Clone)]
pub struct TileTable {
    bytes: Arc<FileBytes>,
    /// Position of the first pointer.
    at: u64,
    /// Position of the next level, which follows the last tile as GIMP writes it; else the file's end.
    end: u64,
    width: u32,
    height: u32,
    wide: bool,
    model: PixelModel,
    precision: Precision,
    compression: TileCompression,
    colours: Arc<[[u8; 3]]>,
}

/// The precision with which GIMP 2.10 stores 16 bits.
const PLAIN_16: Precision = Precision { kind: SampleKind::U16, linear: false, big_endian: true };

/// Position and length of a tile's code, in bytes.
type TileCode = (u64, u64);

impl TileTable {
    /// Reads the table from the hierarchy at byte `place`, of a drawable of `size`.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] when the drawable has another size, or more tiles than the file can hold.
    pub fn find(
        bytes: &Arc<FileBytes>,
        position: u64,
        (width, height): (u32, u32),
        model: PixelModel,
        head: &XcfHeader,
        compression: u8,
    ) -> Result<Self> {
        let compression = match compression {
            0 => TileCompression::None,
            1 => TileCompression::Rle,
            2 => TileCompression::Zlib,
            other => return Err(bytes.damaged(position, format!("compression {other}, expected 0, 1 or 2"))),
        };
        let mut cursor = bytes.cursor(position);
        let found = (cursor.u32()?, cursor.u32()?, cursor.u32()?);
        let expected = (width, height, (model.samples() * head.precision.bytes()) as u32);
        if found != expected {
            let what = |(w, h, b)| format!("{w} x {h} pixels of {b} bytes");
            return Err(bytes.damaged(position, format!("{}, expected {}", what(found), what(expected))));
        }
        let level = pointer(&mut cursor, head.wide)?;
        let next = if level == 0 { 0 } else { pointer(&mut cursor, head.wide).unwrap_or(0) };
        let end = if next > level { next } else { bytes.length() };
        let mut cursor = bytes.cursor(level);
        let found = (cursor.u32()?, cursor.u32()?);
        if found != (width, height) {
            let (w, h) = found;
            let found = format!("a level of {w} x {h} pixels, expected {width} x {height}");
            return Err(bytes.damaged(level, found));
        }
        let at = cursor.at();
        let wide = head.wide;
        let precision = head.precision;
        let (bytes, colours) = (bytes.clone(), Arc::from([]));
        let table = Self { bytes, at, end, width, height, wide, model, precision, compression, colours };
        table.check_size()?;
        Ok(table)
    }

    /// Sets the colour map of an indexed drawable.
    pub fn with_colours(self, colours: &Arc<[[u8; 3]]>) -> Self {
        Self { colours: colours.clone(), ..self }
    }

    /// Checks the number of tiles against the file's size before memory is allocated: every tile takes a
    /// pointer and some code.
    fn check_size(&self) -> Result<()> {
        let shortest = match self.compression {
            TileCompression::None => 1, // beyond that, each is checked when it is read
            TileCompression::Rle => 2 * self.bytes_per_pixel() as u64,
            TileCompression::Zlib => 8,
        };
        let needed = self.count().saturating_mul(self.pointer_bytes() + shortest);
        if needed > self.bytes.length() {
            let found = format!("{} tiles in a file of {} bytes", self.count(), self.bytes.length());
            return Err(self.bytes.damaged(self.at, found));
        }
        Ok(())
    }

    fn pointer_bytes(&self) -> u64 {
        if self.wide { 8 } else { 4 }
    }

    fn bytes_per_pixel(&self) -> usize {
        self.model.samples() * self.precision.bytes()
    }

    fn count(&self) -> u64 {
        u64::from(self.width.div_ceil(TILE)) * u64::from(self.height.div_ceil(TILE))
    }

    /// Reads the pixels of a layer.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] with the position of the damaged tile; [`quadratura_base::Error::Io`].
    pub fn raster(&self) -> Result<Raster> {
        let samples = match self.precision.depth() {
            Depth::Eight => Samples::U8(self.rgba8()?),
            Depth::Sixteen => Samples::U16(self.rgba16()?),
        };
        Ok(Raster::new(self.width, self.height, samples))
    }

    fn rgba8(&self) -> Result<Vec<u8>> {
        match self.model {
            PixelModel::Rgba => self.filled(4, |pixel, out| out.copy_from_slice(pixel)),
            PixelModel::Rgb => self.filled(4, |pixel, out| {
                out[..3].copy_from_slice(pixel);
                out[3] = u8::MAX;
            }),
            PixelModel::Grey | PixelModel::GreyAlpha | PixelModel::Mask => self.filled(4, |pixel, out| {
                out[..3].fill(pixel[0]);
                out[3] = pixel.get(1).copied().unwrap_or(u8::MAX);
            }),
            PixelModel::Indexed | PixelModel::IndexedAlpha => self.filled(4, |pixel, out| {
                let colour = self.colours.get(usize::from(pixel[0])).copied().unwrap_or_default();
                out[..3].copy_from_slice(&colour);
                out[3] = pixel.get(1).copied().unwrap_or(u8::MAX);
            }),
        }
    }

    fn rgba16(&self) -> Result<Vec<u16>> {
        let (precision, step) = (self.precision, self.precision.bytes());
        let colour = move |sample: &[u8]| precision.sample16(sample, precision.linear);
        let alpha = move |sample: Option<&[u8]>| sample.map_or(u16::MAX, |s| precision.sample16(s, false));
        match self.model {
            // The most common case, without a decision for every sample.
            PixelModel::Rgba if precision == PLAIN_16 => self.filled(4, |pixel, out| {
                let samples = pixel.as_chunks().0.iter().map(|bytes| u16::from_be_bytes(*bytes));
                out.iter_mut().zip(samples).for_each(|(to, sample)| *to = sample);
            }),
            PixelModel::Rgb | PixelModel::Rgba => self.filled(4, |pixel, out| {
                let mut samples = pixel.chunks_exact(step);
                out.iter_mut().zip(samples.by_ref().take(3)).for_each(|(to, from)| *to = colour(from));
                out[3] = alpha(samples.next());
            }),
            PixelModel::Grey | PixelModel::GreyAlpha | PixelModel::Mask => self.filled(4, |pixel, out| {
                out[..3].fill(colour(&pixel[..step]));
                out[3] = alpha(pixel.get(step..));
            }),
            // GIMP has indexed images in 8 bits only.
            PixelModel::Indexed | PixelModel::IndexedAlpha => {
                Err(self.bytes.damaged(self.at, "an indexed image of more than 8 bits"))
            }
        }
    }

    /// Reads the samples of a mask, which never have a tone curve.
    ///
    /// # Errors
    /// As [`Self::raster`].
    pub fn grey(&self) -> Result<Grey> {
        let precision = self.precision;
        let samples = match precision.depth() {
            Depth::Eight => Samples::U8(self.filled(1, |pixel, out| out[0] = pixel[0])?),
            Depth::Sixteen => {
                Samples::U16(self.filled(1, |pixel, out| out[0] = precision.sample16(pixel, false))?)
            }
        };
        Ok(Grey::new(self.width, self.height, samples))
    }

    /// Decodes all tiles, row by row in parallel, with `per_pixel` samples for each pixel, which `put` makes
    /// of its bytes.
    fn filled<T: Copy + Default + Send>(
        &self,
        per_pixel: usize,
        put: impl Fn(&[u8], &mut [T]) + Sync,
    ) -> Result<Vec<T>> {
        let codes = self.codes()?;
        let row = per_pixel * self.width as usize;
        let mut samples = vec![T::default(); row * self.height as usize];
        let columns = self.width.div_ceil(TILE).max(1) as usize;
        let rows = samples.par_chunks_mut((row * TILE as usize).max(1)).zip(codes.par_chunks(columns));
        rows.try_for_each_init(Decoder::default, |decoder, (samples, codes)| {
            let height = samples.len() / row;
            for (column, code) in codes.iter().enumerate() {
                let left = column * TILE as usize;
                let width = (self.width as usize - left).min(TILE as usize);
                let tile = self.tile(*code, width * height, decoder)?;
                let lines = tile.chunks_exact(width * self.bytes_per_pixel());
                for (line, samples) in lines.zip(samples.chunks_exact_mut(row)) {
                    let out = samples[left * per_pixel..].chunks_exact_mut(per_pixel);
                    line.chunks_exact(self.bytes_per_pixel()).zip(out).for_each(|(p, o)| put(p, o));
                }
            }
            Ok(())
        })?;
        Ok(samples)
    }

    /// Returns position and length of each tile's code: up to the next tile, where that follows as GIMP
    /// writes it, else the maximum length of a tile.
    fn codes(&self) -> Result<Vec<TileCode>> {
        let table = self.bytes.read(self.at, self.count() * self.pointer_bytes())?;
        let number = |bytes: &[u8]| bytes.iter().fold(0, |number, byte| number << 8 | u64::from(*byte));
        let places: Vec<u64> = table.chunks_exact(self.pointer_bytes() as usize).map(number).collect();
        // GIMP allows one and a half times the size of the pixels.
        let most = 3 * self.bytes_per_pixel() as u64 * u64::from(TILE * TILE) / 2;
        let following = places.iter().skip(1).map(Some).chain([None]);
        let lengths = places.iter().zip(following).map(|(position, next)| {
            let gap =
                next.and_then(|next| next.checked_sub(*position)).filter(|gap| (1..=most).contains(gap));
            let to_end = if *position < self.end {
                self.end - position
            } else {
                self.bytes.length().saturating_sub(*position)
            };
            gap.unwrap_or(most).min(to_end)
        });
        Ok(places.iter().copied().zip(lengths).collect())
    }

    /// Returns a hash of the code of all tiles; equal hashes mean equal pixels.
    ///
    /// # Errors
    /// The errors of reading the file.
    pub fn hash_of_code(&self) -> Result<String> {
        let mut hashing = Hashing::default();
        let size = (self.width, self.height);
        let how = format!("{size:?} {:?} {:?} {:?}", self.model, self.precision, self.compression);
        hashing.add(how.as_bytes());
        hashing.add(self.colours.as_flattened());
        for (at, length) in self.codes()? {
            hashing.add(&self.bytes.read(at, length)?);
        }
        Ok(hashing.hash())
    }

    /// Decodes a tile, pixel by pixel.
    fn tile<'d>(&self, (at, length): TileCode, pixels: usize, decoder: &'d mut Decoder) -> Result<&'d [u8]> {
        let size = pixels * self.bytes_per_pixel();
        let code = self.bytes.read(at, length)?;
        decoder.tile.resize(size, 0);
        let whole = match self.compression {
            TileCompression::None => {
                code.get(..size).map(|code| decoder.tile.copy_from_slice(code)).is_some()
            }
            TileCompression::Rle => {
                unpack(&code, &mut decoder.tile, self.bytes_per_pixel(), &mut decoder.planes)
            }
            TileCompression::Zlib => decoder.inflate(&code),
        };
        if !whole {
            let found = format!("a tile whose code does not give {size} bytes");
            return Err(self.bytes.damaged(at, found));
        }
        Ok(&decoder.tile)
    }
}

/// Memory that is reused from tile to tile.
#[derive(Default)]
struct Decoder {
    tile: Vec<u8>,
    planes: Vec<u8>,
    zlib: Option<Decompress>,
}

impl Decoder {
    /// Inflates a tile's code; false if it does not give the whole tile.
    fn inflate(&mut self, code: &[u8]) -> bool {
        const WITH_HEADER: bool = true;
        let zlib = self.zlib.get_or_insert_with(|| Decompress::new(WITH_HEADER));
        zlib.reset(WITH_HEADER);
        let status = zlib.decompress(code, &mut self.tile, FlushDecompress::Finish);
        matches!(status, Ok(Status::StreamEnd | Status::Ok | Status::BufError))
            && zlib.total_out() == self.tile.len() as u64
    }
}
