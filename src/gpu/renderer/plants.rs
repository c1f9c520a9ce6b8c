//! The trees of a site, drawn between *nearness* and *project*: they hide faces and faces hide them, sample by sample. What is
//! large in a view is drawn as polygons (`shaders/plants.wgsl`), the rest from images ([`flakes`], [`flaked`]).

pub(super) mod daylight;
mod door;
mod extent;
pub(super) mod flake;
pub(super) mod flaked;
pub(super) mod flakes;
mod flakes_narrow;
mod flakes_wide;
pub(super) mod hidden;
mod painted;
pub(super) mod polygons;
pub(super) mod ratio;
pub(super) mod slices;
pub(super) mod species;
pub(super) mod stock;
pub(super) mod sunlit;
#[cfg(test)]
mod tests;
pub(super) mod view;

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use wgpu::{BindGroupLayout, RenderPipeline, ShaderStages, TextureFormat};

use self::slices::Slices;
use self::species::{CornerWords, InstanceWords};
use self::stock::Stock;
use self::view::{Onto, PlantsView};
use super::Renderer;
use super::project::SURFACES;
use super::target::{COLOR, FACES, LINEAR};
use crate::bindings;
use crate::device::Gpu;
use crate::drawing::DEPTH;
use quadratura_base::error::Result;
use quadratura_foliage::Wood;
use quadratura_view::{DisplayMode, Shot, TreeMethod};

pub(super) const PLANTS: &str = include_str!("../../../shaders/plants.wgsl");

/// How instances are placed, in the layout of the shader (`Placement`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct PlacementWords {
    pub right: [f32; 4],
    pub down: [f32; 4],
    pub forward: [f32; 4],
    pub first: u32,
    pub pad0: u32,
    pub pad1: u32,
    pub pad2: u32,
}

/// What a drawing shows of trees.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TreeProgram {
    /// Their colours in the site's light, in linear light or not.
    Lit { linear: bool },
    /// One colour for each tree, in linear light or not.
    Plain { linear: bool },
    /// [`quadratura_projection::TREE`] and their numbers.
    Numbered,
    /// Their depths alone, as the sun sees them.
    Shadow,
}

impl TreeProgram {
    /// Returns what a picture of a view shows.
    pub fn of_picture(shot: &Shot) -> Self {
        let linear = shot.linear;
        if shot.display == DisplayMode::Colour { Self::Lit { linear } } else { Self::Plain { linear } }
    }

    /// Returns the entry point of its shaders, and the format that it draws in; `None` for depths alone.
    fn entry(self) -> (&'static str, Option<TextureFormat>) {
        let colors = |linear| Some(if linear { LINEAR } else { COLOR });
        match self {
            Self::Lit { linear } => ("lit", colors(linear)),
            Self::Plain { linear } => ("plain", colors(linear)),
            Self::Numbered => ("numbered", Some(FACES)),
            Self::Shadow => ("shadow", None),
        }
    }
}

/// What the drawing of polygons leaves out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Cuts {
    /// What a picture cuts out.
    pub by_picture: bool,
    /// Sub-pixels in which a door is closed.
    pub by_door: bool,
}

/// A pipeline's program, what it leaves out, and its samples per pixel.
type Key = (TreeProgram, Cuts, u32);

/// The trees of a site on the device, and what a view shows of them.
#[derive(Debug)]
pub struct Plants {
    stock: Stock,
    view: PlantsView,
}

impl Plants {
    /// Uploads the trees of a site whose model has this many faces.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Request`] for a plant without images that has too many instances.
    pub fn new(gpu: &Gpu, wood: Arc<Wood>, faces: usize) -> Result<Self> {
        Ok(Self { stock: Stock::new(gpu, wood, faces)?, view: PlantsView::new(gpu) })
    }

    /// Prepares the trees for a view ([`PlantsView::prepare`]). Returns whether some tree may be in view.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Request`] for a plant that has too many instances to be drawn as polygons.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        shot: &Shot,
        of: (TreeProgram, u32),
        of_common: [f64; 3],
    ) -> Result<bool> {
        let Self { stock, view } = self;
        view.prepare(gpu, (stock, &|_| true), shot, of, of_common)
    }

    /// Forgets the picture that was drawn last, because trees or faces have changed.
    pub fn forget(&mut self) {
        self.view.forget();
    }

    /// Returns whether some tree casts a shadow.
    pub fn casts(&self) -> bool {
        self.stock.wood.trees.iter().any(|tree| tree.casts)
    }

    /// Returns the trees and species, whatever the view.
    pub fn stock(&mut self) -> &mut Stock {
        &mut self.stock
    }

    /// Returns what of the trees is handed to the device at once, as a cost in samples.
    pub fn most_at_once(&self) -> f64 {
        self.view.most_at_once()
    }

    /// Draws the trees in view, for which [`Self::prepare`] was called, onto what is there.
    ///
    /// # Errors
    /// Those of [`Slices::hand_over`].
    pub fn draw(
        &self,
        slices: &mut Slices,
        onto: &Onto,
        frame: wgpu::BindingResource,
        of: (TreeProgram, u32),
    ) -> Result<()> {
        self.view.draw(&self.stock, slices, onto, frame, of)
    }
}

impl Renderer {
    /// Sets the trees that stand in the site.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Request`] for a plant without images that has too many instances to be drawn as polygons; [`quadratura_base::Error::Gpu`]. The trees
    /// before remain.
    pub fn set_trees(&mut self, wood: Option<Arc<Wood>>) -> Result<()> {
        self.ready = None;
        self.forget_shadows();
        if !wood.as_ref().is_some_and(|wood| wood.trees.iter().any(|tree| tree.casts)) {
            // Their maps take 125 MB.
            self.shadows = None;
        }
        if let (Some(plants), Some(wood)) = (&mut self.plants, &wood)
            && plants.stock.has_species_of(wood)
        {
            let (gpu, stock) = (self.gpu.clone(), &mut plants.stock);
            gpu.guarded("uploading trees", || {
                stock.set_trees(&gpu, wood.clone());
                Ok(())
            })?;
            plants.forget();
            return Ok(());
        }
        let (gpu, faces) = (self.gpu.clone(), self.model.faces.len());
        let plants =
            gpu.guarded("uploading trees", || wood.map(|wood| Plants::new(&gpu, wood, faces)).transpose())?;
        self.plants = plants;
        Ok(())
    }

    /// Returns the trees that a view shows, if there are any.
    pub(super) fn trees(&self, shot: &Shot) -> Option<&Plants> {
        self.plants.as_ref().filter(|_| shot.trees != TreeMethod::None)
    }

    /// Returns the depths of the nearest and the farthest visible point with those of the trees.
    pub(super) fn depths_with_trees(&self, shot: &Shot, depths: [f64; 2]) -> [f64; 2] {
        match self.trees(shot).and_then(|plants| plants.stock.depths(shot)) {
            Some([nearest, farthest]) if depths[1] > 0.0 => [depths[0].min(nearest), depths[1].max(farthest)],
            Some(of_trees) => of_trees,
            None => depths,
        }
    }
}

/// Returns the layout of trees: how instances are placed, at dynamic offsets, and what is shown of the trees in view.
fn trees_layout(gpu: &Gpu) -> BindGroupLayout {
    let entry = |binding, visibility, ty, has_dynamic_offset| wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None },
        count: None,
    };
    let entries = &[
        entry(0, ShaderStages::VERTEX, wgpu::BufferBindingType::Uniform, true),
        entry(1, ShaderStages::FRAGMENT, wgpu::BufferBindingType::Storage { read_only: true }, false),
    ];
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("trees"), entries })
}

/// Returns the complete WGSL source of a program.
pub(super) fn source(cuts: Cuts) -> String {
    let Cuts { by_picture, by_door } = cuts;
    let constants = format!("const CUT = {by_picture};\nconst DOOR = {by_door};\n");
    [&constants, SURFACES, daylight::SOURCE, door::SOURCE, PLANTS].concat()
}

fn pipeline(gpu: &Gpu, (program, cuts, samples): Key, layouts: &[BindGroupLayout; 4]) -> RenderPipeline {
    let corner = wgpu::VertexBufferLayout {
        array_stride: size_of::<CornerWords>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 6 => Float32x3],
    };
    let instance = wgpu::VertexBufferLayout {
        array_stride: size_of::<InstanceWords>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![3 => Float32x4, 4 => Float32x4, 5 => Float32x4, 7 => Uint32, 8 => Uint32],
    };
    let (source, buffers) = (source(cuts), [Some(corner), Some(instance)]);
    tree_pipeline(gpu, (program, samples), (&source, "grown", &buffers), &layouts.each_ref())
}

/// Makes a pipeline that draws trees with their depths: from a source, its vertex function and the buffers of that.
fn tree_pipeline(
    gpu: &Gpu,
    (program, samples): (TreeProgram, u32),
    (source, vertex, buffers): (&str, &str, &[Option<wgpu::VertexBufferLayout<'_>>]),
    layouts: &[&BindGroupLayout],
) -> RenderPipeline {
    let (entry, format) = program.entry();
    let module = bindings::shader(gpu, entry, source);
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(entry),
        layout: Some(&bindings::pipeline_layout(gpu, entry, layouts)),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some(vertex),
            compilation_options: Default::default(),
            buffers,
        },
        // Leaves are seen from either side, and bark is closed.
        primitive: wgpu::PrimitiveState { cull_mode: None, ..Default::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            // Of what is equally near, the first stays, as on the CPU.
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(entry),
            compilation_options: Default::default(),
            targets: format.map(|format| Some(format.into())).as_slice(),
        }),
        multiview_mask: None,
        cache: None,
    })
}
