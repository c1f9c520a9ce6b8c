//! The GPU implementation of [`Rasteriser`]: runs the passes in their order.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use wgpu::{BindGroupLayout, CommandEncoder};

use super::count::Count;
use super::device::Gpu;
use super::drawing::{Attachments, Triangles};
use super::farthest::Farthest;
use super::fill::Fill;
use super::frame::{self, BoundRows, PhotoRows};
use super::mark::MarkPass;
use super::nearest::Nearest;
use super::pairs::{self, Pairs};
use super::presence::{PresencePass, Sighting, Sightings};
use super::run::DrawnItems;
use super::scan::Scan;
use super::stencil::Stencil;
use super::workspace::Workspace;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_layers::rasteriser::{Presence as Seen, StencilLayers, TIE};
use quadratura_layers::{FragmentLists, Fragments, Occlusion, ProjectedModel, Rasteriser, count_pairs};

/// The largest number of pixels of a band. A photo of 8 megapixels is drawn in one piece, with about 200 MB
/// of buffers.
const BAND_PIXELS: u64 = 8 << 20;

/// The largest number of entries of a buffer, even where the adapter could bind more.
const MOST_ENTRIES: u64 = 1 << 26;

/// A rasteriser on a GPU, hardware or software. It is long-lived: it holds the pipelines, and buffers that
/// are reused for the next photo. Any number of threads may use it at a time.
#[derive(Debug)]
pub struct GpuRasteriser {
    pub(super) gpu: Gpu,
    pub(super) frame: BindGroupLayout,
    pub(super) nearest: Nearest,
    presence: PresencePass,
    pub(super) count: Count,
    pub(super) scan: Scan,
    pub(super) fill_pass: Fill,
    pub(super) pairs_pass: Pairs,
    pub(super) mark: MarkPass,
    pub(super) farthest: Farthest,
    pub(super) stencil: Stencil,
    /// Workspaces that are not in use.
    spare: Mutex<Vec<Workspace>>,
    /// True when pass *pairs* counts the table of occlusions, but for rows that would take it too long, false when the CPU
    /// does from the lists.
    pub(super) pairs_on_device: bool,
    pub(super) band_pixels: u64,
    pub(super) most_entries: u64,
}

impl GpuRasteriser {
    /// Builds all pipelines.
    ///
    /// # Errors
    /// [`Error::Gpu`] when the device rejects one.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        gpu.guarded("building the pipelines", || {
            let frame = frame::layout(gpu);
            Ok(Self {
                nearest: Nearest::new(gpu, &frame),
                presence: PresencePass::new(gpu, &frame),
                count: Count::new(gpu, &frame),
                scan: Scan::new(gpu, &frame),
                fill_pass: Fill::new(gpu, &frame),
                pairs_pass: Pairs::new(gpu, &frame),
                mark: MarkPass::new(gpu, &frame),
                farthest: Farthest::new(gpu, &frame),
                stencil: Stencil::new(gpu, &frame),
                spare: Mutex::default(),
                pairs_on_device: !gpu.is_software(),
                band_pixels: BAND_PIXELS.min(gpu.largest_binding() / 4 - 1),
                most_entries: MOST_ENTRIES.min(gpu.largest_binding() / 4),
                gpu: gpu.clone(),
                frame,
            })
        })
    }

    /// Selects whether pass *pairs* counts the table of occlusions, as by default, except rows that would take the device too
    /// long without a pause, or the CPU does from the lists read back, as by default on software adapters. The table is the same. But a software adapter
    /// takes ten times as long on the device, and Mesa's silently ends the loops of a shader after 65,535
    /// iterations: where some thirty faces lie behind each other, it would lose pairs.
    pub fn counting_pairs_on_device(self, on_device: bool) -> Self {
        Self { pairs_on_device: on_device, ..self }
    }

    /// Uses less memory at the cost of more passes: photos are drawn in bands of at most this many pixels (at
    /// least one row), and lists are made in parts of at most this many entries (those of one row must fit).
    /// Limits beyond the adapter's own have no effect.
    pub fn with_limits(self, band_pixels: u64, entries: u64) -> Self {
        let (band_pixels, most_entries) = (band_pixels.min(self.band_pixels), entries.min(self.most_entries));
        Self { band_pixels, most_entries, ..self }
    }

    /// Returns the bands of a view, from the top.
    pub(super) fn bands(&self, view: &ProjectedModel) -> Vec<Range<u32>> {
        frame::bands(view, self.band_pixels)
    }

    /// Records and submits commands.
    pub(super) fn submit(&self, record: impl FnOnce(&mut CommandEncoder)) {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        record(&mut encoder);
        self.gpu.queue.submit([encoder.finish()]);
    }

    /// Runs `work` with a workspace for the bands of a view, and catches the device's errors. `view` must
    /// have pixels.
    pub(super) fn with_workspace<T>(
        &self,
        doing: &str,
        view: &ProjectedModel,
        work: impl FnOnce(&mut Workspace, &[Range<u32>]) -> Result<T>,
    ) -> Result<T> {
        let bands = self.bands(view);
        let size = [view.width, bands.first().map_or(0, ExactSizeIterator::len) as u32];
        self.gpu.guarded(doing, || {
            check_size(&self.gpu, view)?;
            let mut spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner);
            let kept = spare.pop().filter(|space| space.size() == size);
            drop(spare);
            let mut space = kept.unwrap_or_else(|| Workspace::new(&self.gpu, size));
            let result = work(&mut space, &bands);
            self.spare.lock().unwrap_or_else(PoisonError::into_inner).push(space);
            result
        })
    }

    /// Draws everything, band by band, and returns the sightings of each item, which see-through items do not hide. The
    /// workspace keeps the nearest depths of the last band, without see-through items.
    fn sightings(
        &self,
        view: &ProjectedModel,
        space: &Workspace,
        bands: &[Range<u32>],
        task: &Task,
    ) -> Result<Vec<Sighting>> {
        let run = DrawnItems::of_all(&self.gpu, view, TIE);
        let solid = view
            .has_see_through()
            .then(|| Triangles::from_gpu(&self.gpu, view, |item| !view.items[item as usize].see_through));
        let hiding = solid.as_ref().unwrap_or(&run.triangles);
        let sightings = Sightings::new(&self.gpu, view.items.len());
        let canvas = Attachments { depth: &space.depth, items: None };
        for rows in bands {
            task.check_cancelled()?;
            let frame = PhotoRows::band(view, rows.clone());
            let shared = self.share(&run, &frame);
            let bound = BoundRows { rows: &frame, group: &shared };
            self.submit(|encoder| {
                self.nearest.record(encoder, canvas, bound, hiding);
                self.presence.record(&self.gpu, encoder, canvas, bound, &run.triangles, &sightings);
            });
        }
        sightings.read(&self.gpu, view.items.len())
    }

    /// Builds the lists of a run and its pairs. The nearest depths are drawn first, unless
    /// `nearest_is_drawn`.
    pub(super) fn lists_and_pairs(
        &self,
        run: &DrawnItems,
        space: &mut Workspace,
        bands: &[Range<u32>],
        nearest_is_drawn: bool,
        task: &Task,
    ) -> Result<(FragmentLists, Vec<Occlusion>)> {
        let mut table_bits = pairs::table_bits(&self.gpu, run.items.len());
        let mut lists = FragmentLists { width: run.view.width, bands: Vec::new() };
        let mut occlusions = Vec::new();
        for (done, rows) in bands.iter().enumerate() {
            task.step("fragments", done as u64, bands.len() as u64)?;
            for part in self.places(run, space, rows, nearest_is_drawn)? {
                self.fill(run, space, &part);
                let band = self.read_lists(space, &part)?;
                if self.pairs_on_device {
                    occlusions.extend(self.pairs(run, space, &part, &band, &mut table_bits)?);
                }
                lists.bands.push(band);
            }
        }
        lists.bands.sort_unstable_by_key(|band| band.y0);
        if !self.pairs_on_device {
            occlusions = count_pairs(run.view, &lists, run.tolerance);
        }
        Ok((lists, summed(occlusions)))
    }
}

impl Rasteriser for GpuRasteriser {
    fn fragments(&self, view: &ProjectedModel, tolerance: f32, task: &Task) -> Result<Fragments> {
        if is_empty(view) {
            return Ok(nothing(view));
        }
        self.with_workspace("listing fragments", view, |space, bands| {
            let seen = self.sightings(view, space, bands, task)?;
            let working: Vec<bool> = seen.iter().map(|seen| seen.visible != 0).collect();
            let run = DrawnItems::some_items(&self.gpu, view, tolerance, flagged(&working))?;
            let is_drawn = bands.len() == 1 && !view.has_see_through();
            let (lists, occlusions) = self.lists_and_pairs(&run, space, bands, is_drawn, task)?;
            let presence = seen.iter().map(|seen| seen.presence(&lists)).collect();
            Ok(Fragments { presence, lists, occlusions })
        })
    }

    fn occluded(
        &self,
        view: &ProjectedModel,
        tolerance: f32,
        alive: &[bool],
        forgiven: &[(u32, u32)],
    ) -> Result<Vec<bool>> {
        if is_empty(view) {
            return Ok(vec![false; view.items.len()]);
        }
        self.with_workspace("exact peeling", view, |space, _| {
            let run = DrawnItems::some_items(&self.gpu, view, tolerance, flagged(alive))?;
            if forgiven.is_empty() {
                self.behind_any(&run, space)
            } else {
                self.behind_unforgiven(&run, space, forgiven)
            }
        })
    }

    fn stencil_peeling(
        &self,
        view: &ProjectedModel,
        tolerance: f32,
        working: &[bool],
        task: &Task,
    ) -> Result<StencilLayers> {
        if is_empty(view) {
            let layer = working.iter().map(|working| working.then_some(0)).collect();
            return Ok(StencilLayers { layer, passes: 0, locked: 0 });
        }
        self.with_workspace("stencil peeling", view, |space, _| {
            self.peel(view, tolerance, space, working, task)
        })
    }
}

/// Returns true when the photo has no pixels, so that there is nothing to draw into.
fn is_empty(view: &ProjectedModel) -> bool {
    view.width == 0 || view.height == 0
}

/// Returns the items whose flag is set, rising.
pub(super) fn flagged(flags: &[bool]) -> Vec<u32> {
    (0..).zip(flags).filter(|(_, flag)| **flag).map(|(item, _)| item).collect()
}

/// Returns the result for a photo without pixels.
fn nothing(view: &ProjectedModel) -> Fragments {
    Fragments {
        presence: vec![Seen::Nowhere; view.items.len()],
        lists: FragmentLists { width: view.width, bands: Vec::new() },
        occlusions: Vec::new(),
    }
}

/// Checks that the adapter can draw a photo of this size.
///
/// # Errors
/// [`Error::Gpu`] when the photo is larger than what the adapter can draw.
fn check_size(gpu: &Gpu, view: &ProjectedModel) -> Result<()> {
    let most = gpu.device.limits().max_texture_dimension_2d;
    if view.width.max(view.height) <= most {
        return Ok(());
    }
    Err(Error::Gpu(format!(
        "the photo has {} x {} pixels, but {} draws at most {most} per side; make the photo smaller",
        view.width,
        view.height,
        gpu.adapter_summary()
    )))
}

/// Joins the pairs of several parts of a photo into one table, sorted.
fn summed(mut occlusions: Vec<Occlusion>) -> Vec<Occlusion> {
    occlusions.sort_unstable();
    occlusions.dedup_by(|next, kept| {
        let same = (next.front, next.back) == (kept.front, kept.back);
        kept.px += if same { next.px } else { 0 };
        same
    });
    occlusions
}
