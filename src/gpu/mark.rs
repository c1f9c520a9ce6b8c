//! Pass *mark* (`shaders/mark.wgsl`): marks the items that have a fragment behind the nearest by more than
//! the tolerance. Exact peeling is built on it.

use wgpu::{BindGroupLayout, BindingResource, Buffer, CommandEncoder};

use super::bindings::{self, BindingKind};
use super::device::Gpu;
use super::drawing::{Attachments, DrawPipeline, Style, Triangles};
use super::frame::{BoundRows, PhotoRows};
use super::rasteriser::GpuRasteriser;
use super::readback;
use super::run::DrawnItems;
use super::workspace::Workspace;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_layers::ProjectedModel;

/// The WGSL source of the pass.
pub const SOURCE: &str = include_str!("../../shaders/mark.wgsl");

/// One flag per item of a view, on the device.
#[derive(Debug)]
pub struct Marks(Buffer);

impl Marks {
    /// Creates flags that are all unset.
    pub fn new(gpu: &Gpu, view: &ProjectedModel) -> Self {
        Self(bindings::storage(gpu, "marks", view.items.len() as u64, true))
    }

    /// Returns the binding of the flags.
    pub fn resource(&self) -> BindingResource<'_> {
        self.0.as_entire_binding()
    }

    /// Reads the flags back, one per item.
    pub fn read(&self, gpu: &Gpu, view: &ProjectedModel) -> Result<Vec<bool>> {
        let [marks] = readback::read(gpu, [(&self.0, 0..view.items.len() as u64)])?;
        Ok(marks.into_iter().map(|mark| mark != 0).collect())
    }
}

/// The pipeline of the pass.
#[derive(Debug)]
pub struct MarkPass {
    draw: DrawPipeline,
}

impl MarkPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu, frame: &BindGroupLayout) -> Self {
        let kinds = &[BindingKind::Depth, BindingKind::Write];
        Self {
            draw: DrawPipeline::new(gpu, frame, Style { name: "mark", source: SOURCE, kinds, ..Style::LOOK }),
        }
    }

    /// Records the pass: it adds the marks of a band, whose nearest depths are on the canvas.
    pub fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        canvas: Attachments,
        bound: BoundRows,
        triangles: &Triangles,
        marks: &Marks,
    ) {
        let own = self.draw.bind(gpu, &[BindingResource::TextureView(canvas.depth), marks.resource()]);
        self.draw.record(encoder, canvas, bound, &own, triangles);
    }
}

impl GpuRasteriser {
    /// Returns, per item of the view, whether a fragment of it lies behind another item's of the run by more
    /// than the tolerance.
    pub(super) fn behind_any(&self, run: &DrawnItems, space: &Workspace) -> Result<Vec<bool>> {
        let marks = Marks::new(&self.gpu, run.view);
        let canvas = Attachments { depth: &space.depth, items: None };
        for rows in self.bands(run.view) {
            let frame = PhotoRows::band(run.view, rows);
            let shared = self.share(run, &frame);
            let bound = BoundRows { rows: &frame, group: &shared };
            self.submit(|encoder| {
                self.nearest.record(encoder, canvas, bound, &run.triangles);
                self.mark.record(&self.gpu, encoder, canvas, bound, &run.triangles, &marks);
            });
        }
        marks.read(&self.gpu, run.view)
    }

    /// Does the same as [`Self::behind_any`] without the `forgiven` pairs (front, back), sorted. The nearest
    /// item may be a forgiven one while another unforgiven one is in front, too, so every pair is counted.
    pub(super) fn behind_unforgiven(
        &self,
        run: &DrawnItems,
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
