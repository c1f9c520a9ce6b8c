//! Helpers for layouts, bind groups, pipelines and buffers, reduced to what the passes need.

use wgpu::util::DeviceExt;
use wgpu::{BindGroup, BindGroupLayout, BindingResource, BindingType, Buffer, BufferBindingType};
use wgpu::{BufferUsages, SamplerBindingType, ShaderStages, TextureSampleType, TextureViewDimension};

use super::device::Gpu;

/// The type of one binding of a shader. Bindings of a group are numbered in order.
#[derive(Debug, Clone, Copy)]
pub enum BindingKind {
    /// `var<uniform>`
    Uniform,
    /// `var<storage, read>`
    Read,
    /// `var<storage, read_write>`
    Write,
    /// `texture_depth_2d`
    Depth,
    /// `texture_depth_multisampled_2d`
    DepthSamples,
    /// `texture_depth_2d_array`
    DepthArray,
    /// `texture_2d<u32>`
    Ids,
    /// `texture_2d<f32>`
    Filtered,
    /// `texture_2d_array<f32>`
    FilteredArray,
    /// `texture_3d<f32>`
    FilteredVolume,
    /// `sampler`
    Sampler,
    /// `sampler_comparison`
    Comparison,
}

impl BindingKind {
    fn binding_type(self) -> BindingType {
        let buffer = |ty| BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
        let seen_as = |sample_type, view_dimension| BindingType::Texture {
            sample_type,
            view_dimension,
            multisampled: false,
        };
        let texture = |sample_type| seen_as(sample_type, TextureViewDimension::D2);
        let filtered = TextureSampleType::Float { filterable: true };
        match self {
            Self::Uniform => buffer(BufferBindingType::Uniform),
            Self::Read => buffer(BufferBindingType::Storage { read_only: true }),
            Self::Write => buffer(BufferBindingType::Storage { read_only: false }),
            Self::Depth => texture(TextureSampleType::Depth),
            Self::DepthSamples => BindingType::Texture {
                sample_type: TextureSampleType::Depth,
                view_dimension: TextureViewDimension::D2,
                multisampled: true,
            },
            Self::DepthArray => seen_as(TextureSampleType::Depth, TextureViewDimension::D2Array),
            Self::Ids => texture(TextureSampleType::Uint),
            Self::Filtered => texture(filtered),
            Self::FilteredArray => seen_as(filtered, TextureViewDimension::D2Array),
            Self::FilteredVolume => seen_as(filtered, TextureViewDimension::D3),
            Self::Sampler => BindingType::Sampler(SamplerBindingType::Filtering),
            Self::Comparison => BindingType::Sampler(SamplerBindingType::Comparison),
        }
    }
}

/// Creates the layout of a bind group.
pub fn layout(gpu: &Gpu, label: &str, visibility: ShaderStages, kinds: &[BindingKind]) -> BindGroupLayout {
    let entries: Vec<_> = (0..)
        .zip(kinds)
        .map(|(binding, kind)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility,
            ty: kind.binding_type(),
            count: None,
        })
        .collect();
    let descriptor = wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries };
    gpu.device.create_bind_group_layout(&descriptor)
}

/// Creates a bind group with these resources, in order.
pub fn bind(gpu: &Gpu, label: &str, layout: &BindGroupLayout, resources: &[BindingResource]) -> BindGroup {
    let entries: Vec<_> = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
        .collect();
    let descriptor = wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries };
    gpu.device.create_bind_group(&descriptor)
}

/// Returns the binding of the first `words` words (of 4 bytes) of a buffer.
pub fn words(buffer: &Buffer, words: u64) -> BindingResource<'_> {
    let size = wgpu::BufferSize::new(4 * words);
    BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size })
}

/// Creates the layout of a pipeline from its groups' layouts.
pub fn pipeline_layout(gpu: &Gpu, label: &str, groups: &[&BindGroupLayout]) -> wgpu::PipelineLayout {
    let groups: Vec<_> = groups.iter().copied().map(Some).collect();
    gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: &groups,
        immediate_size: 0,
    })
}

/// Compiles a shader from WGSL.
pub fn shader(gpu: &Gpu, label: &str, source: &str) -> wgpu::ShaderModule {
    gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    })
}

/// Creates the compute pipeline of one entry point.
pub fn compute(
    gpu: &Gpu,
    entry: &str,
    module: &wgpu::ShaderModule,
    groups: &[&BindGroupLayout],
) -> wgpu::ComputePipeline {
    gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: Some(&pipeline_layout(gpu, entry, groups)),
        module,
        entry_point: Some(entry),
        compilation_options: wgpu::PipelineCompilationOptions {
            // Every shader writes its workgroup memory before it reads it.
            zero_initialize_workgroup_memory: false,
            ..Default::default()
        },
        cache: None,
    })
}

/// Dispatches workgroups, in as many rows as the device's limit asks for.
pub fn dispatch(gpu: &Gpu, pass: &mut wgpu::ComputePass, workgroups: u32) {
    let across = workgroups.clamp(1, gpu.device.limits().max_compute_workgroups_per_dimension);
    pass.dispatch_workgroups(across, workgroups.div_ceil(across), 1);
}

/// Creates a zeroed buffer of `words` words that shaders read and write. With `read_back`, it can be read by
/// the CPU, too.
pub fn storage(gpu: &Gpu, label: &str, words: u64, read_back: bool) -> Buffer {
    let mapped =
        if read_back && gpu.reads_directly() { BufferUsages::MAP_READ } else { BufferUsages::empty() };
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: 4 * words.max(1),
        usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST | mapped,
        mapped_at_creation: false,
    })
}

/// Creates a buffer with these contents; one zeroed element where there are none, because an empty buffer
/// cannot be bound.
pub fn filled<T: bytemuck::NoUninit + bytemuck::Zeroable>(
    gpu: &Gpu,
    label: &str,
    contents: &[T],
    usage: BufferUsages,
) -> Buffer {
    let nothing = [T::zeroed()];
    let contents = bytemuck::cast_slice(if contents.is_empty() { &nothing } else { contents });
    gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
}
