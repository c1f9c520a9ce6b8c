//! Pass *pairs* (`shaders/pairs.wgsl`): the table of occlusions, counted into a hash table on the device and
//! decoded here. Rows that would take the device too long without a pause are left to the processor ([`pair_slices`]).
//!
//! A pair of numbers below 2^20 is a number of 40 bits, which a Feistel network scatters invertibly. The slot
//! then encodes some of its bits, and a tag of 32 bits encodes the others and the distance from the pair's
//! first slot. So comparing and exchanging one word is enough, and no key is stored.

use std::ops::Range;

use wgpu::{BindGroupLayout, Buffer, CommandEncoder, ComputePipeline, ShaderStages};

use super::bindings::{self, BindingKind};
use super::device::Gpu;
use super::frame::{self, BoundRows, PhotoRows};
use super::readback;
use super::workspace::Workspace;
use quadratura_base::error::{Error, Result};
use quadratura_layers::Occlusion;
use quadratura_layers::rasteriser::Band;

/// The WGSL source of the pass.
pub const SOURCE: &str = include_str!("../../shaders/pairs.wgsl");

/// The number of bits of each number of a pair.
pub const HALF_BITS: u32 = 20;

const HALF: u32 = (1 << HALF_BITS) - 1;

/// The number of bits of a tag that count probes.
pub(super) const PROBE_BITS: u32 = 7;

/// The number of pixels of a row that one invocation processes.
pub(super) const RUN: u32 = 64;

/// The number of invocations in a workgroup, which are one below the other.
pub(super) const WORKGROUP: u32 = 64;

/// The most comparisons of two fragments that one invocation makes, a tenth of a second or so. It makes them one after the other, and
/// what goes on for seconds can cost the device, and with it all of the program's work on it (docs/quality.md).
const MOST_OF_RUN: u64 = 1 << 17;

/// About the most comparisons that are handed to the device at once, for the same reason.
const MOST_AT_ONCE: u64 = 1 << 27;

/// The least number of bits of a table: a tag then holds 40 - 16 bits of a pair, and the probes.
const LEAST_BITS: u32 = 16;

/// Returns the initial size of the table for this many items, each of which occludes few others; as a binary
/// logarithm.
pub fn table_bits(gpu: &Gpu, items: usize) -> u32 {
    (16 * items.max(1)).ilog2().max(LEAST_BITS).min(largest_bits(gpu))
}

/// Rows whose pairs are counted together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PairSlice {
    /// The rows of the photo.
    pub rows: Range<u32>,
    /// True where the device would take too long without a pause.
    pub on_processor: bool,
}

/// Divides the rows of lists, `width` pixels wide, into slices, from the top. Pixels with the same entries count as if they had others:
/// slices take less time than they might, and some rows are the processor's that the device could count.
pub fn pair_slices(width: u32, lists: &Band) -> Vec<PairSlice> {
    let mut slices: Vec<PairSlice> = Vec::new();
    let mut comparisons = 0;
    for (row, offsets) in
        (lists.y0..lists.y1).zip(lists.offsets.windows(width as usize + 1).step_by(width as usize))
    {
        let sizes = offsets.windows(2).map(|ends| u64::from(ends[1] - ends[0]));
        let pairs: Vec<u64> = sizes.map(|size| size * size.saturating_sub(1) / 2).collect();
        let largest = pairs.chunks(RUN as usize).map(|run| run.iter().sum::<u64>()).max().unwrap_or_default();
        let (on_processor, of_row) = (largest > MOST_OF_RUN, pairs.iter().sum::<u64>());
        comparisons += of_row;
        match slices.last_mut() {
            Some(last)
                if last.on_processor == on_processor && (on_processor || comparisons <= MOST_AT_ONCE) =>
            {
                last.rows.end = row + 1;
            }
            _ => {
                comparisons = of_row;
                slices.push(PairSlice { rows: row..row + 1, on_processor });
            }
        }
    }
    slices
}

/// A hash table of 2^bits slots on the device.
#[derive(Debug)]
pub struct PairTable {
    tags: Buffer,
    pixels: Buffer,
    overflow: Buffer,
    bits: u32,
}

impl PairTable {
    /// Creates an empty table of 2^`bits` slots.
    ///
    /// # Errors
    /// [`Error::Gpu`] when the device cannot bind a table of this size.
    pub fn new(gpu: &Gpu, bits: u32) -> Result<Self> {
        if bits > largest_bits(gpu) {
            return Err(Error::Gpu(format!(
                "the pairs of faces that occlude each other in one photo need a table of 2^{bits} slots, \
                 more than {} binds; simplify the model, or make the photo smaller",
                gpu.adapter_summary()
            )));
        }
        let buffer = |name, words| bindings::storage(gpu, name, words, true);
        let (tags, pixels) = (buffer("tags", 1 << bits), buffer("pixels of pairs", 1 << bits));
        Ok(Self { tags, pixels, overflow: buffer("overflow", 1), bits })
    }

    /// Reads the pairs of the table, in no particular order; `None` when some pairs found no slot. `items`
    /// maps numbers to items.
    pub fn read(&self, gpu: &Gpu, items: &[u32]) -> Result<Option<Vec<Occlusion>>> {
        let slots = 0..1 << self.bits;
        let wanted = [(&self.tags, slots.clone()), (&self.pixels, slots), (&self.overflow, 0..1)];
        let [tags, pixels, overflow] = readback::read(gpu, wanted)?;
        if overflow[0] != 0 {
            return Ok(None);
        }
        let occlusion = |(at, (&tag, &px)): (usize, (&u32, &u32))| {
            let (front, back) = pair_at(self.bits, at as u32, tag);
            Occlusion { front: items[front as usize], back: items[back as usize], px }
        };
        let taken = tags.iter().zip(&pixels).enumerate().filter(|(_, (tag, _))| **tag != 0);
        Ok(Some(taken.map(occlusion).collect()))
    }
}

fn largest_bits(gpu: &Gpu) -> u32 {
    (gpu.largest_binding() / 4).ilog2().min(2 * HALF_BITS - 8)
}

/// Decodes the pair of numbers whose tag is in slot `at` of 2^bits.
fn pair_at(bits: u32, at: u32, tag: u32) -> (u32, u32) {
    let (rest, probe) = ((tag - 1) >> PROBE_BITS, (tag - 1) & ((1 << PROBE_BITS) - 1));
    let slot = at.wrapping_sub(probe) & ((1 << bits) - 1);
    let left = 2 * HALF_BITS - bits;
    let scattered = (u64::from(slot) << left) | u64::from(rest);
    gather((scattered >> HALF_BITS) as u32, scattered as u32 & HALF)
}

/// Inverts the shader's `scatter`.
fn gather(mut one: u32, mut other: u32) -> (u32, u32) {
    for turn in (0..4).rev() {
        (one, other) = (other ^ stir(one, turn), one);
    }
    (one, other)
}

/// Computes the same as the shader's `stir`.
fn stir(half: u32, turn: u32) -> u32 {
    let h = half.wrapping_add(turn.wrapping_mul(0x9e37_79b9)).wrapping_mul(0x85eb_ca6b);
    let h = (h ^ (h >> 15)).wrapping_mul(0xc2b2_ae35);
    (h ^ (h >> 13)) & HALF
}

/// The pipeline of the pass.
#[derive(Debug)]
pub struct Pairs {
    own: BindGroupLayout,
    pairs: ComputePipeline,
}

impl Pairs {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu, frame: &BindGroupLayout) -> Self {
        let kinds = [
            BindingKind::Read,
            BindingKind::Read,
            BindingKind::Write,
            BindingKind::Write,
            BindingKind::Write,
        ];
        let own = bindings::layout(gpu, "pairs", ShaderStages::COMPUTE, &kinds);
        let module = bindings::shader(gpu, "pairs", &[frame::SOURCE, SOURCE].concat());
        Self { pairs: bindings::compute(gpu, "pairs", &module, &[frame, &own]), own }
    }

    /// Records the pass: it counts the pairs of the frame's rows, whose lists are in the workspace.
    pub fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        space: &Workspace,
        bound: BoundRows,
        table: &PairTable,
    ) {
        let resources = [
            space.places_of(bound.rows),
            space.entries.as_entire_binding(),
            table.tags.as_entire_binding(),
            table.pixels.as_entire_binding(),
            table.overflow.as_entire_binding(),
        ];
        let own = bindings::bind(gpu, "pairs", &self.own, &resources);
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pairs);
        pass.set_bind_group(0, bound.group, &[]);
        pass.set_bind_group(1, &own, &[]);
        let PhotoRows { size, rows, .. } = bound.rows;
        pass.dispatch_workgroups(size[0].div_ceil(RUN), (rows.len() as u32).div_ceil(WORKGROUP), 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Computes the same as the shader's `scatter`.
    fn scatter(front: u32, back: u32) -> (u32, u32) {
        (0..4).fold((front, back), |(one, other), turn| (other, one ^ stir(other, turn)))
    }

    /// Returns lists of rows, each with the number of entries of all its pixels.
    fn lists(width: usize, of_rows: &[u32]) -> Band {
        let sizes = of_rows.iter().flat_map(|size| std::iter::repeat_n(*size, width));
        let mut end = 0;
        let ends = sizes.map(|size| {
            end += size;
            end
        });
        let offsets = std::iter::once(0).chain(ends).collect();
        Band { y0: 10, y1: 10 + of_rows.len() as u32, offsets, entries: vec![0; end as usize] }
    }

    #[test]
    fn rows_with_more_pairs_than_the_device_counts_in_one_go_are_the_processors() {
        let slice = |rows: Range<u32>, on_processor| PairSlice { rows, on_processor };
        // 64 pixels of 64 entries have 129,024 pairs, of 65 entries 133,120.
        let found = pair_slices(100, &lists(100, &[64, 64, 65, 200, 0, 3]));
        assert_eq!(found, [slice(10..12, false), slice(12..14, true), slice(14..16, false)]);
        assert_eq!(pair_slices(100, &lists(100, &[])), []);
    }

    #[test]
    fn rows_are_handed_over_in_slices_of_a_bounded_number_of_pairs() {
        // 2 million pairs a row.
        let found = pair_slices(1000, &lists(1000, &[64; 140]));
        let rows: Vec<Range<u32>> = found.iter().map(|slice| slice.rows.clone()).collect();
        assert_eq!(rows, [10..76, 76..142, 142..150]);
        assert!(found.iter().all(|slice| !slice.on_processor));
    }

    #[test]
    fn a_scattered_pair_is_found_again_from_slot_and_tag() {
        for bits in [16, 17, 20, 21, 25] {
            for (front, back, probe) in [(0, 0, 0), (1, 2, 0), (HALF, HALF, 127), (123_456, 7, 99)] {
                let (one, other) = scatter(front, back);
                let scattered = (u64::from(one) << HALF_BITS) | u64::from(other);
                let left = 2 * HALF_BITS - bits;
                let rest = (scattered & ((1 << left) - 1)) as u32;
                let at = ((scattered >> left) as u32 + probe) & ((1 << bits) - 1);
                let tag = ((rest << PROBE_BITS) | probe) + 1;
                assert_eq!(pair_at(bits, at, tag), (front, back), "{bits} bits");
            }
        }
    }
}
