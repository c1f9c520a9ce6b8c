//! Pass *flakes* (`shaders/flakes.wgsl`): the nearest sample of the images in view at each sub-pixel. Blocks of samples come in batches from
//! near to far, and pass *hidden* finds which of a batch are behind what was drawn before it.

use std::ops::Range;

use glam::Vec2;
use rayon::prelude::*;
use wgpu::{BindGroup, BindGroupLayout, Buffer, BufferUsages, ComputePipeline, ShaderStages};

use super::flake::{self, BLOCK, Block, FlakeImageWords, FlakeRowsWords, SpeciesImages};
use super::hidden::{Hidden, TileDepths, tiles};
use super::slices::Slices;
use super::{flakes_narrow, flakes_wide, stipple};
use crate::bindings::{self, BindingKind};
use crate::device::Gpu;
use crate::readback;
use crate::renderer::pipeline::SURFACES;
use crate::renderer::table::GrowingBuffer;
use quadratura_base::error::Result;

const FLAKES: &str = include_str!("../../../../shaders/flakes.wgsl");

/// Bindings of jobs begin at multiples of this many: at a multiple of 256 bytes, the most that a device may ask for, of a word each.
const ALIGNMENT: u32 = 64;
/// The bytes that are kept of a sub-pixel.
const BYTES: u64 = 8;
/// The most batches of blocks in a picture: each is tested against those before it, which costs a look at every sub-pixel.
const MOST_BATCHES: usize = 8;
/// The least number of blocks in a batch. With this many, in a picture of 960 x 540 pixels, the test pays where a sixteenth of them is hidden, since
/// it costs as much as drawing 250 blocks ([`LOOK`]).
const LEAST_OF_BATCH: usize = 1 << 12;
/// Looking at a sub-pixel costs about this part of drawing a sample.
const LOOK: f64 = 1.0 / 8.0;
/// The most samples in a picture. Words can tell twice as many apart; the device could not draw more in minutes.
const MOST_SAMPLES: u32 = 1 << 31;

/// Returns the invocations of a workgroup, which draws a block. A software adapter works on eight samples at once, and reads the words of an image
/// anew for each eight invocations: with 256 of them a view of 13 maples took three times as long as with 8. On an H200 numbers from 32 to 256 made no
/// difference.
pub fn invocations(is_software: bool) -> u32 {
    if is_software { 8 } else { 64 }
}

/// Returns the complete WGSL source, for a number of samples a pixel and of invocations a workgroup: one pass where words of 64 bits can be compared,
/// else the first of two or the second.
pub fn source(samples: u32, invocations: u32, pass: SamplePass) -> String {
    let keep = match pass {
        SamplePass::Only => flakes_wide::SOURCE.to_owned(),
        SamplePass::First => flakes_narrow::source(false),
        SamplePass::Second => flakes_narrow::source(true),
    };
    let invocations = format!("const INVOCATIONS = {invocations}u;\n");
    [SURFACES, stipple::SOURCE, &flake::source(samples), &keep, &invocations, FLAKES].concat()
}

/// A pass over the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SamplePass {
    /// The only one.
    Only,
    /// The first of two.
    First,
    /// The second of two.
    Second,
}

/// The rows of a picture that are drawn together, with what is kept of their sub-pixels.
#[derive(Debug)]
pub struct SubPixelBand {
    words: FlakeRowsWords,
    /// The same on the device.
    pub rows: Buffer,
    /// [`BYTES`] a sub-pixel.
    pub kept: Buffer,
    /// A word for each tile of pass *hidden*.
    pub tiles: Buffer,
    /// The number of tiles.
    pub tile_count: u32,
}

impl SubPixelBand {
    fn set_reach(&mut self, gpu: &Gpu, reach: u32) {
        self.words.reach = reach;
        self.rows = self.words.on_device(gpu);
    }
}

/// The jobs of blocks of about the same depth, for each species.
type JobsBySpecies = Vec<Range<u32>>;

/// A block of samples in the view.
#[derive(Debug, Clone, Copy, PartialEq)]
struct BlockInView {
    /// The depth of its nearest point.
    nearest: f32,
    species: u32,
    image: u32,
    /// Its first sample.
    first: u32,
}

/// What the bands of a picture depend on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FlakesExtent {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Samples a pixel.
    pub samples: u32,
    /// The most pixels that a sample reaches on each side of the pixel of its point.
    pub reach: u32,
}

/// The images in view with all that the pass needs.
#[derive(Debug)]
pub struct Flakes {
    /// Frame, then images, then samples.
    layouts: [BindGroupLayout; 3],
    /// For 1 sample a pixel and for more: the passes.
    pipelines: [Option<(Vec<ComputePipeline>, Hidden)>; 2],
    /// [`FlakeImageWords`].
    pub images: GrowingBuffer,
    /// Image and first sample of each block.
    jobs: GrowingBuffer,
    /// From near to far.
    pub batches: Vec<JobsBySpecies>,
    /// A word for each job, 1 where its block is hidden; found in each band anew.
    pub is_hidden: Buffer,
    /// Whether what is hidden is left out: always, but where tests compare.
    pub leaves_out: bool,
    /// [`LEAST_OF_BATCH`], or less in tests.
    pub least_of_batch: usize,
    /// The most bytes that a band keeps: what the device can bind, or less in tests.
    pub most_of_band: u64,
    /// The size of the picture for which `bands` are, its samples a pixel, and how far samples reach.
    extent: FlakesExtent,
    /// All rows of the picture.
    pub bands: Vec<SubPixelBand>,
}

impl Flakes {
    /// Creates empty tables.
    pub fn new(gpu: &Gpu) -> Self {
        let of = |label, kinds: &[BindingKind]| bindings::layout(gpu, label, ShaderStages::COMPUTE, kinds);
        use BindingKind::{Read, Uniform, Write};
        let tables = [Uniform, Read, Write, Read, Read];
        let layouts = [of("frame", &[Uniform]), of("images in view", &tables), of("samples", &[Read])];
        let table = |label| GrowingBuffer::new(gpu, label, BufferUsages::STORAGE);
        Self {
            layouts,
            pipelines: [None, None],
            images: table("images in view"),
            jobs: table("work on images"),
            batches: Vec::new(),
            is_hidden: bindings::storage(gpu, "hidden blocks", 0, false),
            leaves_out: true,
            least_of_batch: LEAST_OF_BATCH,
            most_of_band: gpu.largest_binding(),
            extent: FlakesExtent::default(),
            bands: Vec::new(),
        }
    }

    /// Makes room for a picture, and the pipelines.
    pub fn make(&mut self, gpu: &Gpu, extent: FlakesExtent) {
        let before = std::mem::replace(&mut self.extent, extent);
        if (before.size, before.samples) != (extent.size, extent.samples) {
            self.bands = bands(gpu, extent, self.most_of_band);
        } else if before.reach != extent.reach {
            self.bands.iter_mut().for_each(|band| band.set_reach(gpu, extent.reach));
        }
        let samples = extent.samples;
        let pipelines = &mut self.pipelines[usize::from(samples > 1)];
        if pipelines.is_none() {
            *pipelines =
                Some((made(gpu, samples, &self.layouts), Hidden::new(gpu, &self.layouts[0], samples)));
        }
    }

    /// Writes the images in view. Returns whether there are any.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        images: &mut [FlakeImageWords],
        species: &[Option<&SpeciesImages>],
    ) -> bool {
        let mut before = 0u32;
        for image in images.iter_mut() {
            image.before = before;
            image.count = image.count.min(MOST_SAMPLES - before);
            before += image.count;
        }
        let mut jobs: Vec<[u32; 2]> = Vec::new();
        self.batches.clear();
        for batch in batched(in_view(images, species), self.least_of_batch) {
            let mut of_species = vec![0..0; species.len()];
            for blocks in batch.chunk_by(|a, b| a.species == b.species) {
                // Jobs past all samples fill up.
                jobs.resize(jobs.len().next_multiple_of(ALIGNMENT as usize), [0, 1 << 31]);
                let first = jobs.len() as u32;
                jobs.extend(blocks.iter().map(|block| [block.image, block.first]));
                of_species[blocks[0].species as usize] = first..jobs.len() as u32;
            }
            self.batches.push(of_species);
        }
        if jobs.is_empty() {
            return false;
        }
        self.images.write(gpu, images);
        self.jobs.write(gpu, &jobs);
        if self.is_hidden.size() < 4 * jobs.len() as u64 {
            self.is_hidden = bindings::storage(gpu, "hidden blocks", 2 * jobs.len() as u64, false);
        }
        true
    }

    /// Returns what `depths` holds by tiles, when the commands so far are done. `is_first` is true before the first batch of a picture.
    ///
    /// # Errors
    /// Those of [`Slices::hand_over`] and [`readback::read`].
    pub fn tiles(
        &self,
        slices: &mut Slices,
        frame: wgpu::BindingResource,
        depths: &wgpu::TextureView,
        is_first: bool,
        [focal, center]: [Vec2; 2],
    ) -> Result<TileDepths> {
        let gpu = slices.gpu();
        let frame = bindings::bind(gpu, "frame", &self.layouts[0], &[frame]);
        let (_, hidden) =
            self.pipelines[usize::from(self.extent.samples > 1)].as_ref().expect("they were made");
        for band in &self.bands {
            if is_first {
                // Samples of the picture before; none of this one are kept yet.
                slices.encoder().clear_buffer(&band.kept, 0, None);
            }
            let tables = self.tested(gpu, hidden, band, depths);
            hidden.reduce(gpu, slices.encoder(), [&frame, &tables], band.tile_count);
            slices.count(LOOK * (band.kept.size() / BYTES) as f64)?;
        }
        slices.hand_over()?;
        let nearness = |band: &SubPixelBand| {
            let [words] = readback::read(gpu, [(&band.tiles, 0..u64::from(band.tile_count))])?;
            Ok((band.words.first, band.words.count, words.into_iter().map(f32::from_bits).collect()))
        };
        Ok(TileDepths {
            focal,
            center,
            width: self.extent.size[0],
            bands: self.bands.iter().map(nearness).collect::<Result<_>>()?,
        })
    }

    /// Finds the nearest samples of all rows, without blocks that are behind others or behind what `depths` holds.
    ///
    /// # Errors
    /// Those of [`Slices::hand_over`].
    pub fn record(
        &self,
        slices: &mut Slices,
        frame: wgpu::BindingResource,
        species: &[Option<&SpeciesImages>],
        depths: &wgpu::TextureView,
    ) -> Result<()> {
        let gpu = slices.gpu();
        let frame = bindings::bind(gpu, "frame", &self.layouts[0], &[frame]);
        let samples = |of: &&SpeciesImages| {
            let samples = [of.samples.as_entire_binding()];
            bindings::bind(gpu, "samples", &self.layouts[2], &samples)
        };
        let samples: Vec<Option<BindGroup>> = species.iter().map(|of| of.as_ref().map(samples)).collect();
        let (passes, hidden) =
            self.pipelines[usize::from(self.extent.samples > 1)].as_ref().expect("they were made");
        // A sample is examined by each pass and in each band.
        let times = (self.bands.len() * passes.len()) as f64;
        for band in &self.bands {
            slices.encoder().clear_buffer(&band.kept, 0, None);
            slices.encoder().clear_buffer(&self.is_hidden, 0, None);
            let tables = self.tested(gpu, hidden, band, depths);
            for (pass, pipeline) in passes.iter().enumerate() {
                for batch in &self.batches {
                    // What is found in the first pass holds in the second.
                    if pass == 0 && self.leaves_out {
                        let groups = [&frame, &tables];
                        hidden.record(gpu, slices.encoder(), groups, band.tile_count, species, batch);
                        slices.count(LOOK * (band.kept.size() / BYTES) as f64)?;
                    }
                    for (samples, jobs) in samples.iter().zip(batch) {
                        if let Some(samples) = samples {
                            self.record_jobs(slices, pipeline, band, [&frame, samples], jobs, times)?;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Binds what pass *hidden* tests in a band.
    fn tested(
        &self,
        gpu: &Gpu,
        hidden: &Hidden,
        band: &SubPixelBand,
        depths: &wgpu::TextureView,
    ) -> BindGroup {
        let read = [&band.rows, &band.kept, &band.tiles, &self.is_hidden];
        hidden.bind(gpu, read, [self.images.binding(), self.jobs.binding()], depths)
    }

    /// Examines the samples of these jobs, which are of one species, as one of so many times.
    fn record_jobs(
        &self,
        slices: &mut Slices,
        pipeline: &ComputePipeline,
        band: &SubPixelBand,
        [frame, samples]: [&BindGroup; 2],
        jobs: &Range<u32>,
        times: f64,
    ) -> Result<()> {
        let gpu = slices.gpu();
        let at_once = (slices.most() * times / f64::from(BLOCK)) as usize;
        let at_once = at_once.max(1).next_multiple_of(ALIGNMENT as usize);
        for first in jobs.clone().step_by(at_once) {
            let jobs = first..jobs.end.min(first.saturating_add(at_once as u32));
            let mut pass = slices.encoder().begin_compute_pass(&Default::default());
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, frame, &[]);
            pass.set_bind_group(1, &self.tables(gpu, band, &jobs), &[]);
            pass.set_bind_group(2, samples, &[]);
            let count = jobs.end - jobs.start;
            bindings::dispatch(gpu, &mut pass, count);
            drop(pass);
            slices.count(f64::from(count) * f64::from(BLOCK) / times)?;
        }
        Ok(())
    }

    fn tables(&self, gpu: &Gpu, band: &SubPixelBand, jobs: &Range<u32>) -> BindGroup {
        let of_jobs = |buffer, bytes: u64| {
            wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer,
                offset: u64::from(jobs.start) * bytes,
                size: std::num::NonZeroU64::new(u64::from(jobs.end - jobs.start) * bytes),
            })
        };
        let resources = [
            band.rows.as_entire_binding(),
            self.images.binding(),
            band.kept.as_entire_binding(),
            of_jobs(self.jobs.buffer(), size_of::<[u32; 2]>() as u64),
            of_jobs(&self.is_hidden, size_of::<u32>() as u64),
        ];
        bindings::bind(gpu, "images in view", &self.layouts[1], &resources)
    }
}

/// Returns the blocks of all images.
fn in_view(images: &[FlakeImageWords], species: &[Option<&SpeciesImages>]) -> Vec<BlockInView> {
    let of_image = |(index, image): (usize, &FlakeImageWords)| {
        let of_species = species[image.species as usize];
        let blocks = of_species.map_or(&[][..], |of| &of.blocks[image.first_block as usize..]);
        let firsts = (0..image.count).step_by(BLOCK as usize);
        let in_view = |(first, block): (u32, &Block)| BlockInView {
            nearest: block.nearest(image),
            species: image.species,
            image: index as u32,
            first,
        };
        firsts.zip(blocks).map(in_view).collect::<Vec<_>>()
    };
    images.par_iter().enumerate().flat_map_iter(of_image).collect()
}

/// Returns blocks from near to far in batches of equal size, in a batch species by species.
fn batched(mut blocks: Vec<BlockInView>, least_of_batch: usize) -> Vec<Vec<BlockInView>> {
    let place = |of: &BlockInView| (of.species, of.image, of.first);
    blocks.par_sort_unstable_by(|a, b| a.nearest.total_cmp(&b.nearest).then(place(a).cmp(&place(b))));
    let count = (blocks.len() / least_of_batch).clamp(1, MOST_BATCHES);
    let mut batches: Vec<_> = blocks.chunks(blocks.len().div_ceil(count).max(1)).map(<[_]>::to_vec).collect();
    batches.iter_mut().for_each(|batch| batch.par_sort_unstable_by_key(place));
    batches
}

/// Makes bands of rows that keep `most` bytes each at most, or a row.
fn bands(gpu: &Gpu, extent: FlakesExtent, most: u64) -> Vec<SubPixelBand> {
    let FlakesExtent { size: [width, height], samples, reach } = extent;
    let row = BYTES * u64::from(width) * u64::from(samples);
    let rows = (most / row).clamp(1, u64::from(height)) as u32;
    let band = |first: u32| {
        let count = rows.min(height - first);
        let words = FlakeRowsWords { first, count, width, reach };
        let tile_count = tiles(width, count);
        SubPixelBand {
            words,
            rows: words.on_device(gpu),
            kept: bindings::storage(gpu, "nearest samples", u64::from(count) * row / 4, false),
            tiles: bindings::storage(gpu, "tiles", u64::from(tile_count), false),
            tile_count,
        }
    };
    (0..height).step_by(rows as usize).map(band).collect()
}

fn made(gpu: &Gpu, samples: u32, layouts: &[BindGroupLayout; 3]) -> Vec<ComputePipeline> {
    let passes: &[SamplePass] =
        if gpu.has_wide_atomics() { &[SamplePass::Only] } else { &[SamplePass::First, SamplePass::Second] };
    let pipeline = |pass: &SamplePass| {
        let module = bindings::shader(gpu, "flakes", &source(samples, invocations(gpu.is_software()), *pass));
        bindings::compute(gpu, "flakes", &module, &layouts.each_ref())
    };
    passes.iter().map(pipeline).collect()
}
