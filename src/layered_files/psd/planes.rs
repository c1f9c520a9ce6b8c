//! Compresses a raster's channels as PSD stores them: one after the other, each row separately in PackBits.

use std::io::Write;

use rayon::prelude::*;

use super::packbits::{longest_code, pack_row};
use super::variant::PsdVariant;
use crate::raster::Raster;
use quadratura_base::scene::Samples;

/// Number of rows that one thread compresses at a time.
const BAND: u32 = 64;

/// Compressed channels of a raster.
pub struct Planes {
    /// Bands of rows, from the top.
    bands: Vec<PlaneBand>,
    /// The channels of a pixel that were compressed: 0 red, 1 green, 2 blue, 3 alpha.
    channels: Vec<usize>,
}

/// Neighbouring rows: the code of each channel, and the length of each row's code.
struct PlaneBand {
    codes: Vec<Vec<u8>>,
    lengths: Vec<Vec<u32>>,
}

impl Planes {
    /// Compresses the given channels of each pixel (0 red, 1 green, 2 blue, 3 alpha), in that order.
    pub fn new(raster: &Raster, channels: &[usize]) -> Self {
        let starts = (0..raster.height().div_ceil(BAND)).into_par_iter();
        let bands = starts.map(|i| PlaneBand::new(raster, channels, i * BAND)).collect();
        Self { bands, channels: channels.to_vec() }
    }

    /// Returns the number of bytes that [`Self::write_channel`] will write.
    pub fn channel_length(&self, channel: usize, kind: PsdVariant) -> u64 {
        2 + self.counts_length(channel, kind) + self.code_length(channel)
    }

    /// Writes one channel, by its index in the list, as a layer stores it: the compression method, the
    /// lengths of all rows, the code.
    pub fn write_channel(
        &self,
        channel: usize,
        kind: PsdVariant,
        out: &mut impl Write,
    ) -> std::io::Result<()> {
        out.write_all(&RLE.to_be_bytes())?;
        self.write_counts(channel, kind, out)?;
        self.write_code(channel, out)
    }

    /// Writes all channels as a merged picture stores them: the lengths of all of them first.
    pub fn write_merged(&self, kind: PsdVariant, out: &mut impl Write) -> std::io::Result<()> {
        out.write_all(&RLE.to_be_bytes())?;
        let channels = 0..self.channels.len();
        channels.clone().try_for_each(|channel| self.write_counts(channel, kind, out))?;
        channels.clone().try_for_each(|channel| self.write_code(channel, out))
    }

    fn counts_length(&self, channel: usize, kind: PsdVariant) -> u64 {
        let rows: usize = self.bands.iter().map(|band| band.lengths[channel].len()).sum();
        rows as u64 * if kind == PsdVariant::Psb { 4 } else { 2 }
    }

    fn code_length(&self, channel: usize) -> u64 {
        self.bands.iter().map(|band| band.codes[channel].len() as u64).sum()
    }

    fn write_counts(&self, channel: usize, kind: PsdVariant, out: &mut impl Write) -> std::io::Result<()> {
        let lengths = self.bands.iter().flat_map(|band| &band.lengths[channel]);
        let bytes: Vec<u8> = match kind {
            // A PSD is at most 30,000 pixels wide: rows of 60,000 bytes with their headers fit 16 bits.
            PsdVariant::Psd => lengths.flat_map(|length| (*length as u16).to_be_bytes()).collect(),
            PsdVariant::Psb => lengths.flat_map(|length| length.to_be_bytes()).collect(),
        };
        out.write_all(&bytes)
    }

    fn write_code(&self, channel: usize, out: &mut impl Write) -> std::io::Result<()> {
        self.bands.iter().try_for_each(|band| out.write_all(&band.codes[channel]))
    }
}

/// The number of this compression method.
const RLE: u16 = 1;

impl PlaneBand {
    fn new(raster: &Raster, channels: &[usize], top: u32) -> Self {
        let bottom = (top + BAND).min(raster.height());
        let row_samples = 4 * raster.width() as usize;
        let rows = top as usize * row_samples..bottom as usize * row_samples;
        let size = (bottom - top) as usize * longest_code(raster.width() as usize) / 2;
        let mut band = Self {
            codes: channels.iter().map(|_| Vec::with_capacity(size)).collect(),
            lengths: channels.iter().map(|_| Vec::with_capacity(BAND as usize)).collect(),
        };
        match raster.samples() {
            Samples::U8(s) => band.pack(channels, &s[rows], row_samples, |sample| [sample]),
            Samples::U16(s) => band.pack(channels, &s[rows], row_samples, u16::to_be_bytes),
        }
        band
    }

    fn pack<T: Copy, const BYTES: usize>(
        &mut self,
        channels: &[usize],
        rows: &[T],
        row_samples: usize,
        bytes_of: impl Fn(T) -> [u8; BYTES],
    ) {
        let mut plane = vec![[0; BYTES]; row_samples / 4];
        for row in rows.chunks_exact(row_samples.max(1)) {
            let (pixels, _) = row.as_chunks::<4>();
            for (index, channel) in channels.iter().enumerate() {
                plane.iter_mut().zip(pixels).for_each(|(to, pixel)| *to = bytes_of(pixel[*channel]));
                self.lengths[index].push(pack_row(plane.as_flattened(), &mut self.codes[index]) as u32);
            }
        }
    }
}
