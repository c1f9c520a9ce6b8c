//! Bind group 1 of the renderer's programs: texture memory, which `shaders/texels.wgsl` reads.

use wgpu::{BindGroup, BindGroupLayout, BindingResource, Sampler, ShaderStages};

use crate::TileStore;
use crate::bindings::{self, BindingKind};
use crate::device::Gpu;

/// The WGSL source of the lookups.
pub const SOURCE: &str = include_str!("../../../shaders/texels.wgsl");

const KINDS: [BindingKind; 4] =
    [BindingKind::FilteredArray, BindingKind::Sampler, BindingKind::Read, BindingKind::Read];

/// The layout of the group, and its sampler.
#[derive(Debug)]
pub struct TexelGroup {
    /// The layout of the group.
    pub layout: BindGroupLayout,
    bilinear: Sampler,
}

impl TexelGroup {
    /// Creates the layout and the sampler.
    pub fn new(gpu: &Gpu, visibility: ShaderStages) -> Self {
        Self {
            layout: bindings::layout(gpu, "texels", visibility, &KINDS),
            bilinear: gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("bilinear"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
        }
    }

    /// Builds the group for the store's present contents. With `stored`, the atlas is read as stored
    /// (`STORED` of the shader).
    pub fn bind(&self, gpu: &Gpu, tiles: &TileStore, stored: bool) -> BindGroup {
        let resources = [
            BindingResource::TextureView(if stored { tiles.stored_atlas() } else { tiles.atlas() }),
            BindingResource::Sampler(&self.bilinear),
            tiles.pages().as_entire_binding(),
            tiles.layer_textures().as_entire_binding(),
        ];
        bindings::bind(gpu, "texels", &self.layout, &resources)
    }
}
