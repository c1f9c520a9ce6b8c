//! Pass *flakes* (`shaders/flakes.wgsl`): the nearest sample of the images in view at each sub-pixel.

use std::ops::Range;

use wgpu::{BindGroup, BindGroupLayout, Buffer, BufferUsages, ComputePipeline, ShaderStages};

use super::flake::{self, FlakeImageWords, FlakeRowsWords, SpeciesImages};
use super::slices::Slices;
use super::{door, flakes_narrow, flakes_wide};
use crate::error::Result;
use crate::gpu::bindings::{self, BindingKind};
use crate::gpu::device::Gpu;
use crate::gpu::renderer::project::SURFACES;
use crate::gpu::renderer::table::GrowingBuffer;

const FLAKES: &str = include_str!("../../../../shaders/flakes.wgsl");

/// The invocations of a workgroup.
const WORKGROUP: u32 = 256;
/// The bytes that are kept of a sub-pixel.
const BYTES: u64 = 8;

/// Returns the complete WGSL source: one run where words of 64 bits can be compared, else the first of two or the second.
pub fn source(samples: u32, run: Run) -> String {
    let keep = match run {
        Run::Only => flakes_wide::SOURCE.to_owned(),
        Run::First => flakes_narrow::source(false),
        Run::Second => flakes_narrow::source(true),
    };
    [SURFACES, door::SOURCE, &flake::source(samples), &keep, FLAKES].concat()
}

/// A run over the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Run {
    /// The only one.
    Only,
    /// The first of two.
    First,
    /// The second of two.
    Second,
}

/// The rows of a picture that are drawn together, with what is kept of their sub-pixels.
#[derive(Debug)]
pub struct Band {
    /// [`FlakeRowsWords`].
    pub rows: Buffer,
    /// [`BYTES`] a sub-pixel.
    pub kept: Buffer,
}

/// The images in view with all that the pass needs.
#[derive(Debug)]
pub struct Flakes {
    /// Frame, then images, then samples.
    layouts: [BindGroupLayout; 3],
    /// For 1 sample a pixel and for more: the runs.
    pipelines: [Option<Vec<ComputePipeline>>; 2],
    /// [`FlakeImageWords`].
    pub images: GrowingBuffer,
    jobs: GrowingBuffer,
    /// The jobs of each species: image and first sample of each workgroup.
    of_species: Vec<Range<u64>>,
    /// The size of the picture for which `bands` are, and its samples a pixel.
    size: [u32; 3],
    /// All rows of the picture.
    pub bands: Vec<Band>,
}

impl Flakes {
    /// Creates empty tables.
    pub fn new(gpu: &Gpu) -> Self {
        let of = |label, kinds: &[BindingKind]| bindings::layout(gpu, label, ShaderStages::COMPUTE, kinds);
        let tables = [BindingKind::Uniform, BindingKind::Read, BindingKind::Write, BindingKind::Read];
        let layouts = [
            of("frame", &[BindingKind::Uniform]),
            of("images in view", &tables),
            of("samples", &[BindingKind::Read]),
        ];
        let table = |label| GrowingBuffer::new(gpu, label, BufferUsages::STORAGE);
        Self {
            layouts,
            pipelines: [None, None],
            images: table("images in view"),
            jobs: table("work on images"),
            of_species: Vec::new(),
            size: [0; 3],
            bands: Vec::new(),
        }
    }

    /// Writes the images in view, which come species by species, and makes room for a picture of this size (width, height,
    /// samples a pixel). Returns whether there are any.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        images: &mut [FlakeImageWords],
        species: usize,
        size: [u32; 3],
    ) -> bool {
        let mut jobs: Vec<[u32; 2]> = Vec::new();
        self.of_species = vec![0..0; species];
        let mut before = 0u32;
        let alignment = alignment(gpu);
        for (index, image) in (0..).zip(images.iter_mut()) {
            image.before = before;
            // Words can tell so many samples apart; the device could not draw more in minutes.
            image.count = image.count.min(u32::MAX - 1 - before);
            before += image.count;
            let range = &mut self.of_species[image.species as usize];
            if range.is_empty() {
                // Jobs past all samples fill up.
                jobs.resize(jobs.len().next_multiple_of(alignment as usize), [index, 1 << 31]);
                *range = jobs.len() as u64..jobs.len() as u64;
            }
            jobs.extend((0..image.count).step_by(WORKGROUP as usize).map(|first| [index, first]));
            range.end = jobs.len() as u64;
        }
        if jobs.is_empty() {
            return false;
        }
        self.images.write(gpu, images);
        self.jobs.write(gpu, &jobs);
        if self.size != size {
            self.size = size;
            self.bands = bands(gpu, size);
        }
        let samples = size[2];
        let pipelines = &mut self.pipelines[usize::from(samples > 1)];
        if pipelines.is_none() {
            *pipelines = Some(made(gpu, samples, &self.layouts));
        }
        true
    }

    /// Finds the nearest samples of all rows.
    ///
    /// # Errors
    /// Those of [`Slices::hand_over`].
    pub fn record(
        &self,
        slices: &mut Slices,
        frame: wgpu::BindingResource,
        species: &[Option<&SpeciesImages>],
    ) -> Result<()> {
        let gpu = slices.gpu();
        let frame = bindings::bind(gpu, "frame", &self.layouts[0], &[frame]);
        let pipelines = self.pipelines[usize::from(self.size[2] > 1)].as_ref().expect("they were made");
        // A sample is examined by each run and in each band.
        let times = (self.bands.len() * pipelines.len()) as f64;
        let at_once = (slices.most() * times / f64::from(WORKGROUP)) as usize;
        let at_once = at_once.max(1).next_multiple_of(alignment(gpu) as usize);
        for band in &self.bands {
            slices.encoder().clear_buffer(&band.kept, 0, None);
            for pipeline in pipelines {
                for (images, jobs) in species.iter().zip(&self.of_species) {
                    let Some(images) = images else { continue };
                    let samples = [images.samples.as_entire_binding()];
                    let samples = bindings::bind(gpu, "samples", &self.layouts[2], &samples);
                    for first in jobs.clone().step_by(at_once) {
                        let jobs = first..jobs.end.min(first + at_once as u64);
                        let mut pass = slices.encoder().begin_compute_pass(&Default::default());
                        pass.set_pipeline(pipeline);
                        pass.set_bind_group(0, &frame, &[]);
                        pass.set_bind_group(1, &self.tables(gpu, band, &jobs), &[]);
                        pass.set_bind_group(2, &samples, &[]);
                        let count = (jobs.end - jobs.start) as u32;
                        let most = gpu.device.limits().max_compute_workgroups_per_dimension;
                        let across = count.min(most);
                        pass.dispatch_workgroups(across, count.div_ceil(across), 1);
                        drop(pass);
                        slices.count(f64::from(count) * f64::from(WORKGROUP) / times)?;
                    }
                }
            }
        }
        Ok(())
    }

    fn tables(&self, gpu: &Gpu, band: &Band, jobs: &Range<u64>) -> BindGroup {
        let bytes = size_of::<[u32; 2]>() as u64;
        let jobs = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: self.jobs.buffer(),
            offset: jobs.start * bytes,
            size: std::num::NonZeroU64::new((jobs.end - jobs.start) * bytes),
        });
        let resources =
            [band.rows.as_entire_binding(), self.images.binding(), band.kept.as_entire_binding(), jobs];
        bindings::bind(gpu, "images in view", &self.layouts[1], &resources)
    }
}

/// Returns the number of jobs between two places at which a binding of jobs may begin.
fn alignment(gpu: &Gpu) -> u64 {
    let bytes = u64::from(gpu.device.limits().min_storage_buffer_offset_alignment);
    (bytes / size_of::<[u32; 2]>() as u64).max(1)
}

/// Makes as many bands of rows as the device's bindings ask for.
fn bands(gpu: &Gpu, [width, height, samples]: [u32; 3]) -> Vec<Band> {
    let row = BYTES * u64::from(width) * u64::from(samples);
    let rows = (gpu.largest_binding() / row).clamp(1, u64::from(height)) as u32;
    let band = |first: u32| {
        let count = rows.min(height - first);
        let words = FlakeRowsWords { first, count, width, pad0: 0 };
        Band {
            rows: bindings::filled(gpu, "rows", &[words], BufferUsages::UNIFORM),
            kept: bindings::storage(gpu, "nearest samples", u64::from(count) * row / 4, false),
        }
    };
    (0..height).step_by(rows as usize).map(band).collect()
}

fn made(gpu: &Gpu, samples: u32, layouts: &[BindGroupLayout; 3]) -> Vec<ComputePipeline> {
    let runs: &[Run] = if gpu.has_wide_atomics() { &[Run::Only] } else { &[Run::First, Run::Second] };
    let pipeline = |run: &Run| {
        let module = bindings::shader(gpu, "flakes", &source(samples, *run));
        bindings::compute(gpu, "flakes", &module, &layouts.each_ref())
    };
    runs.iter().map(pipeline).collect()
}
