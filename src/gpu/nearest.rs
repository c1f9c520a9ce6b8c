//! Pass *nearest* (`shaders/nearest.wgsl`): the inverse depth of the nearest fragment per pixel.

use wgpu::{BindGroup, BindGroupLayout, CommandEncoder, CompareFunction};

use super::device::Gpu;
use super::drawing::{Attachments, DrawPipeline, Style, Triangles};
use super::frame::BoundRows;

/// The WGSL source of the pass.
pub const SOURCE: &str = include_str!("../../shaders/nearest.wgsl");

/// The pipeline of the pass.
#[derive(Debug)]
pub struct Nearest {
    draw: DrawPipeline,
    own: BindGroup,
}

impl Nearest {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu, frame: &BindGroupLayout) -> Self {
        let depth = Some(CompareFunction::Greater);
        let style = Style { name: "nearest", source: SOURCE, depth, ..Style::LOOK };
        let draw = DrawPipeline::new(gpu, frame, style);
        let own = draw.bind(gpu, &[]);
        Self { draw, own }
    }

    /// Records the pass: it fills the canvas' depth buffer; 0 where no fragment is.
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
