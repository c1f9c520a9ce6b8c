//! Pass *stencil* (`shaders/stencil.wgsl`), and stencil peeling as published in 2003: the results are those
//! of the published method, computed as efficiently as possible. The marks stay on the device, and one flag
//! per item is read back per round.

use wgpu::{BindGroupLayout, BindingResource, CommandEncoder};

use super::bindings::BindingKind;
use super::device::Gpu;
use super::drawing::{Attachments, DrawPipeline, ITEMS, Style, Triangles};
use super::frame::{BoundRows, PhotoRows};
use super::mark::Marks;
use super::rasteriser::{GpuRasteriser, flagged};
use super::run::DrawnItems;
use super::workspace::{self, Workspace};
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_layers::ProjectedModel;
use quadratura_layers::rasteriser::StencilLayers;

/// The WGSL source of the pass.
pub const SOURCE: &str = include_str!("../../shaders/stencil.wgsl");

/// The pipeline of the pass.
#[derive(Debug)]
pub struct Stencil {
    draw: DrawPipeline,
}

impl Stencil {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu, frame: &BindGroupLayout) -> Self {
        let kinds = &[BindingKind::Depth, BindingKind::Ids, BindingKind::Write];
        Self {
            draw: DrawPipeline::new(
                gpu,
                frame,
                Style { name: "stencil", source: SOURCE, kinds, ..Style::LOOK },
            ),
        }
    }

    /// Records the pass: it adds the marks of a band that pass *farthest* has drawn into `depth` and `items`
    /// of the canvas.
    fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        canvas: Attachments,
        bound: BoundRows,
        triangles: &Triangles,
        marks: &Marks,
    ) {
        let items = canvas.items.expect("pass farthest has drawn the item buffer");
        let textures = [canvas.depth, items].map(BindingResource::TextureView);
        let own = self.draw.bind(gpu, &[&textures[..], &[marks.resource()]].concat());
        self.draw.record(encoder, Attachments { items: None, ..canvas }, bound, &own, triangles);
    }
}

/// The fixed inputs of peeling a view.
struct PeelInputs<'a> {
    view: &'a ProjectedModel,
    tolerance: f32,
    canvas: Attachments<'a>,
    task: &'a Task,
}

impl GpuRasteriser {
    /// Peels all layers of the items flagged in `working`.
    pub(super) fn peel(
        &self,
        view: &ProjectedModel,
        tolerance: f32,
        space: &Workspace,
        working: &[bool],
        task: &Task,
    ) -> Result<StencilLayers> {
        let items = workspace::texture(&self.gpu, "items", space.size(), ITEMS);
        let canvas = Attachments { depth: &space.depth, items: Some(&items) };
        let peeling = PeelInputs { view, tolerance, canvas, task };
        let mut layers = StencilLayers { layer: vec![None; view.items.len()], passes: 0, locked: 0 };
        let mut rest = working.to_vec();
        for layer in 0.. {
            if !rest.contains(&true) {
                break;
            }
            let found = self.peel_one(&peeling, &rest, &mut layers.passes)?;
            // A round that empties the set ends the peeling: the remaining items become one last layer.
            let found = found.unwrap_or_else(|| {
                layers.locked = rest.iter().filter(|&&left| left).count() as u32;
                rest.clone()
            });
            for item in (0..found.len()).filter(|&item| found[item]) {
                layers.layer[item] = Some(layer);
                rest[item] = false;
            }
        }
        Ok(layers)
    }

    /// Peels one layer off the `rest`: rounds remove partly hidden items until there are none. Returns `None`
    /// when a round emptied the set.
    fn peel_one(&self, peeling: &PeelInputs, rest: &[bool], rounds: &mut u32) -> Result<Option<Vec<bool>>> {
        let mut set = rest.to_vec();
        while set.contains(&true) {
            peeling.task.check_cancelled()?;
            *rounds += 1;
            let hidden = self.partly_hidden(peeling, &set)?;
            if !hidden.contains(&true) {
                return Ok(Some(set));
            }
            for (alive, hidden) in set.iter_mut().zip(hidden) {
                *alive &= !hidden;
            }
        }
        Ok(None)
    }

    /// Finds the partly hidden items of a set. The set is drawn twice, because with a tolerance the farthest
    /// fragment must be known before the others can be compared with it.
    fn partly_hidden(&self, peeling: &PeelInputs, set: &[bool]) -> Result<Vec<bool>> {
        let PeelInputs { view, tolerance, canvas, .. } = *peeling;
        let run = DrawnItems::some_items(&self.gpu, view, tolerance, flagged(set))?;
        let marks = Marks::new(&self.gpu, view);
        for rows in self.bands(view) {
            let frame = PhotoRows::band(view, rows);
            let shared = self.share(&run, &frame);
            let bound = BoundRows { rows: &frame, group: &shared };
            self.submit(|encoder| {
                self.farthest.record(encoder, canvas, bound, &run.triangles);
                self.stencil.record(&self.gpu, encoder, canvas, bound, &run.triangles, &marks);
            });
        }
        marks.read(&self.gpu, view)
    }
}
