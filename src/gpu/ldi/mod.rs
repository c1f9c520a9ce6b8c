//! The warp of layered depth images on the GPU, for windows: files and scores are drawn by the processor
//! ([`quadratura_ldi::warp()`]), which gives the same bytes everywhere.
//!
//! | pass | result |
//! |---|---|
//! | *nearest* | inverse depth of the nearest depth pixel, per pixel of the picture |
//! | *surface* | its surface |
//! | *sums* | the sums of what is level with it: the near slot |
//! | *nearest*, *surface*, *sums* again | the same of what is behind, where the near slot lets it through: the far slot |
//! | *resolve* | near over far |
//! | *find* | the nearest depth pixel, per pixel: single pixels in place of sums |
//! | *show* | its colour |
//!
//! Depth pixels come in any order here, and maxima and sums of integers do not depend on it: one device gives the same bytes
//! each time. What the processor decides by the order of drawing is decided by depth: see [`GpuWarp::picture`].

mod device;
mod dots;
mod level;
mod nearest;
mod pixel;
mod resolve;
mod show;
mod slots;
mod space;
mod sums;
mod surface;
#[cfg(test)]
mod tests;
mod uploaded;
mod view;
mod wide_pixel;

use std::ops::Range;
use std::sync::Arc;

use wgpu::{ComputePass, ComputePipeline};

use self::space::Space;
pub use self::uploaded::GpuLdi;
use self::uploaded::LevelChunk;
use self::view::{Layouts, ViewTables, ViewUniform, WORKGROUP};
use super::device::Gpu;
use super::renderer::render_target::judge;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_ldi::stretch::LONGEST;
use quadratura_ldi::warp::moves::Moves;
use quadratura_ldi::{Ldi, Spacing, SplatKind, WarpOptions, Warped};
use quadratura_view::{Picture, Shot};

/// The passes by which a kind of splat is drawn: over depth pixels, one after the other, then over the picture's pixels.
#[derive(Debug)]
struct SplatPasses {
    over_dots: Vec<ComputePipeline>,
    over_pixels: ComputePipeline,
}

/// Draws views of layered depth images on a device. It is long-lived: pipelines and buffers are reused from view to view.
#[derive(Debug)]
pub struct GpuWarp {
    gpu: Gpu,
    layouts: Layouts,
    sums: SplatPasses,
    single: SplatPasses,
    tables: ViewTables,
    space: Space,
    /// The largest number of depth pixels in one binding.
    most_of_chunk: u64,
    /// The largest number of pixels that are drawn at once.
    most_pixels: u64,
}

impl GpuWarp {
    /// Builds the pipelines.
    ///
    /// # Errors
    /// [`Error::Gpu`] when the device cannot run the passes.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        gpu.guarded("preparing the warp of layered depth images", || {
            let layouts = Layouts::new(gpu);
            Ok(Self {
                sums: SplatPasses::of_sums(gpu, &layouts),
                single: SplatPasses::of_single_pixels(gpu, &layouts, gpu.has_wide_atomics()),
                tables: ViewTables::new(gpu),
                space: Space::new(gpu, &layouts),
                most_of_chunk: uploaded::most_of_chunk(gpu),
                most_pixels: space::most_pixels(gpu),
                layouts,
                gpu: gpu.clone(),
            })
        })
    }

    /// Divides images into chunks of at most so many depth pixels, and pictures into rows of at most so many pixels, as on a
    /// device with small bindings. Images that were uploaded before keep their chunks.
    #[must_use]
    pub fn with_limits(mut self, most_of_chunk: u64, most_pixels: u64) -> Self {
        self.most_of_chunk = most_of_chunk.min(self.most_of_chunk);
        self.most_pixels = most_pixels.min(self.most_pixels);
        self
    }

    /// Finds single pixels in two runs, as on a device that has no maxima of words of 64 bits.
    #[must_use]
    pub fn without_wide_atomics(mut self) -> Self {
        self.single = SplatPasses::of_single_pixels(&self.gpu, &self.layouts, false);
        self
    }

    /// Uploads an image, with all its levels: 16 bytes a depth pixel.
    ///
    /// # Errors
    /// [`Error::Gpu`] when the device has not enough memory.
    pub fn upload(&self, ldi: Arc<Ldi>) -> Result<GpuLdi> {
        self.gpu.guarded("uploading a layered depth image", || {
            Ok(GpuLdi::new(&self.gpu, &self.layouts, ldi, self.most_of_chunk))
        })
    }

    /// Makes a view of an image that was uploaded to the same device, by sums or single pixels, with the same level, sides,
    /// spacing, clipping and exposure as [`quadratura_ldi::warp()`]; the order of drawing does not count. It differs where the
    /// processor goes by that order:
    ///
    /// - Slots are around the depths of the nearest depth pixel, and of the nearest one behind its tolerance. On the processor a
    ///   slot's depth grows while it is filled.
    /// - Where a slot holds more than one surface, the surface of the nearest depth pixel replaces the others as far as its
    ///   weights reach; the processor lets each later depth pixel replace its share. Unknown surfaces are mixed.
    /// - Behind the near slot, splats of more than a slight weight come before others. The processor compares sums.
    /// - A single pixel shows the nearest depth pixel that is mostly opaque, not the last one, and nothing through it.
    ///
    /// # Errors
    /// [`Error::Gpu`] when the device cannot draw a picture of this size, or is lost; [`Error::Request`] for the published
    /// splats and spacing, which the processor draws; [`Error::Cancelled`].
    pub fn picture(
        &mut self,
        ldi: &GpuLdi,
        shot: &Shot,
        options: &WarpOptions,
        task: &Task,
    ) -> Result<Warped> {
        judge(&self.gpu, shot)?;
        if options.splat == SplatKind::Over || options.spacing == Spacing::Table {
            return Err(Error::Request(
                "the GPU draws layered depth images by sums or single pixels, with the exact spacing; the published \
                 splats and spacing are drawn by the processor"
                    .into(),
            ));
        }
        let gpu = self.gpu.clone();
        gpu.guarded("drawing a layered depth image", || self.draw(ldi, shot, options, task))
    }

    fn draw(&mut self, ldi: &GpuLdi, shot: &Shot, options: &WarpOptions, task: &Task) -> Result<Warped> {
        let moves = Moves::new(ldi.ldi(), shot, options);
        self.tables.write(&self.gpu, &moves, options);
        let (width, height) = (shot.camera.width, shot.camera.height);
        let rows = (self.most_pixels / u64::from(width)).clamp(1, u64::from(height)) as u32;
        let mut rgba = Vec::with_capacity(4 * width as usize * height as usize);
        let mut too_near = 0;
        for top in (0..height).step_by(rows as usize) {
            task.check_cancelled()?;
            let rows = top..height.min(top + rows);
            let view = self.view_of(&moves, &rows, [width, height], options.splat);
            let (colours, near) = self.draw_rows(ldi.chunks(moves.level), &view, options.splat)?;
            rgba.extend_from_slice(bytemuck::cast_slice(&colours));
            too_near += u64::from(near);
        }
        let (picture, level) = (Picture { width, height, rgba }, moves.level);
        let depth_pixels = ldi.ldi().levels[level].len() as u64;
        Ok(Warped { picture, level, depth_pixels, too_near })
    }

    /// Draws some rows of a picture; returns their colours and the number of depth pixels that are magnified too much.
    fn draw_rows(
        &mut self,
        chunks: &[LevelChunk],
        view: &ViewUniform,
        splat: SplatKind,
    ) -> Result<(Vec<u32>, u32)> {
        let with_sums = splat == SplatKind::Sums;
        let pixels = u64::from(view.rows[1] - view.rows[0]) * u64::from(view.size[0]);
        self.space.reserve(&self.gpu, &self.layouts, pixels, with_sums);
        let tables = self.tables.bind(&self.gpu, &self.layouts, view);
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.space.clear(&mut encoder, pixels, with_sums);
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_bind_group(0, &tables, &[]);
        pass.set_bind_group(2, &self.space.group, &[]);
        let passes = if with_sums { &self.sums } else { &self.single };
        for pipeline in &passes.over_dots {
            dots::record(&mut pass, pipeline, chunks, view.within);
        }
        passes.record_over_pixels(&mut pass, chunks, pixels, with_sums);
        drop(pass);
        self.gpu.queue.submit([encoder.finish()]);
        self.space.read(&self.gpu, pixels)
    }

    /// Returns the uniform for some rows of a picture.
    fn view_of(&self, moves: &Moves, rows: &Range<u32>, size: [u32; 2], splat: SplatKind) -> ViewUniform {
        let reach = if splat == SplatKind::Sums { LONGEST } else { 0.0 };
        view::uniform(moves, size, rows, &moves.within(rows, reach))
    }
}

impl SplatPasses {
    fn of_sums(gpu: &Gpu, layouts: &Layouts) -> Self {
        let runs = [false, true].map(|far| level::FILLING.map(|pass| pass.pipeline(gpu, layouts, far)));
        Self { over_dots: runs.into_iter().flatten().collect(), over_pixels: resolve::pipeline(gpu, layouts) }
    }

    fn of_single_pixels(gpu: &Gpu, layouts: &Layouts, wide: bool) -> Self {
        let over_dots =
            if wide { wide_pixel::pipelines(gpu, layouts) } else { pixel::pipelines(gpu, layouts) };
        Self { over_dots, over_pixels: show::pipeline(gpu, layouts, wide) }
    }

    /// Records the last pass: once, or, where it reads depth pixels, for each chunk.
    fn record_over_pixels(&self, pass: &mut ComputePass, chunks: &[LevelChunk], pixels: u64, once: bool) {
        pass.set_pipeline(&self.over_pixels);
        let count = if once { 1 } else { chunks.len() };
        for chunk in chunks.iter().take(count) {
            pass.set_bind_group(1, &chunk.group, &[]);
            pass.dispatch_workgroups(pixels.div_ceil(u64::from(WORKGROUP)) as u32, 1, 1);
        }
    }
}
