//! Pass *count* (`shaders/count.wgsl`): the number of fragments per pixel.

use wgpu::{BindGroupLayout, CommandEncoder};

use super::bindings::BindingKind;
use super::device::Gpu;
use super::drawing::{Attachments, DrawPipeline, Style, Triangles};
use super::frame::BoundRows;
use super::workspace::Workspace;

/// The WGSL source of the pass.
pub const SOURCE: &str = include_str!("../../shaders/count.wgsl");

/// The pipeline of the pass.
#[derive(Debug)]
pub struct Count {
    draw: DrawPipeline,
}

impl Count {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu, frame: &BindGroupLayout) -> Self {
        let style = Style { name: "count", source: SOURCE, kinds: &[BindingKind::Write], ..Style::LOOK };
        Self { draw: DrawPipeline::new(gpu, frame, style) }
    }

    /// Records the pass: it leaves the counts of the band's pixels in the workspace's offsets, followed by a
    /// 0.
    pub fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        space: &Workspace,
        bound: BoundRows,
        triangles: &Triangles,
    ) {
        encoder.clear_buffer(&space.places, 0, Some(4 * (bound.rows.pixels() + 1)));
        let own = self.draw.bind(gpu, &[space.places_of(bound.rows)]);
        self.draw.record(encoder, Attachments { depth: &space.depth, items: None }, bound, &own, triangles);
    }
}
