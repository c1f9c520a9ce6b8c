//! Pass *count* (`shaders/count.wgsl`): the number of fragments per pixel.

use wgpu::{BindGroup, BindGroupLayout, CommandEncoder};

use super::bindings::BindingKind;
use super::device::Gpu;
use super::drawing::{Attachments, DrawPipeline, Style, Triangles};
use super::frame::PhotoRows;
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
        frame: (&PhotoRows, &BindGroup),
        triangles: &Triangles,
    ) {
        encoder.clear_buffer(&space.places, 0, Some(4 * (frame.0.pixels() + 1)));
        let own = self.draw.bind(gpu, &[space.places_of(frame.0)]);
        self.draw.record(encoder, Attachments { depth: &space.depth, items: None }, frame, &own, triangles);
    }
}
