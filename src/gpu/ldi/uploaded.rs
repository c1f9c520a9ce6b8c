//! The depth pixels of a layered depth image on the device.

use std::ops::Range;
use std::sync::Arc;

use wgpu::{BindGroup, BufferUsages};

use super::view::{Layouts, WORKGROUP};
use crate::bindings;
use crate::device::Gpu;
use crate::renderer::table::GrowingBuffer;
use quadratura_ldi::{Ldi, ResolutionLevel};

/// The bytes of a depth pixel on the device: position, inverse depth, colour and surface.
const BYTES: u64 = 16;

/// The largest number of workgroups of one dispatch, along one dimension: WebGPU's.
pub const MOST_WORKGROUPS: u32 = 65_535;

/// A layered depth image whose depth pixels are on a device.
#[derive(Debug)]
pub struct GpuLdi {
    ldi: Arc<Ldi>,
    /// The chunks of each level.
    levels: Vec<Vec<LevelChunk>>,
}

/// A part of a level that fits into one binding.
#[derive(Debug)]
pub struct LevelChunk {
    /// The indices of its depth pixels in the level.
    pub pixels: Range<u32>,
    /// The bindings of its index and its depth pixels.
    pub group: BindGroup,
}

/// Returns the largest number of depth pixels that a chunk can have on a device.
pub fn most_of_chunk(gpu: &Gpu) -> u64 {
    (gpu.largest_binding() / BYTES).min(u64::from(MOST_WORKGROUPS * WORKGROUP))
}

impl GpuLdi {
    /// Uploads all levels, in chunks of at most `most` depth pixels that end between rays.
    pub(super) fn new(gpu: &Gpu, layouts: &Layouts, ldi: Arc<Ldi>, most: u64) -> Self {
        let levels = ldi.levels.iter().map(|level| chunks(gpu, layouts, level, most as usize)).collect();
        Self { ldi, levels }
    }

    /// Returns the image.
    pub fn ldi(&self) -> &Arc<Ldi> {
        &self.ldi
    }

    /// Returns the bytes that it takes on the device.
    pub fn bytes(&self) -> u64 {
        self.ldi.levels.iter().map(|level| BYTES * level.len() as u64).sum()
    }

    /// Returns the chunks of a level.
    pub(super) fn chunks(&self, level: usize) -> &[LevelChunk] {
        &self.levels[level]
    }
}

fn chunks(gpu: &Gpu, layouts: &Layouts, level: &ResolutionLevel, most: usize) -> Vec<LevelChunk> {
    let mut chunks = Vec::new();
    let mut start = 0;
    while start < level.len() {
        let end = end_of_chunk(level, start, most);
        chunks.push(chunk(gpu, layouts, level, start..end));
        start = end;
    }
    chunks
}

/// Returns where a chunk ends that holds at most so many depth pixels: not within a ray, if it can hold one.
fn end_of_chunk(level: &ResolutionLevel, start: usize, most: usize) -> usize {
    let end = start + most.max(1);
    if end >= level.len() {
        return level.len();
    }
    let is_between = |end: &usize| {
        level.columns[*end - 1] != level.columns[*end] || level.rows.binary_search(&(*end as u32)).is_ok()
    };
    (start + 1..=end).rev().find(is_between).unwrap_or(end)
}

fn chunk(gpu: &Gpu, layouts: &Layouts, level: &ResolutionLevel, pixels: Range<usize>) -> LevelChunk {
    let mut words: Vec<[u32; 4]> = Vec::with_capacity(pixels.len());
    let mut row = level.rows.partition_point(|&end| end as usize <= pixels.start).saturating_sub(1);
    for at in pixels.clone() {
        while level.rows[row + 1] as usize <= at {
            row += 1;
        }
        // Sides of frames are at most `LONGEST_SIDE`, which 16 bits hold.
        let place = u32::from(level.columns[at]) | (row as u32) << 16;
        let colour = u32::from_le_bytes(level.colours[at]);
        words.push([place, level.inverse_depths[at].to_bits(), colour, level.surfaces[at].into()]);
    }
    // Written by the queue, so that a device that is lost or full reports an error.
    let buffer = bindings::storage(gpu, "LDI depth pixels", 4 * words.len() as u64, false);
    gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&words));
    let pixels = pixels.start as u32..pixels.end as u32;
    let mut first = GrowingBuffer::new(gpu, "LDI chunk", BufferUsages::UNIFORM);
    first.write(gpu, &[pixels.start, 0, 0, 0]);
    let resources = [first.binding(), buffer.as_entire_binding()];
    LevelChunk { group: bindings::bind(gpu, "LDI chunk", &layouts.chunk, &resources), pixels }
}
