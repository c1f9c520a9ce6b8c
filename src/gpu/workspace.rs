//! The textures and buffers of one band, kept from photo to photo.

use wgpu::{BindingResource, Buffer, TextureFormat, TextureUsages, TextureView};

use super::bindings;
use super::device::Gpu;
use super::drawing::DEPTH;
use super::frame::Frame;
use super::scan::RUN;

/// What the passes over one band write. Large: one per thread that draws at the same time.
#[derive(Debug)]
pub struct Workspace {
    size: [u32; 2],
    /// Depth buffer of the band: the nearest, or the farthest.
    pub depth: TextureView,
    /// One word per pixel and one more: counts, then places.
    pub places: Buffer,
    /// One word per run of pixels.
    pub runs: Buffer,
    /// The entries; grows.
    pub entries: Buffer,
}

impl Workspace {
    /// For bands of so many columns and rows.
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Self {
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        Self {
            size,
            depth: texture(gpu, "depth", size, DEPTH),
            places: bindings::storage(gpu, "places", pixels + 1, true),
            runs: bindings::storage(gpu, "runs", (pixels + 1).div_ceil(RUN), false),
            entries: bindings::storage(gpu, "entries", 1, true),
        }
    }

    /// Columns and rows of the bands that it serves.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The places of a band's pixels, and the one after them.
    pub fn places_of(&self, frame: &Frame) -> BindingResource<'_> {
        bindings::words(&self.places, frame.pixels() + 1)
    }

    /// Makes room for so many entries. What was in the buffer is lost where it has to grow.
    pub fn reserve(&mut self, gpu: &Gpu, entries: u64) {
        if self.entries.size() < 4 * entries {
            // Photos of one site need about the same: some room spares most of the growing.
            let roomy = (entries + entries / 8).min(gpu.largest_binding() / 4).max(entries);
            self.entries = bindings::storage(gpu, "entries", roomy, true);
        }
    }
}

/// A texture to draw into and to look at.
pub fn texture(gpu: &Gpu, label: &str, [width, height]: [u32; 2], format: TextureFormat) -> TextureView {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    texture.create_view(&Default::default())
}
