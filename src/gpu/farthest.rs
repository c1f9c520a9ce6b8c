//! Pass *farthest* (`shaders/farthest.wgsl`): the item buffer with the depth test inverted.

use wgpu::{BindGroup, BindGroupLayout, CommandEncoder, CompareFunction};

use super::device::Gpu;
use super::drawing::{Attachments, DrawPipeline, Style, Triangles};
use super::frame::BoundRows;

/// The WGSL source of the pass.
pub const SOURCE: &str = include_str!("../../shaders/farthest.wgsl");

/// The pipeline of the pass.
#[derive(Debug)]
pub struct Farthest {
    draw: DrawPipeline,
    own: BindGroup,
}

impl Farthest {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu, frame: &BindGroupLayout) -> Self {
        // Smaller values are farther; of equal ones the later drawn wins.
        let depth = Some(CompareFunction::LessEqual);
        let style = Style { name: "farthest", source: SOURCE, depth, items: true, ..Style::LOOK };
        let draw = DrawPipeline::new(gpu, frame, style);
        let own = draw.bind(gpu, &[]);
        Self { draw, own }
    }

    /// Records the pass: it fills the canvas' depth and item buffers; 1 and 0 where no fragment is.
    pub fn record(
        &self,
        encoder: &mut CommandEncoder,
        canvas: Attachments,
        bound: BoundRows,
        triangles: &Triangles,
    ) {
        self.draw.record(encoder, canvas, bound, &self.own, triangles);
    }
}
