//! A buffer that is rewritten for every view and grows when necessary.

use std::num::NonZeroU64;

use bytemuck::Pod;
use wgpu::{Buffer, BufferUsages};

use crate::device::Gpu;

/// The factor by which a table grows, so that it is reallocated a few times only.
const GROWTH: u64 = 2;

/// A growing buffer with its present content.
#[derive(Debug)]
pub struct GrowingBuffer {
    label: &'static str,
    usage: BufferUsages,
    buffer: Buffer,
    /// The size of the content in bytes.
    used: u64,
}

impl GrowingBuffer {
    /// Creates an empty table.
    pub fn new(gpu: &Gpu, label: &'static str, usage: BufferUsages) -> Self {
        let usage = usage | BufferUsages::COPY_DST;
        Self { label, usage, buffer: create_buffer(gpu, label, usage, 256), used: 0 }
    }

    /// Writes the whole content.
    pub fn write<T: Pod>(&mut self, gpu: &Gpu, content: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(content);
        self.reserve(gpu, bytes.len() as u64);
        gpu.queue.write_buffer(&self.buffer, 0, bytes);
    }

    /// Makes room for a content of `needed` bytes, which is written piece by piece ([`Self::write_at`]); the content before is lost.
    pub fn reserve(&mut self, gpu: &Gpu, needed: u64) {
        if needed > self.buffer.size() {
            // The reserve must not make the buffer larger than the device allows.
            let size = (GROWTH * needed).min(gpu.device.limits().max_buffer_size & !15).max(needed);
            self.buffer = create_buffer(gpu, self.label, self.usage, size);
        }
        self.used = needed;
    }

    /// Writes a piece of the content, from an element on.
    pub fn write_at<T: Pod>(&self, gpu: &Gpu, first: u64, content: &[T]) {
        gpu.queue.write_buffer(&self.buffer, first * size_of::<T>() as u64, bytemuck::cast_slice(content));
    }

    /// Returns the content for use as vertices; it must not be empty.
    pub fn slice(&self) -> wgpu::BufferSlice<'_> {
        self.buffer.slice(..self.used)
    }

    /// Returns the buffer, for bindings of parts of the content.
    pub fn buffer(&self) -> &Buffer {
        &self.buffer
    }

    /// Returns the binding of the content without the reserve, because bindings may be smaller than buffers,
    /// uniform ones by far.
    pub fn binding(&self) -> wgpu::BindingResource<'_> {
        let size = NonZeroU64::new(self.used);
        wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer: &self.buffer, offset: 0, size })
    }
}

fn create_buffer(gpu: &Gpu, label: &str, usage: BufferUsages, size: u64) -> Buffer {
    let size = size.next_multiple_of(16);
    let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
    gpu.device.create_buffer(&descriptor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_that_grew_is_bound_as_far_as_it_was_written() {
        let gpu = Gpu::noop();
        let mut table = GrowingBuffer::new(&gpu, "table", BufferUsages::UNIFORM);
        for bytes in [40_000, 400, 16] {
            table.write(&gpu, &vec![0u8; bytes]);
            let wgpu::BindingResource::Buffer(bound) = table.binding() else { unreachable!("it is one") };
            assert_eq!(bound.size.map(u64::from), Some(bytes as u64));
        }
    }
}
