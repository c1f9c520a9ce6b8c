//! Pass *shadows* (`shaders/shadows.wgsl`): the depths of trees and faces as the sun sees them, and what binds them where faces
//! are shaded.

mod maps;
#[cfg(test)]
mod tests;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use wgpu::{
    BindGroup, BindGroupLayout, BufferUsages, LoadOp, Operations, RenderPipeline, ShaderStages, StoreOp,
    TextureView,
};

use self::maps::{Maps, ShadowLayer};
use super::Renderer;
use super::frame::CameraUniform;
use super::pipeline::{PipelineDescription, SURFACES};
use super::plants::resources::TreeResources;
use super::plants::slices::Slices;
use super::plants::view::{BeginPass, PlantsView, TreeTarget};
use super::plants::{Plants, SampledProgram, TreeProgram};
use super::surfaces::ModelBuffers;
use super::table::GrowingBuffer;
use super::tables::FaceCellsWords;
use crate::bindings::{self, BindingKind};
use crate::device::Gpu;
use quadratura_base::error::Result;
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::Model;
use quadratura_base::task::Task;
use quadratura_foliage::{
    Ball, MOST_SUN_VIEWS, OutdoorLight, SunScene, SunView, Tree, TreePace, WalkOptions, sun_views,
};
use quadratura_projection::Sources;
use quadratura_projection::cells::Cells;
use quadratura_view::optics::ViewLens;
use quadratura_view::{DisplayMode, Quality, Shot, TreeMethod};

/// The WGSL source that is put before *project* where trees cast shadows.
pub const SOURCE: &str = include_str!("../../../shaders/shadows.wgsl");

/// What stands in its place where no tree casts a shadow.
pub const NONE: &str =
    "fn darkened(light: vec3f, drawn: Drawn, p: vec3f, depth: f32) -> vec3f { return light; }\n";

/// The sides of views from the sun in pixels: of previews and of final pictures.
const SIDE_PX: [u32; 2] = [1024, 2048];
/// The radius of the widest penumbra in pixels of a view from the sun: wider ones would show the places of single lookups.
const WIDEST_PX: f64 = 10.0;
/// The size of the pixels up to which an image of a tree serves, as a share of the radius of the widest penumbra: shadows are averaged
/// over penumbras, so that finer images show little more, and there are many more samples in them (docs/performance.md).
const OF_PENUMBRA: f64 = 0.5;
/// The largest such size.
const COARSEST_PX: f64 = 2.0;
/// The room around what a view from the sun has to show while the view moves, as a share of its size on each side, so that it serves for
/// more pictures.
const ROOM: f64 = 0.2;

/// Returns the layout of what is bound where faces are shaded.
pub fn layout(gpu: &Gpu) -> BindGroupLayout {
    use BindingKind::{Comparison, DepthArray, Uniform};
    let kinds = [Uniform, DepthArray, DepthArray, Comparison];
    bindings::layout(gpu, "shadows", ShaderStages::FRAGMENT, &kinds)
}

/// A view from the sun in the layout of the shader (`SunView`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct SunViewWords {
    pub row_u: [f32; 4],
    pub row_v: [f32; 4],
    pub row_z: [f32; 4],
    pub near: f32,
    pub until: f32,
    pub texel: f32,
    pub widest: f32,
}

/// The uniform in the layout of the shader (`Shadows`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct ShadowsWords {
    pub views: [SunViewWords; MOST_SUN_VIEWS],
    pub towards_sun: [f32; 3],
    pub count: u32,
    pub up: [f32; 3],
    pub pad0: f32,
    pub sun: [f32; 3],
    pub pad1: f32,
    pub sky: [f32; 3],
    pub pad2: f32,
    pub ground: [f32; 3],
    pub pad3: f32,
}

/// What shadows fall on.
#[derive(Debug, Clone, Copy)]
struct Catching<'a> {
    model: &'a Model,
    surfaces: &'a ModelBuffers,
    sources: &'a Sources,
}

/// What the maps of a view are drawn for, and with.
#[derive(Clone, Copy)]
struct Casting<'a> {
    gpu: &'a Gpu,
    task: &'a Task,
    catching: Catching<'a>,
    /// The view.
    shot: &'a Shot,
    /// Whether it moves.
    moves: bool,
}

/// The shadows of trees on faces.
#[derive(Debug)]
pub struct Shadows {
    layout: BindGroupLayout,
    sampler: wgpu::Sampler,
    words: GrowingBuffer,
    /// Draws the depths of faces.
    faces: (BindGroupLayout, Option<RenderPipeline>),
    /// The frame of a view from the sun.
    frame: GrowingBuffer,
    /// [`FaceCellsWords`] of faces that are all drawn.
    all_faces: GrowingBuffer,
    trees: PlantsView,
    /// How fine the trees of each view from the sun are while the view moves.
    paces: [TreePace; MOST_SUN_VIEWS],
    /// Of previews and of final pictures: 25 and 100 MB.
    maps: [Option<Maps>; 2],
    /// What is bound is for this; `None` where trees or faces have changed.
    of: Option<Of>,
    /// `None` where no shadow falls.
    group: Option<BindGroup>,
}

/// What decides about what is bound, besides trees and model.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Of {
    camera: Pinhole,
    pose: Pose,
    trees: TreeMethod,
    quality: Quality,
    /// Whether the view moves.
    moves: bool,
}

impl Shadows {
    /// Creates what is the same for all views.
    pub fn new(gpu: &Gpu, layout: BindGroupLayout) -> Self {
        use BindingKind::{Read, Uniform};
        let of_faces = bindings::layout(gpu, "faces", ShaderStages::VERTEX, &[Uniform, Read, Read]);
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("shadows"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            compare: Some(wgpu::CompareFunction::Less),
            ..Default::default()
        });
        let mut trees = PlantsView::new(gpu);
        // The sun is so far away that all depths are about the same, and hardly anything is drawn as polygons.
        trees.polygons.least_of_batch = None;
        Self {
            layout,
            sampler,
            words: GrowingBuffer::new(gpu, "shadows", BufferUsages::UNIFORM),
            faces: (of_faces, None),
            frame: GrowingBuffer::new(gpu, "frame", BufferUsages::UNIFORM),
            all_faces: GrowingBuffer::new(gpu, "all faces", BufferUsages::STORAGE),
            trees,
            paces: [TreePace::of_maps(); MOST_SUN_VIEWS],
            maps: [None, None],
            of: None,
            group: None,
        }
    }

    /// Returns how the images of trees are drawn as the sun sees them.
    #[cfg(test)]
    pub fn flakes(&mut self) -> &mut super::plants::flakes::Flakes {
        &mut self.trees.flakes
    }

    /// Forgets what was drawn, because trees or faces have changed.
    pub fn forget(&mut self) {
        self.of = None;
        self.maps.iter_mut().flatten().for_each(|maps| maps.layers = Default::default());
    }

    /// Returns what is bound where faces are shaded; `None` where no shadow falls on what the view sees.
    pub fn group(&self) -> Option<&BindGroup> {
        self.group.as_ref()
    }

    /// Draws the depths that the sun sees for a view, as far as maps do not hold them yet.
    fn cast(
        &mut self,
        gpu: &Gpu,
        resources: &mut TreeResources,
        catching: Catching<'_>,
        shot: &Shot,
        task: &Task,
    ) -> Result<()> {
        let Shot { camera, pose, trees, quality, .. } = *shot;
        let is_final = quality.is_anisotropic();
        let moves = shot.trees_within.is_some() && !is_final;
        let of = Some(Of { camera, pose, trees, quality, moves });
        if self.of == of {
            return Ok(());
        }
        (self.of, self.group) = (None, None);
        let placed = resources.placed.clone();
        let casters: Vec<Ball> =
            placed.trees.iter().filter(|tree| tree.casts).map(|tree| placed.ball(tree)).collect();
        let scene = SunScene {
            casters: &casters,
            corners: &catching.model.vertices,
            towards_sun: placed.light.towards_sun,
            up: placed.light.up,
        };
        let side = SIDE_PX[usize::from(is_final)].min(gpu.device.limits().max_texture_dimension_2d);
        let views = sun_views(&camera, &pose, &scene, side, if moves { ROOM } else { 0.0 });
        if !views.is_empty() {
            let maps = self.maps[usize::from(is_final)].take().filter(|maps| maps.side == side);
            let mut maps = maps.unwrap_or_else(|| Maps::new(gpu, side));
            let words = self.fill(&mut maps, resources, &views, Casting { gpu, task, catching, shot, moves });
            let [of_trees, of_faces] = maps.views(None);
            self.maps[usize::from(is_final)] = Some(maps);
            self.words.write(gpu, &[words?]);
            let resources = [
                self.words.binding(),
                wgpu::BindingResource::TextureView(&of_trees),
                wgpu::BindingResource::TextureView(&of_faces),
                wgpu::BindingResource::Sampler(&self.sampler),
            ];
            self.group = Some(bindings::bind(gpu, "shadows", &self.layout, &resources));
        }
        self.of = of;
        Ok(())
    }

    /// Draws those of the views from the sun that maps do not hold yet, and describes all.
    fn fill(
        &mut self,
        maps: &mut Maps,
        resources: &mut TreeResources,
        views: &[SunView],
        casting: Casting<'_>,
    ) -> Result<ShadowsWords> {
        let Casting { shot, moves, .. } = casting;
        let mut words = ShadowsWords::new(&resources.placed.light, views.len());
        for (index, view) in views.iter().enumerate() {
            self.trees.pace.set(self.paces[index]);
            let threshold = self.threshold(view, moves);
            let wanted = ShadowLayer { view: *view, near: 0.0, trees: shot.trees, threshold };
            let held = maps.layers[index].take().filter(|held| held.serves(&wanted, moves));
            let layer = match held {
                Some(held) => held,
                None => {
                    let onto = maps.views(Some(index as u32));
                    let drawn = self.draw(resources, view, casting, &onto);
                    self.paces[index] = self.trees.pace.get();
                    drawn?
                }
            };
            maps.layers[index] = Some(layer);
            let view = SunView { until: view.until, ..layer.view };
            words.views[index] = SunViewWords::new(&view, layer.near, shot.viewpoint());
        }
        Ok(words)
    }

    /// Returns the size of pixels up to which images of trees serve in a view from the sun, if it is drawn now.
    fn threshold(&self, view: &SunView, moves: bool) -> f64 {
        let finest = finest(view).threshold;
        if moves { self.trees.pace.get().threshold().max(finest) } else { finest }
    }

    /// Draws what one view from the sun sees of trees and of faces.
    fn draw(
        &mut self,
        resources: &mut TreeResources,
        view: &SunView,
        casting: Casting<'_>,
        [of_trees, of_faces]: &[TextureView; 2],
    ) -> Result<ShadowLayer> {
        let Casting { gpu, task, catching, shot: shown, .. } = casting;
        let Catching { model, surfaces, sources } = catching;
        let within = shown.trees_within.filter(|_| shown.quality == Quality::Preview);
        let shot = Shot {
            trees: shown.trees,
            trees_within: within.map(|within| within / MOST_SUN_VIEWS as u32),
            quality: Quality::Preview,
            ..Shot::new(view.camera, view.pose)
        };
        let cells = Cells { side_px: 1, depths: view.depths, ..Cells::default() };
        let frame = CameraUniform::new(&shot, &ViewLens::default(), surfaces.origin(), &cells, sources);
        self.frame.write(gpu, &[frame]);
        self.all_faces.write(gpu, &vec![FaceCellsWords::zeroed(); model.faces.len().max(1)]);
        let casts = |tree: &Tree| tree.casts;
        let program = SampledProgram { program: TreeProgram::Shadow, samples: 1 };
        self.trees.finest = finest(view);
        let has_trees = self.trees.prepare(gpu, resources, &casts, &shot, program, [1.0; 3])?;
        let mut slices = Slices::new(gpu, task, self.trees.most_at_once());
        self.draw_faces(gpu, slices.encoder(), surfaces, of_faces);
        let begin: &BeginPass = &|encoder, is_first| depths(encoder, of_trees, is_first);
        if has_trees {
            let onto = TreeTarget { begin, depths: of_trees };
            self.trees.draw(resources, &mut slices, &onto, self.frame.binding(), program)?;
        } else {
            drop(begin(slices.encoder(), true));
        }
        slices.submit();
        // Without trees the map is as fine as any.
        let threshold = if has_trees { self.trees.options.threshold } else { finest(view).threshold };
        Ok(ShadowLayer { view: *view, near: frame.near, trees: shown.trees, threshold })
    }

    /// Draws the faces that keep the sun from others.
    fn draw_faces(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        surfaces: &ModelBuffers,
        onto: &TextureView,
    ) {
        let (layout, pipeline) = &mut self.faces;
        let pipeline = pipeline.get_or_insert_with(|| {
            PipelineDescription {
                vertex: "nearness",
                fragment: None,
                groups: &[layout],
                samples: 1,
                corners: true,
                blends: false,
            }
            .pipeline(gpu, SURFACES)
        });
        let resources = [self.frame.binding(), surfaces.planes.as_entire_binding(), self.all_faces.binding()];
        let group = bindings::bind(gpu, "faces", layout, &resources);
        let mut drawing = depths(encoder, onto, true);
        drawing.set_pipeline(pipeline);
        drawing.set_bind_group(0, &group, &[]);
        drawing.set_vertex_buffer(0, surfaces.corners.slice(..));
        surfaces.casting.iter().for_each(|range| drawing.draw(range.clone(), 0..1));
    }
}

/// Returns how fine images of trees are in a view from the sun: as fine as penumbras show.
fn finest(view: &SunView) -> WalkOptions {
    let threshold = OF_PENUMBRA * view.penumbra / view.pixel;
    WalkOptions { threshold: threshold.clamp(WalkOptions::PREVIEW.threshold, COARSEST_PX) }
}

/// Begins to draw depths, where there is nothing or on what is there.
fn depths<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    view: &TextureView,
    is_first: bool,
) -> wgpu::RenderPass<'a> {
    let load = if is_first { LoadOp::Clear(0.0) } else { LoadOp::Load };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("seen by the sun"),
        color_attachments: &[],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(Operations { load, store: StoreOp::Store }),
            stencil_ops: None,
        }),
        ..Default::default()
    })
}

impl ShadowsWords {
    fn new(light: &OutdoorLight, count: usize) -> Self {
        let direction = |direction: DVec3| direction.as_vec3().to_array();
        let OutdoorLight { towards_sun, up, sun, sky, ground } = light;
        Self {
            towards_sun: direction(*towards_sun),
            count: count as u32,
            up: direction(*up),
            sun: Vec3::to_array(sun),
            sky: sky.to_array(),
            ground: ground.to_array(),
            ..Self::zeroed()
        }
    }
}

impl SunViewWords {
    /// Describes a view from the sun, whose near plane is so far away, to a picture from a viewpoint.
    fn new(view: &SunView, near: f32, viewpoint: DVec3) -> Self {
        let SunView { camera, pose, until, pixel, penumbra, .. } = *view;
        let eye = pose.camera_from_world(viewpoint);
        let row = |axis: usize, factor: f64| {
            let row = factor * pose.rotation.row(axis).extend(eye[axis]);
            row.as_vec4().to_array()
        };
        let across = camera.fx / f64::from(camera.width);
        Self {
            row_u: row(0, across),
            row_v: row(1, across),
            row_z: row(2, 1.0),
            near,
            until: until as f32,
            texel: pixel as f32,
            widest: (penumbra / pixel).min(WIDEST_PX) as f32,
        }
    }
}

impl Renderer {
    /// Forgets what was drawn of trees, because faces have changed.
    pub(super) fn forget_drawn_trees(&mut self) {
        self.plants.iter_mut().for_each(Plants::forget);
    }

    /// Forgets shadows, because trees or faces have changed.
    pub(super) fn forget_shadows(&mut self) {
        if let Some(shadows) = &mut self.shadows {
            shadows.forget();
        }
    }

    /// Prepares the shadows that trees cast on what a view shows, where that is colours; returns whether there may be any. A view
    /// that is drawn in bands is given as a whole.
    pub(super) fn cast_shadows(&mut self, shot: &Shot, task: &Task) -> Result<bool> {
        let shows_trees = shot.trees != TreeMethod::None && shot.display == DisplayMode::Colour;
        let Some(plants) = self.plants.as_mut().filter(|plants| shows_trees && plants.casts()) else {
            return Ok(false);
        };
        let Self { gpu, model, surfaces, sources, shadows, passes, .. } = self;
        let shadows = shadows.get_or_insert_with(|| Shadows::new(gpu, passes.shadows.clone()));
        let catching = Catching { model, surfaces, sources };
        task.timed("shadows", || shadows.cast(gpu, plants.resources(), catching, shot, task))?;
        Ok(shadows.group().is_some())
    }
}
