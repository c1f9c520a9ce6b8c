//! The renderer's pipelines and their recording: *nearness*, then *project* or *faces*. See-through faces are not in
//! *nearness*; *project* draws them last.

use std::slice;

use rustc_hash::FxHashMap;

use wgpu::{BindGroup, BindGroupLayout, RenderPipeline, ShaderStages, TextureView};

use super::agreement::AgreementTexture;
use super::grids::FaceGrids;
use super::peel::Peeling;
use super::pipeline::{FrameTable, PipelineDescription};
use super::plants::slices::Slices;
use super::plants::view::{BeginPass, TreeTarget};
use super::plants::{Plants, SampledProgram, TreeProgram};
use super::program::{self, Program};
use super::render_target::RenderTarget;
use super::shadows;
use super::sky::SkyFactors;
use super::surfaces::ModelBuffers;
use super::table::GrowingBuffer;
use super::tables::{PhotoWords, Tables};
use super::texels::{self, TexelGroup};
use crate::TileStore;
use crate::bindings::{self, BindingKind};
use crate::device::Gpu;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_projection::Sources;

const WEIGHTS: &str = include_str!("../../../shaders/weights.wgsl");
const PROJECT: &str = include_str!("../../../shaders/project.wgsl");
const SURROUNDINGS: &str = include_str!("../../../shaders/surroundings.wgsl");

/// The inputs and outputs of one drawing.
pub struct Pass<'a> {
    /// The device.
    pub gpu: &'a Gpu,
    /// The model's triangles and planes.
    pub surfaces: &'a ModelBuffers,
    /// The relief, and how faces continue.
    pub grids: &'a FaceGrids,
    /// The factors that bring photos' surroundings to one sky.
    pub sky: &'a SkyFactors,
    /// The photos' agreement.
    pub agreement: &'a AgreementTexture,
    /// The tables of the view.
    pub tables: &'a Tables,
    /// The texels to sample.
    pub tiles: &'a TileStore,
    /// The textures to draw into.
    pub target: &'a RenderTarget,
    /// True when the surroundings are drawn where no face is.
    pub surroundings: bool,
    /// What is there before anything is drawn, linear light and alpha.
    pub background: wgpu::Color,
    /// Whether faces are drawn without the see-through ones.
    pub opaque_alone: bool,
    /// The corners of skirts and of see-through faces, each from back to front, and the number of both.
    pub see_through: (&'a GrowingBuffer, [u32; 2]),
    /// The program that draws them.
    pub program_of_see_through: Program,
    /// The shadows of trees, where some may be in view.
    pub shadows: Option<&'a BindGroup>,
    /// The trees, where some may be in view, and what is shown of them.
    pub plants: Option<(&'a Plants, TreeProgram)>,
}

/// The pipelines made so far.
#[derive(Debug)]
pub struct Passes {
    pub(super) shot: BindGroupLayout,
    pub(super) texels: TexelGroup,
    /// The layout of the shadows of trees.
    pub(super) shadows: BindGroupLayout,
    /// The declaration of the frame.
    pub(super) frame: FrameTable,
    /// The declaration of the photos: a uniform buffer where they fit into one, which is a quarter faster on
    /// software adapters.
    pub(super) photos: PhotoTable,
    nearness: FxHashMap<u32, RenderPipeline>,
    programs: FxHashMap<Program, RenderPipeline>,
    /// The pipelines that draw the surroundings.
    surroundings: FxHashMap<Program, RenderPipeline>,
    /// The pipelines that peel layers off.
    pub(super) peeling: Peeling,
}

/// The shader's declaration of the photos.
#[derive(Debug)]
pub struct PhotoTable {
    kind: BindingKind,
    space: &'static str,
    count: String,
}

impl PhotoTable {
    /// Chooses the declaration for this many photos.
    pub fn new(gpu: &Gpu, sources: &Sources) -> Self {
        let count = sources.projectors().max(1);
        let bytes = (count * size_of::<PhotoWords>()) as u64;
        if bytes <= gpu.device.limits().max_uniform_buffer_binding_size {
            Self { kind: BindingKind::Uniform, space: "uniform", count: format!("{count}u") }
        } else {
            Self { kind: BindingKind::Read, space: "storage, read", count: format!("{count}u") }
        }
    }
}

impl Passes {
    /// Creates the layouts; pipelines are made when they are needed.
    pub fn new(gpu: &Gpu, sources: &Sources) -> Self {
        let photos = PhotoTable::new(gpu, sources);
        let frame = FrameTable::new(gpu);
        let kinds = [
            frame.kind,
            BindingKind::Read,
            BindingKind::Read,
            photos.kind,
            BindingKind::Read,
            BindingKind::Read,
            BindingKind::Filtered,
            BindingKind::Read,
            BindingKind::Filtered,
            BindingKind::Read,
            BindingKind::Depth,
            BindingKind::Filtered,
            BindingKind::Filtered,
        ];
        let stages = ShaderStages::VERTEX_FRAGMENT;
        Self {
            shot: bindings::layout(gpu, "shot", stages, &kinds),
            texels: TexelGroup::new(gpu, ShaderStages::VERTEX_FRAGMENT),
            shadows: shadows::layout(gpu),
            frame,
            photos,
            nearness: FxHashMap::default(),
            programs: FxHashMap::default(),
            surroundings: FxHashMap::default(),
            peeling: Peeling::new(gpu),
        }
    }

    /// Draws into the target and submits the commands. The pipelines were made ([`Self::make`]).
    ///
    /// # Errors
    /// Those of [`Slices::hand_over`].
    pub fn draw(&self, pass: &Pass, program: Program, task: &Task) -> Result<()> {
        let groups = self.groups(pass, program, self.peeling.nothing());
        let most = pass.plants.map_or(f64::INFINITY, |(plants, _)| plants.most_at_once());
        let mut slices = Slices::new(pass.gpu, task, most);
        self.record(&mut slices, pass, program, &groups)?;
        slices.submit();
        Ok(())
    }

    /// Binds what a view is drawn with. `peeled` is the depth of the layer peeled off before.
    pub(super) fn groups(&self, pass: &Pass, program: Program, peeled: &TextureView) -> [BindGroup; 2] {
        let tables = pass.tables;
        let resources = [
            tables.frame.binding(),
            pass.surfaces.planes.as_entire_binding(),
            tables.face_cells.binding(),
            tables.photos.binding(),
            tables.cells.binding(),
            tables.candidates.binding(),
            wgpu::BindingResource::TextureView(&pass.grids.heights),
            pass.grids.places.as_entire_binding(),
            wgpu::BindingResource::TextureView(&pass.agreement.texture),
            pass.agreement.places.as_entire_binding(),
            wgpu::BindingResource::TextureView(peeled),
            wgpu::BindingResource::TextureView(&pass.grids.colours),
            wgpu::BindingResource::TextureView(&pass.sky.texture),
        ];
        let shot = bindings::bind(pass.gpu, "shot", &self.shot, &resources);
        let reads_stored = program.reads_stored() || pass.program_of_see_through.reads_stored();
        [shot, self.texels.bind(pass.gpu, pass.tiles, reads_stored)]
    }

    fn record(
        &self,
        slices: &mut Slices,
        pass: &Pass,
        program: Program,
        [shot, texels]: &[BindGroup; 2],
    ) -> Result<()> {
        let draw = |encoder: &mut wgpu::CommandEncoder,
                    pipeline: &RenderPipeline,
                    color: Option<wgpu::RenderPassColorAttachment>,
                    clears| {
            let load = if clears { wgpu::LoadOp::Clear(0.0) } else { wgpu::LoadOp::Load };
            let color = color.map(Some);
            let mut drawing = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("shot"),
                color_attachments: color.as_slice(),
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &pass.target.depth,
                    depth_ops: Some(wgpu::Operations { load, store: wgpu::StoreOp::Store }),
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            drawing.set_pipeline(pipeline);
            drawing.set_bind_group(0, shot, &[]);
            if !clears {
                drawing.set_bind_group(1, texels, &[]);
                if let Some(shadows) = pass.shadows.filter(|_| program.has_shadows()) {
                    drawing.set_bind_group(2, shadows, &[]);
                }
            }
            drawing.set_vertex_buffer(0, pass.surfaces.corners.slice(..));
            let (corners, [skirts, count]) = pass.see_through;
            let all = 0..pass.surfaces.count;
            let is_all = program == Program::Faces && count == 0 && !pass.opaque_alone;
            let ranges = if is_all { slice::from_ref(&all) } else { &pass.surfaces.opaque };
            ranges.iter().for_each(|range| drawing.draw(range.clone(), 0..1));
            if let Some(behind) = self.surroundings.get(&program).filter(|_| !clears && pass.surroundings) {
                drawing.set_pipeline(behind);
                drawing.draw(0..3, 0..1);
            }
            // Skirts show colours alone.
            let first = if pass.program_of_see_through.is_of_see_through() { 0 } else { skirts };
            if !clears && skirts + count > first {
                drawing.set_pipeline(&self.programs[&pass.program_of_see_through]);
                drawing.set_vertex_buffer(0, corners.slice());
                drawing.draw(first..skirts + count, 0..1);
            }
        };
        draw(slices.encoder(), &self.nearness[&pass.target.samples], None, true);
        let has_trees = pass.plants.is_some();
        if has_trees {
            record_trees(slices, pass, program)?;
        }
        let colours = attachment(pass, program, has_trees);
        draw(slices.encoder(), &self.programs[&program], Some(colours), false);
        Ok(())
    }

    /// Makes the pipelines of a program, for a number of samples, with the program of see-through surfaces and that of the
    /// surroundings where these are drawn, too.
    pub fn make(
        &mut self,
        gpu: &Gpu,
        program: Program,
        samples: u32,
        see_through: Option<Program>,
        has_surroundings: bool,
    ) {
        let Self { shot, texels, shadows, frame, photos, nearness, programs, surroundings, .. } = self;
        nearness.entry(samples).or_insert_with(|| {
            PipelineDescription {
                vertex: "nearness",
                fragment: None,
                groups: &[shot],
                samples,
                corners: true,
                blends: false,
            }
            .pipeline(gpu, &frame.source)
        });
        for program in [Some(program), see_through].into_iter().flatten() {
            programs.entry(program).or_insert_with(|| {
                let (vertex, fragment) = match program {
                    Program::Faces => ("owner", "faces"),
                    Program::Picture { numbers: true, .. } => ("drawn", "seen"),
                    Program::Picture { .. } => ("drawn", "project"),
                };
                let fragment = (fragment, Some(program.format()));
                let groups: &[&BindGroupLayout] = &[shot, &texels.layout, shadows];
                let groups = if program.has_shadows() { groups } else { &groups[..2] };
                let (fragment, corners, blends) = (Some(fragment), true, program.blends());
                let description = PipelineDescription { vertex, fragment, groups, samples, corners, blends };
                description.pipeline(gpu, &source(program, frame, photos))
            });
        }
        if has_surroundings && matches!(program, Program::Picture { .. }) {
            surroundings.entry(program).or_insert_with(|| {
                let (vertex, fragment) = ("behind", Some(("surroundings", Some(program.format()))));
                let groups: &[&BindGroupLayout] = &[shot, &texels.layout];
                PipelineDescription { vertex, fragment, groups, samples, corners: false, blends: false }
                    .pipeline(gpu, &source(program, frame, photos))
            });
        }
    }
}

/// Assembles the complete WGSL source of a program.
pub fn source(program: Program, frame: &FrameTable, photos: &PhotoTable) -> String {
    match program {
        Program::Faces => frame.source.clone(),
        Program::Picture { .. } => {
            let generated = program::generated(program);
            let project = PROJECT.replace("PHOTO_SPACE", photos.space).replace("PHOTO_COUNT", &photos.count);
            let shadows = if program.has_shadows() { shadows::SOURCE } else { shadows::NONE };
            let before = [&frame.source, texels::SOURCE, WEIGHTS, &program::preamble(), &generated].concat();
            [&before, shadows, &project, SURROUNDINGS].concat()
        }
    }
}

/// Draws the trees of a view over nothing: they hide faces that are drawn later, and faces of *nearness* hide them.
fn record_trees(slices: &mut Slices, pass: &Pass, program: Program) -> Result<()> {
    let Some((plants, of_trees)) = pass.plants else { return Ok(()) };
    let begin: &BeginPass = &|encoder, is_first| {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("trees"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                // What is drawn later resolves the samples.
                resolve_target: None,
                ..attachment(pass, program, !is_first)
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &pass.target.depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        })
    };
    let onto = TreeTarget { begin, depths: &pass.target.depth };
    let program = SampledProgram { program: of_trees, samples: pass.target.samples };
    plants.draw(slices, &onto, pass.tables.frame.binding(), program)
}

/// Returns what a program draws on: what is there already, or the background.
fn attachment<'a>(pass: &Pass<'a>, program: Program, loads: bool) -> wgpu::RenderPassColorAttachment<'a> {
    let Pass { target, background, .. } = *pass;
    let (view, resolve_target, clear) = match (program, &target.samples_view) {
        (Program::Faces, _) => {
            let view = target.faces_view.as_ref().expect("faces are drawn without samples");
            (view, None, wgpu::Color::TRANSPARENT)
        }
        (_, Some(samples)) => (samples, Some(&target.color_view), background),
        (_, None) => (&target.color_view, None, background),
    };
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target,
        ops: wgpu::Operations {
            load: if loads { wgpu::LoadOp::Load } else { wgpu::LoadOp::Clear(clear) },
            store: wgpu::StoreOp::Store,
        },
    }
}
