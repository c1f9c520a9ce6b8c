//! Pass *hidden* (`shaders/hidden.wgsl`): which blocks of samples of trees are behind what was drawn before them.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec4, Vec4Swizzles};
use wgpu::{
    BindGroup, BindGroupLayout, BindingResource, Buffer, BufferUsages, CommandEncoder, ComputePipeline,
    ShaderStages, TextureView,
};

use super::extent::extent;
use super::flake::{self, SpeciesImages};
use crate::bindings::{self, BindingKind};
use crate::device::Gpu;
use crate::renderer::pipeline::SURFACES;

const HIDDEN: &str = include_str!("../../../../shaders/hidden.wgsl");

/// The side of a tile in pixels. With 8, a tenth less was found to be hidden.
pub const TILE: u32 = 4;
/// Depths of balls and of triangles are rounded, by this share at most.
pub const ROUNDING: f32 = 2e-6;
/// Corners of triangles are projected in single precision, to less than this.
const MARGIN_PX: f32 = 0.1;
/// The invocations of a workgroup.
pub const WORKGROUP: u32 = 64;

/// The jobs that are tested in the layout of the shader (`Tested`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct TestedWords {
    pub first: u32,
    pub count: u32,
    pub pad0: u32,
    pub pad1: u32,
}

/// Returns the complete WGSL source for a number of samples a pixel.
pub fn source(samples: u32) -> String {
    let kind = if samples == 1 { "texture_depth_2d" } else { "texture_depth_multisampled_2d" };
    let depths = format!("@group(1) @binding(6) var depths: {kind};\n");
    [SURFACES, &flake::source(samples), &depths, HIDDEN].concat()
}

/// The depths of the farthest sub-pixels of the tiles of a picture, read back.
#[derive(Debug)]
pub struct TileDepths {
    /// The focal lengths of the view, in pixels.
    pub focal: Vec2,
    /// Its centre, in pixels.
    pub center: Vec2,
    /// Its width in pixels.
    pub width: u32,
    /// Bands of rows: the first row, the number of rows, and the nearness of each tile.
    pub bands: Vec<(u32, u32, Vec<f32>)>,
}

impl TileDepths {
    /// Returns whether nothing can be seen of what is in a ball in the camera's frame, whose radius is the last component: like `is_covered`
    /// of the shader.
    pub fn hide(&self, ball: &Vec4) -> bool {
        let farthest = ball.z + ball.w;
        let nearest = ball.z - ball.w - ROUNDING * farthest;
        let (low, high) = (ball.xy() - ball.w, ball.xy() + ball.w);
        let corners = [low.extend(nearest), high.extend(farthest)];
        let Some([from, to]) = extent(corners, [self.focal, self.center]) else { return false };
        let (from, to) = (from - MARGIN_PX, to + MARGIN_PX);
        let across = self.width.div_ceil(TILE);
        let is_covered = |(first, count, nearness): &(u32, u32, Vec<f32>)| {
            let (from, to) = (from - Vec2::Y * *first as f32, to - Vec2::Y * *first as f32);
            let size = Vec2::new(self.width as f32, *count as f32);
            if to.min_element() < 0.0 || from.cmpge(size).any() {
                return true;
            }
            let (from, to) = (from.max(Vec2::ZERO).as_uvec2() / TILE, to.min(size - 1.0).as_uvec2() / TILE);
            let row = |y: u32| &nearness[(y * across + from.x) as usize..=(y * across + to.x) as usize];
            (from.y..=to.y).all(|y| row(y).iter().all(|of_tile| *of_tile > 1.0 / nearest))
        };
        self.bands.iter().all(is_covered)
    }
}

/// The pass, for a number of samples a pixel.
#[derive(Debug)]
pub struct Hidden {
    /// What is tested, against what; then the blocks of a species, and which of them.
    layouts: [BindGroupLayout; 2],
    reduce: ComputePipeline,
    hide: ComputePipeline,
}

/// Returns the number of tiles of rows of a picture.
pub fn tiles(width: u32, rows: u32) -> u32 {
    width.div_ceil(TILE) * rows.div_ceil(TILE)
}

impl Hidden {
    /// Makes the pipelines; `frame` is the layout of the frame.
    pub fn new(gpu: &Gpu, frame: &BindGroupLayout, samples: u32) -> Self {
        use BindingKind::{Depth, DepthSamples, Read, Uniform, Write};
        let of = |label, kinds: &[BindingKind]| bindings::layout(gpu, label, ShaderStages::COMPUTE, kinds);
        let depths = if samples == 1 { Depth } else { DepthSamples };
        let tables = of("hidden", &[Uniform, Read, Read, Write, Write, Read, depths]);
        let blocks = of("blocks", &[Read, Uniform]);
        let module = bindings::shader(gpu, "hidden", &source(samples));
        let reduce = bindings::compute(gpu, "reduce", &module, &[frame, &tables]);
        let hide = bindings::compute(gpu, "hide", &module, &[frame, &tables, &blocks]);
        Self { layouts: [tables, blocks], reduce, hide }
    }

    /// Binds what is tested: of a band its rows, what is kept, its tiles, and a word for each job; the images and jobs in view; and the
    /// depth buffer.
    pub fn bind(
        &self,
        gpu: &Gpu,
        [rows, kept, tiles, is_hidden]: [&Buffer; 4],
        [images, jobs]: [BindingResource; 2],
        depths: &TextureView,
    ) -> BindGroup {
        let resources = [
            rows.as_entire_binding(),
            images,
            kept.as_entire_binding(),
            tiles.as_entire_binding(),
            is_hidden.as_entire_binding(),
            jobs,
            BindingResource::TextureView(depths),
        ];
        bindings::bind(gpu, "hidden", &self.layouts[0], &resources)
    }

    /// Records the reduction of what is drawn by then to the tiles of a band, whose number is given.
    pub fn reduce(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        [frame, tables]: [&BindGroup; 2],
        tiles: u32,
    ) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_bind_group(0, frame, &[]);
        pass.set_bind_group(1, tables, &[]);
        pass.set_pipeline(&self.reduce);
        bindings::dispatch(gpu, &mut pass, tiles.div_ceil(WORKGROUP));
    }

    /// Records the test of the jobs of each species against what is drawn by then. `tiles` is the number of tiles.
    pub fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        [frame, tables]: [&BindGroup; 2],
        tiles: u32,
        species: &[Option<&SpeciesImages>],
        jobs: &[Range<u32>],
    ) {
        self.reduce(gpu, encoder, [frame, tables], tiles);
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_bind_group(0, frame, &[]);
        pass.set_bind_group(1, tables, &[]);
        pass.set_pipeline(&self.hide);
        for (species, jobs) in species.iter().zip(jobs).filter(|(_, jobs)| jobs.start < jobs.end) {
            let Some(species) = species else { continue };
            let words =
                TestedWords { first: jobs.start, count: jobs.end - jobs.start, ..TestedWords::zeroed() };
            let tested = bindings::filled(gpu, "tested", &[words], BufferUsages::UNIFORM);
            let resources = [species.blocks_on_device.as_entire_binding(), tested.as_entire_binding()];
            pass.set_bind_group(2, &bindings::bind(gpu, "blocks", &self.layouts[1], &resources), &[]);
            bindings::dispatch(gpu, &mut pass, words.count.div_ceil(WORKGROUP));
        }
    }
}
