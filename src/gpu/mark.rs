//! Pass *mark* (`shaders/mark.wgsl`): which items have a fragment behind the nearest by more than
//! the tolerance. With it, exact peeling.

use wgpu::{BindGroup, BindGroupLayout, BindingResource, Buffer, CommandEncoder};

use super::bindings::{self, Kind};
use super::device::Gpu;
use super::drawing::{Canvas, DrawPipeline, Style, Triangles};
use super::frame::Frame;
use super::rasteriser::GpuRasteriser;
use super::readback;
use super::run::Run;
use super::workspace::Workspace;
use crate::error::Result;
use crate::layers::View;
use crate::task::Task;

/// WGSL of the pass.
pub const SOURCE: &str = include_str!("../../shaders/mark.wgsl");

/// One flag per item of a view, on the device.
#[derive(Debug)]
pub struct Marks(Buffer);

impl Marks {
    /// No item is marked.
    pub fn new(gpu: &Gpu, view: &View) -> Self {
        Self(bindings::storage(gpu, "marks", view.items.len() as u64, true))
    }

    /// For binding.
    pub fn resource(&self) -> BindingResource<'_> {
        self.0.as_entire_binding()
    }

    /// The flags, one per item.
    pub fn read(&self, gpu: &Gpu, view: &View) -> Result<Vec<bool>> {
        let [marks] = readback::read(gpu, [(&self.0, 0..view.items.len() as u64)])?;
        Ok(marks.into_iter().map(|mark| mark != 0).collect())
    }
}

/// The pipeline.
#[derive(Debug)]
pub struct Mark {
    draw: DrawPipeline,
}

impl Mark {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu, frame: &BindGroupLayout) -> Self {
        let kinds = &[Kind::Depth, Kind::Write];
        Self {
            draw: DrawPipeline::new(gpu, frame, Style { name: "mark", source: SOURCE, kinds, ..Style::LOOK }),
        }
    }

    /// Adds the marks of a band, whose nearest is on the canvas.
    pub fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        canvas: Canvas,
        frame: (&Frame, &BindGroup),
        triangles: &Triangles,
        marks: &Marks,
    ) {
        let own = self.draw.bind(gpu, &[BindingResource::TextureView(canvas.depth), marks.resource()]);
        self.draw.record(encoder, canvas, frame, &own, triangles);
    }
}

impl GpuRasteriser {
    /// Per item of the view, whether a fragment of it lies behind another of the run by more than
    /// the tolerance.
    pub(super) fn behind_any(&self, run: &Run, space: &Workspace) -> Result<Vec<bool>> {
        let marks = Marks::new(&self.gpu, run.view);
        let canvas = Canvas { depth: &space.depth, items: None };
        for rows in self.bands(run.view) {
            let frame = Frame::band(run.view, rows);
            let shared = self.share(run, &frame);
            let of = (&frame, &shared);
            self.submit(|encoder| {
                self.nearest.record(encoder, canvas, of, &run.triangles);
                self.mark.record(&self.gpu, encoder, canvas, of, &run.triangles, &marks);
            });
        }
        marks.read(&self.gpu, run.view)
    }

    /// The same with some pairs (front, back), sorted, left out: the nearest may be a forgiven one
    /// and something else be in front as well, so every pair is looked at.
    pub(super) fn behind_unforgiven(
        &self,
        run: &Run,
        space: &mut Workspace,
        forgiven: &[(u32, u32)],
    ) -> Result<Vec<bool>> {
        let (bands, task) = (self.bands(run.view), Task::silent());
        let (_, occlusions) = self.lists_and_pairs(run, space, &bands, false, &task)?;
        let mut behind = vec![false; run.view.items.len()];
        for pair in occlusions {
            behind[pair.back as usize] |= forgiven.binary_search(&(pair.front, pair.back)).is_err();
        }
        Ok(behind)
    }
}
