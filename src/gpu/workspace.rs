//! The textures and buffers of one band, reused from photo to photo.

use wgpu::{BindingResource, Buffer, TextureFormat, TextureUsages, TextureView};

use super::bindings;
use super::device::Gpu;
use super::drawing::DEPTH;
use super::frame::PhotoRows;
use super::scan::RUN;

/// The textures and buffers that the passes over one band write. They are large; each thread that draws uses
/// one.
#[derive(Debug)]
pub struct Workspace {
    size: [u32; 2],
    /// The depth buffer of the band: the nearest fragments, or the farthest.
    pub depth: TextureView,
    /// One word per pixel and one more: counts of entries, then their offsets.
    pub places: Buffer,
    /// One word per run of pixels, for pass *scan*.
    pub runs: Buffer,
    /// The entries of the fragment lists; the buffer grows.
    pub entries: Buffer,
}

impl Workspace {
    /// Creates a workspace for bands of this many columns and rows.
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

    /// Returns the number of columns and rows of the bands that it serves.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Returns the binding of the offsets of a band's pixels and of the word after them.
    pub fn places_of(&self, frame: &PhotoRows) -> BindingResource<'_> {
        bindings::words(&self.places, frame.pixels() + 1)
    }

    /// Ensures room for this many entries. The buffer's contents are lost when it has to grow.
    pub fn reserve(&mut self, gpu: &Gpu, entries: u64) {
        if self.entries.size() < 4 * entries {
            // Photos of one site need about the same; the reserve avoids most of the growing.
            let roomy = (entries + entries / 8).min(gpu.largest_binding() / 4).max(entries);
            self.entries = bindings::storage(gpu, "entries", roomy, true);
        }
    }
}

/// Creates a texture that can be drawn into and sampled.
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
