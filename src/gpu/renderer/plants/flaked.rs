//! Pass *flaked* (`shaders/flaked.wgsl`): lights the samples that *flakes* found, and draws them with their depths.

use bytemuck::{Pod, Zeroable};
use rustc_hash::FxHashMap;
use wgpu::{BindGroup, BindGroupLayout, RenderPass, RenderPipeline, ShaderStages};

use super::daylight::{self, CrownWords};
use super::flake::{self, SpeciesImages};
use super::flakes::{Flakes, SubPixelBand};
use super::pipeline::{SampledProgram, TreeProgram, tree_pipeline};
use crate::bindings::{self, BindingKind};
use crate::device::Gpu;
use crate::renderer::pipeline::SURFACES;
use crate::renderer::table::GrowingBuffer;

const FLAKED: &str = include_str!("../../../../shaders/flaked.wgsl");

/// What is shown of a tree in the layout of the shader (`Shown`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct ShownWords {
    pub tint: [f32; 3],
    pub number: u32,
    pub plain: [f32; 4],
    pub crown: CrownWords,
    pub first_ratio: u32,
    pub ratio_count: u32,
    pub sunlit: u32,
    pub pad0: u32,
}

/// Returns the complete WGSL source for so many samples a pixel.
pub fn source(samples: u32) -> String {
    [SURFACES, daylight::SOURCE, &flake::source(samples), FLAKED].concat()
}

/// The pass.
#[derive(Debug)]
pub struct Flaked {
    /// Images in view, and samples; those of frame and light are the renderer's.
    layouts: [BindGroupLayout; 2],
    pipelines: FxHashMap<SampledProgram, RenderPipeline>,
}

impl Flaked {
    /// Creates the layouts.
    pub fn new(gpu: &Gpu) -> Self {
        use BindingKind::{Read, Uniform};
        let of = |label, kinds: &[BindingKind]| bindings::layout(gpu, label, ShaderStages::FRAGMENT, kinds);
        let layouts =
            [of("found", &[Uniform, Read, Read, Read]), of("samples of a species", &[Read, Uniform])];
        Self { layouts, pipelines: FxHashMap::default() }
    }

    /// Makes the pipeline; `frame` and `daylight` are the layouts of these groups.
    pub fn prepare(&mut self, gpu: &Gpu, program: SampledProgram, [frame, daylight]: [&BindGroupLayout; 2]) {
        let [images, samples] = &self.layouts;
        self.pipelines.entry(program).or_insert_with(|| {
            let layouts = [frame, images, samples, daylight];
            // Depths are all that is needed of a shadow, and these are kept for all species together.
            let layouts = if program.program == TreeProgram::Shadow { &layouts[..2] } else { &layouts };
            tree_pipeline(gpu, program, &source(program.samples), "everywhere", &[], layouts)
        });
    }

    /// Draws what was found; the group of the frame is bound already, those of light and crowns are given for each species. `shown` are
    /// [`ShownWords`] of the trees in view.
    pub fn draw(
        &self,
        gpu: &Gpu,
        drawing: &mut RenderPass,
        program: SampledProgram,
        flakes: &Flakes,
        shown: &GrowingBuffer,
        species: &[(Option<&SpeciesImages>, BindGroup)],
    ) {
        drawing.set_pipeline(&self.pipelines[&program]);
        for band in &flakes.bands {
            drawing.set_bind_group(1, &self.found(gpu, flakes, shown, band), &[]);
            if program.program == TreeProgram::Shadow {
                drawing.draw(0..3, 0..1);
                continue;
            }
            for (images, light) in species {
                let Some(images) = images else { continue };
                drawing.set_bind_group(3, light, &[]);
                let resources = [images.samples.as_entire_binding(), images.number.as_entire_binding()];
                let samples = bindings::bind(gpu, "samples of a species", &self.layouts[1], &resources);
                drawing.set_bind_group(2, &samples, &[]);
                drawing.draw(0..3, 0..1);
            }
        }
    }

    fn found(&self, gpu: &Gpu, flakes: &Flakes, shown: &GrowingBuffer, band: &SubPixelBand) -> BindGroup {
        let (rows, kept) = (band.rows.as_entire_binding(), band.kept.as_entire_binding());
        let resources = [rows, flakes.images.binding(), kept, shown.binding()];
        bindings::bind(gpu, "found", &self.layouts[0], &resources)
    }
}
