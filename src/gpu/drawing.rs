//! The common parts of the drawing passes: triangles on the device, and the pipeline that draws them into a
//! band (`shaders/drawing.wgsl`).

use bytemuck::{Pod, Zeroable};
use wgpu::{BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, CompareFunction};
use wgpu::{RenderPipeline, ShaderStages, TextureFormat, TextureView};

use super::bindings::{self, BindingKind};
use super::device::Gpu;
use super::frame::BoundRows;
use quadratura_layers::ProjectedModel;

/// The WGSL source of the vertex stage, which is put between `frame.wgsl` and the pass.
pub const VERTEX: &str = include_str!("../../shaders/drawing.wgsl");

/// The format of the depth buffer.
pub const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// The format of the item buffer: 1 + the index of an item, 0 where there is none.
pub const ITEMS: TextureFormat = TextureFormat::R32Uint;

/// A corner of a triangle in the layout of the vertex stage.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct ClipVertex {
    /// x, y, w in clip coordinates.
    pub position: [f32; 3],
    /// Index of the item in the table of planes.
    pub item: u32,
}

/// The triangles to draw, on the device, in model order.
#[derive(Debug)]
pub struct Triangles {
    corners: Buffer,
    count: u32,
}

impl Triangles {
    /// Uploads the triangles of the items for which `kept` is true.
    pub fn from_gpu(gpu: &Gpu, view: &ProjectedModel, kept: impl Fn(u32) -> bool) -> Self {
        let triangles = view.corners.iter().zip(&view.triangle_items).filter(|(_, item)| kept(**item));
        let corners: Vec<ClipVertex> = triangles
            .flat_map(|(triangle, &item)| triangle.map(|position| ClipVertex { position, item }))
            .collect();
        let count = corners.len() as u32;
        Self { corners: bindings::filled(gpu, "triangles", &corners, BufferUsages::VERTEX), count }
    }
}

/// The properties of a drawing pass besides its shader.
#[derive(Debug, Clone, Copy)]
pub struct Style<'a> {
    /// Name of the pass and of its fragment entry point.
    pub name: &'a str,
    /// The WGSL source of the pass alone.
    pub source: &'a str,
    /// The bindings of group 1.
    pub kinds: &'a [BindingKind],
    /// The comparison by which the depth buffer is tested and written; `None` when it is only read.
    pub depth: Option<CompareFunction>,
    /// True when the pass draws into the item buffer.
    pub items: bool,
}

impl Style<'_> {
    /// A pass that reads a depth buffer and writes storage buffers only.
    pub const LOOK: Self = Style { name: "", source: "", kinds: &[], depth: None, items: false };
}

/// A pipeline that draws triangles, with the layout of its own group.
#[derive(Debug)]
pub struct DrawPipeline {
    name: String,
    pipeline: RenderPipeline,
    own: BindGroupLayout,
    cleared: f32,
    writes_depth: bool,
}

/// The attachments to draw into.
#[derive(Debug, Clone, Copy)]
pub struct Attachments<'a> {
    /// The depth buffer of the band.
    pub depth: &'a TextureView,
    /// The item buffer of the band, where the pass has one.
    pub items: Option<&'a TextureView>,
}

impl DrawPipeline {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu, frame: &BindGroupLayout, style: Style) -> Self {
        let own = bindings::layout(gpu, style.name, ShaderStages::FRAGMENT, style.kinds);
        let source = [super::frame::SOURCE, VERTEX, style.source].concat();
        let module = bindings::shader(gpu, style.name, &source);
        let layout = bindings::pipeline_layout(gpu, style.name, &[frame, &own]);
        let pipeline = render_pipeline(gpu, &layout, &module, style);
        let cleared = if style.depth == Some(CompareFunction::LessEqual) { 1.0 } else { 0.0 };
        Self { name: style.name.into(), pipeline, own, cleared, writes_depth: style.depth.is_some() }
    }

    /// Builds bind group 1 with these resources, in the shader's order.
    pub fn bind(&self, gpu: &Gpu, resources: &[wgpu::BindingResource]) -> BindGroup {
        bindings::bind(gpu, &self.name, &self.own, resources)
    }

    /// Records the drawing of triangles into the frame's rows. A pass that writes depth clears the canvas
    /// first.
    pub fn record(
        &self,
        encoder: &mut CommandEncoder,
        canvas: Attachments,
        bound: BoundRows,
        own: &BindGroup,
        triangles: &Triangles,
    ) {
        let items = canvas.items.map(|view| wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                store: wgpu::StoreOp::Store,
            },
        });
        let cleared = wgpu::LoadOp::Clear(self.cleared);
        let written = wgpu::Operations { load: cleared, store: wgpu::StoreOp::Store };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(&self.name),
            color_attachments: if items.is_some() { std::slice::from_ref(&items) } else { &[] },
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: canvas.depth,
                depth_ops: self.writes_depth.then_some(written),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        let BoundRows { rows: frame, group } = bound;
        let [width, height] = frame.size;
        let band = frame.band.start;
        // The viewport is the whole photo and exceeds the canvas: rows then have the same sub-pixel grid in
        // every band, and the scissor alone selects the band's rows.
        pass.set_viewport(0.0, -(band as f32), width as f32, height as f32, 0.0, 1.0);
        pass.set_scissor_rect(0, frame.rows.start - band, width, frame.rows.len() as u32);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.set_bind_group(1, own, &[]);
        pass.set_vertex_buffer(0, triangles.corners.slice(..));
        pass.draw(0..triangles.count, 0..1);
    }
}

fn render_pipeline(
    gpu: &Gpu,
    layout: &wgpu::PipelineLayout,
    module: &wgpu::ShaderModule,
    style: Style,
) -> RenderPipeline {
    let corner = wgpu::VertexBufferLayout {
        array_stride: size_of::<ClipVertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Uint32],
    };
    let items = [Some(wgpu::ColorTargetState::from(ITEMS))];
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(style.name),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("corner"),
            compilation_options: Default::default(),
            buffers: &[Some(corner)],
        },
        // Photos may see faces from either side.
        primitive: wgpu::PrimitiveState { cull_mode: None, ..Default::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(style.depth.is_some()),
            depth_compare: Some(style.depth.unwrap_or(CompareFunction::Always)),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(style.name),
            compilation_options: Default::default(),
            targets: if style.items { &items } else { &[] },
        }),
        multiview_mask: None,
        cache: None,
    })
}
