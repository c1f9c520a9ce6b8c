//! The buffers of the rows of a picture that are drawn at once, reused from picture to picture.

use wgpu::{BindGroup, Buffer, CommandEncoder};

use super::slots::{PLANES, SUMS};
use super::uploaded::MOST_WORKGROUPS;
use super::view::{Layouts, WORKGROUP};
use crate::device::Gpu;
use crate::{bindings, readback};
use quadratura_base::error::Result;

/// The buffers of a number of pixels.
#[derive(Debug)]
pub struct Space {
    /// The pixels that have room for depths and colours, and those that have room for sums.
    room: [u64; 2],
    depths: Buffer,
    sums: Buffer,
    picture: Buffer,
    /// The bindings of all three.
    pub group: BindGroup,
}

/// Returns the largest number of pixels that are drawn at once on a device: what bindings hold, and one dispatch.
pub fn most_pixels(gpu: &Gpu) -> u64 {
    (gpu.largest_binding() / (4 * SUMS)).min(u64::from(MOST_WORKGROUPS * WORKGROUP))
}

impl Space {
    /// Creates buffers for no pixel.
    pub fn new(gpu: &Gpu, layouts: &Layouts) -> Self {
        Self::with_room(gpu, layouts, [0, 0])
    }

    fn with_room(gpu: &Gpu, layouts: &Layouts, room: [u64; 2]) -> Self {
        let depths = bindings::storage(gpu, "LDI depths", (PLANES * room[0] + 1).max(2), true);
        let sums = bindings::storage(gpu, "LDI sums", SUMS * room[1], false);
        let picture = bindings::storage(gpu, "LDI picture", room[0], true);
        let resources = [&depths, &sums, &picture].map(Buffer::as_entire_binding);
        let group = bindings::bind(gpu, "LDI space", &layouts.space, &resources);
        Self { room, depths, sums, picture, group }
    }

    /// Ensures room for this many pixels, with sums or without.
    pub fn reserve(&mut self, gpu: &Gpu, layouts: &Layouts, pixels: u64, with_sums: bool) {
        let sums = if with_sums { pixels } else { 0 };
        if self.room[0] < pixels || self.room[1] < sums {
            *self = Self::with_room(gpu, layouts, [self.room[0].max(pixels), self.room[1].max(sums)]);
        }
    }

    /// Records that the words of this many pixels become 0.
    pub fn clear(&self, encoder: &mut CommandEncoder, pixels: u64, with_sums: bool) {
        encoder.clear_buffer(&self.depths, 0, Some(4 * (PLANES * pixels + 1)));
        encoder.clear_buffer(&self.picture, 0, Some(4 * pixels));
        if with_sums {
            encoder.clear_buffer(&self.sums, 0, Some(4 * SUMS * pixels));
        }
    }

    /// Reads the colours of this many pixels, and the number of depth pixels that are magnified too much.
    pub fn read(&self, gpu: &Gpu, pixels: u64) -> Result<(Vec<u32>, u32)> {
        let count = PLANES * pixels;
        let wanted = [(&self.picture, 0..pixels), (&self.depths, count..count + 1)];
        let [colours, count] = readback::read(gpu, wanted)?;
        Ok((colours, count[0]))
    }
}
