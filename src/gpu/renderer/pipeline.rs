//! Pipelines that draw the surfaces of the model, and the shader that all of them share.

use wgpu::{BindGroupLayout, CompareFunction, RenderPipeline, TextureFormat};

use super::surfaces::SurfaceVertex;
use crate::bindings::{self, BindingKind};
use crate::device::Gpu;
use crate::drawing::DEPTH;

/// The WGSL source of frames and surfaces, which all shaders of the renderer begin with.
pub(super) const SURFACES: &str = include_str!("../../../shaders/surfaces.wgsl");

/// The shader's declaration of the frame.
#[derive(Debug)]
pub struct FrameTable {
    /// The kind of its binding.
    pub kind: BindingKind,
    /// The source of frames and surfaces with this declaration.
    pub source: String,
}

/// The number of storage buffers of a picture, with the frame and the photos among them.
const MOST_STORAGE_BUFFERS: u32 = 10;

impl FrameTable {
    /// Chooses the declaration: a uniform buffer, but on software adapters that can a storage buffer. Mesa's (22.3) keeps memory for every draw
    /// whose branches depend on a uniform buffer that has changed, probably a compiled shader each: 3 GB for the charts of a castle.
    pub fn new(gpu: &Gpu) -> Self {
        let most = gpu.device.limits().max_storage_buffers_per_shader_stage;
        Self::declared(gpu.is_software() && most >= MOST_STORAGE_BUFFERS)
    }

    /// Returns the declaration as a storage buffer, or as a uniform one.
    pub fn declared(in_storage: bool) -> Self {
        match in_storage {
            false => Self { kind: BindingKind::Uniform, source: SURFACES.into() },
            true => Self {
                kind: BindingKind::Read,
                source: SURFACES.replace("var<uniform> frame", "var<storage, read> frame"),
            },
        }
    }
}

/// The description of a pipeline.
pub(super) struct PipelineDescription<'a> {
    pub vertex: &'a str,
    /// The entry point, and the format that it draws in; `None` for depth alone.
    pub fragment: Option<(&'a str, Option<TextureFormat>)>,
    pub groups: &'a [&'a BindGroupLayout],
    pub samples: u32,
    /// True when the vertices are corners of the model.
    pub corners: bool,
    /// True when its colours are multiplied by their alpha and are laid over what is there; false when they replace it.
    pub blends: bool,
}

impl PipelineDescription<'_> {
    pub(super) fn pipeline(&self, gpu: &Gpu, source: &str) -> RenderPipeline {
        let module = bindings::shader(gpu, self.vertex, source);
        let corner = wgpu::VertexBufferLayout {
            array_stride: size_of::<SurfaceVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Uint32],
        };
        let buffers = [Some(corner)];
        let blend = self.blends.then_some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING);
        let target = |format| wgpu::ColorTargetState { blend, ..wgpu::ColorTargetState::from(format) };
        let targets = self.fragment.and_then(|(_, format)| format).map(|format| Some(target(format)));
        let first = targets.is_none();
        gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.vertex),
            layout: Some(&bindings::pipeline_layout(gpu, self.vertex, self.groups)),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(self.vertex),
                compilation_options: Default::default(),
                buffers: if self.corners { &buffers } else { &[] },
            },
            // Faces are seen from either side.
            primitive: wgpu::PrimitiveState { cull_mode: None, ..Default::default() },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(first),
                depth_compare: Some(CompareFunction::GreaterEqual),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: wgpu::MultisampleState { count: self.samples, ..Default::default() },
            fragment: self.fragment.map(|(entry, _)| wgpu::FragmentState {
                module: &module,
                entry_point: Some(entry),
                compilation_options: Default::default(),
                targets: targets.as_slice(),
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}
