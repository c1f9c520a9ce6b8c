//! Pass *fill* (`shaders/fill.wgsl`): every fragment writes its entry into the fragment lists.

use wgpu::{BindGroupLayout, BindingResource, CommandEncoder};

use super::bindings::BindingKind;
use super::device::Gpu;
use super::drawing::{Attachments, DrawPipeline, Style, Triangles};
use super::frame::BoundRows;
use super::workspace::Workspace;

/// The WGSL source of the pass.
pub const SOURCE: &str = include_str!("../../shaders/fill.wgsl");

/// The pipeline of the pass.
#[derive(Debug)]
pub struct Fill {
    draw: DrawPipeline,
}

impl Fill {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu, frame: &BindGroupLayout) -> Self {
        let kinds = &[BindingKind::Depth, BindingKind::Write, BindingKind::Write];
        let style = Style { name: "fill", source: SOURCE, kinds, ..Style::LOOK };
        Self { draw: DrawPipeline::new(gpu, frame, style) }
    }

    /// Records the pass: it fills the entries of the frame's rows. The workspace holds the nearest depths of
    /// the band, and the offsets as pass *scan* left them; when a band is filled in parts, the last rows come
    /// first.
    pub fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        space: &Workspace,
        bound: BoundRows,
        triangles: &Triangles,
    ) {
        let nearest = BindingResource::TextureView(&space.depth);
        let own =
            self.draw.bind(gpu, &[nearest, space.places_of(bound.rows), space.entries.as_entire_binding()]);
        self.draw.record(encoder, Attachments { depth: &space.depth, items: None }, bound, &own, triangles);
    }
}
