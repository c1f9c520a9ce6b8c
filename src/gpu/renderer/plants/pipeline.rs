//! The pipelines that draw trees: what they show, what they leave out, and how instances are placed.

use bytemuck::{Pod, Zeroable};
use wgpu::{BindGroupLayout, RenderPipeline, ShaderStages, TextureFormat};

use super::species::{CornerWords, InstanceWords};
use super::{daylight, stipple};
use crate::bindings;
use crate::device::Gpu;
use crate::drawing::DEPTH;
use crate::renderer::pipeline::SURFACES;
use crate::renderer::render_target::{COLOR, FACES, LINEAR};
use quadratura_view::{DisplayMode, Shot};

const PLANTS: &str = include_str!("../../../../shaders/plants.wgsl");

/// How instances are placed, in the layout of the shader (`Placement`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct PlacementWords {
    pub right: [f32; 4],
    pub down: [f32; 4],
    pub forward: [f32; 4],
    pub first: u32,
    pub pad0: u32,
    pub pad1: u32,
    pub pad2: u32,
}

/// What a drawing shows of trees.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TreeProgram {
    /// Their colours in the site's light, in linear light or not.
    Lit { linear: bool },
    /// One colour for each tree, in linear light or not.
    Plain { linear: bool },
    /// [`quadratura_projection::TREE`] and their numbers.
    Numbered,
    /// Their depths alone, as the sun sees them.
    Shadow,
}

impl TreeProgram {
    /// Returns what a picture of a view shows.
    pub fn of_picture(shot: &Shot) -> Self {
        let linear = shot.linear;
        if shot.display == DisplayMode::Colour { Self::Lit { linear } } else { Self::Plain { linear } }
    }

    /// Returns the entry point of its shaders, and the format that it draws in; `None` for depths alone.
    fn entry(self) -> (&'static str, Option<TextureFormat>) {
        let colors = |linear| Some(if linear { LINEAR } else { COLOR });
        match self {
            Self::Lit { linear } => ("lit", colors(linear)),
            Self::Plain { linear } => ("plain", colors(linear)),
            Self::Numbered => ("numbered", Some(FACES)),
            Self::Shadow => ("shadow", None),
        }
    }
}

/// What the drawing of polygons leaves out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Cuts {
    /// What a picture cuts out.
    pub by_picture: bool,
    /// Sub-pixels in which a stipple is closed.
    pub by_stipple: bool,
}

/// A program of trees with its samples per pixel, which are those of what it draws onto.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SampledProgram {
    /// The program.
    pub program: TreeProgram,
    /// The number of samples per pixel.
    pub samples: u32,
}

/// Returns the layout of trees: how instances are placed, at dynamic offsets, and what is shown of the trees in view.
pub fn trees_layout(gpu: &Gpu) -> BindGroupLayout {
    let entry = |binding, visibility, ty, has_dynamic_offset| wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None },
        count: None,
    };
    let entries = &[
        entry(0, ShaderStages::VERTEX, wgpu::BufferBindingType::Uniform, true),
        entry(1, ShaderStages::FRAGMENT, wgpu::BufferBindingType::Storage { read_only: true }, false),
    ];
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("trees"), entries })
}

/// Returns the complete WGSL source of a program.
pub fn source(cuts: Cuts) -> String {
    let Cuts { by_picture, by_stipple } = cuts;
    let constants = format!("const CUT = {by_picture};\nconst STIPPLE = {by_stipple};\n");
    [&constants, SURFACES, daylight::SOURCE, stipple::SOURCE, PLANTS].concat()
}

/// Makes a pipeline that draws trees as polygons.
pub fn pipeline(
    gpu: &Gpu,
    program: SampledProgram,
    cuts: Cuts,
    layouts: &[BindGroupLayout; 4],
) -> RenderPipeline {
    let corner = wgpu::VertexBufferLayout {
        array_stride: size_of::<CornerWords>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 6 => Float32x3],
    };
    let instance = wgpu::VertexBufferLayout {
        array_stride: size_of::<InstanceWords>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![3 => Float32x4, 4 => Float32x4, 5 => Float32x4, 7 => Uint32, 8 => Uint32],
    };
    let (source, buffers) = (source(cuts), [Some(corner), Some(instance)]);
    tree_pipeline(gpu, program, &source, "grown", &buffers, &layouts.each_ref())
}

/// Makes a pipeline that draws trees with their depths: from a source, its vertex function and the buffers of that.
pub fn tree_pipeline(
    gpu: &Gpu,
    program: SampledProgram,
    source: &str,
    vertex: &str,
    buffers: &[Option<wgpu::VertexBufferLayout<'_>>],
    layouts: &[&BindGroupLayout],
) -> RenderPipeline {
    let SampledProgram { program, samples } = program;
    let (entry, format) = program.entry();
    let module = bindings::shader(gpu, entry, source);
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(entry),
        layout: Some(&bindings::pipeline_layout(gpu, entry, layouts)),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some(vertex),
            compilation_options: Default::default(),
            buffers,
        },
        // Leaves are seen from either side, and bark is closed.
        primitive: wgpu::PrimitiveState { cull_mode: None, ..Default::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            // Of what is equally near, the first stays, as on the CPU.
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(entry),
            compilation_options: Default::default(),
            targets: format.map(|format| Some(format.into())).as_slice(),
        }),
        multiview_mask: None,
        cache: None,
    })
}
