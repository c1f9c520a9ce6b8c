//! A buffer that is written anew for every shot and grows when it must.

use bytemuck::Pod;
use wgpu::{Buffer, BufferUsages};

use crate::gpu::device::Gpu;

/// Growing by this factor, a table is made anew a few times and then never again.
const GROWTH: u64 = 2;

#[derive(Debug)]
pub struct Table {
    label: &'static str,
    usage: BufferUsages,
    buffer: Buffer,
}

impl Table {
    pub fn new(gpu: &Gpu, label: &'static str, usage: BufferUsages) -> Self {
        let usage = usage | BufferUsages::COPY_DST;
        Self { label, usage, buffer: made(gpu, label, usage, 256) }
    }

    /// Writes the whole content.
    pub fn write<T: Pod>(&mut self, gpu: &Gpu, content: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(content);
        if bytes.len() as u64 > self.buffer.size() {
            self.buffer = made(gpu, self.label, self.usage, GROWTH * bytes.len() as u64);
        }
        gpu.queue.write_buffer(&self.buffer, 0, bytes);
    }

    pub fn binding(&self) -> wgpu::BindingResource<'_> {
        self.buffer.as_entire_binding()
    }
}

fn made(gpu: &Gpu, label: &str, usage: BufferUsages, size: u64) -> Buffer {
    let size = size.next_multiple_of(16);
    let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
    gpu.device.create_buffer(&descriptor)
}
