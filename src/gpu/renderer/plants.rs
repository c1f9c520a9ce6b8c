//! The trees of a site, drawn between *nearness* and *project*: they hide faces and faces hide them, sample by sample. What is
//! large in a view is drawn as polygons (`shaders/plants.wgsl`), the rest from images ([`flakes`], [`flaked`]).

pub(super) mod daylight;
pub(super) mod flake;
pub(super) mod flaked;
pub(super) mod flakes;
mod flakes_narrow;
mod flakes_wide;
mod painted;
pub(super) mod species;
#[cfg(test)]
mod tests;

use std::num::NonZeroU64;
use std::ops::Range;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use wgpu::{BindGroupLayout, BufferUsages, RenderPass, RenderPipeline, ShaderStages, TextureFormat};

use self::daylight::{CrownWords, DaylightWords};
use self::flake::{FlakeImageWords, SpeciesImages, rows_of};
use self::flaked::{Flaked, ShownWords};
use self::flakes::Flakes;
use self::species::{CornerWords, InstanceWords, SpeciesBuffers, instance_words, material_layout};
use super::Renderer;
use super::project::SURFACES;
use super::table::GrowingBuffer;
use super::target::{COLOR, FACES, FLAT_LINEAR};
use crate::error::Result;
use crate::foliage::{FlakeOptions, ImageInView, InView, View, Wood, WoodSpecies, in_view};
use crate::gpu::bindings::{self, BindingKind};
use crate::gpu::device::Gpu;
use crate::gpu::drawing::DEPTH;
use crate::projection::legend::{self, colour_of_number, linear};
use crate::projection::{DisplayMode, Quality, Shot, TREE, TreeMethod};

pub(super) const PLANTS: &str = include_str!("../../../shaders/plants.wgsl");

/// A tree in the layout of the shader (`Tree`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct TreeWords {
    pub right: [f32; 4],
    pub down: [f32; 4],
    pub forward: [f32; 4],
    pub tint: [f32; 3],
    pub number: u32,
    pub plain: [f32; 4],
    pub crown: CrownWords,
}

/// What a drawing shows of trees.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TreeProgram {
    /// Their colours in the site's light.
    Lit,
    /// One colour for each tree.
    Plain,
    /// [`TREE`] and their numbers.
    Numbered,
}

impl TreeProgram {
    /// Returns what a picture of a view shows.
    pub fn of_picture(shot: &Shot) -> Self {
        if shot.display == DisplayMode::Colour { Self::Lit } else { Self::Plain }
    }

    fn entry(self) -> (&'static str, TextureFormat) {
        match self {
            Self::Lit => ("lit", COLOR),
            Self::Plain => ("plain", COLOR),
            Self::Numbered => ("numbered", FACES),
        }
    }
}

/// A pipeline's program, whether it cuts out pictures, and its samples per pixel.
type Key = (TreeProgram, bool, u32);

/// The trees of a site on the device.
#[derive(Debug)]
pub struct Plants {
    wood: Arc<Wood>,
    species: Vec<SpeciesBuffers>,
    /// Frame, tree, material and light.
    layouts: [BindGroupLayout; 4],
    pipelines: FxHashMap<Key, RenderPipeline>,
    daylight: GrowingBuffer,
    /// The trees in view, each at a multiple of [`Self::stride`].
    trees: GrowingBuffer,
    stride: u64,
    /// What is drawn as polygons, in the order of the trees.
    polygons: Vec<PolygonDraw>,
    /// [`InstanceWords`] of sub-objects of trees whose other parts are drawn from images: to the camera's frame.
    parts: GrowingBuffer,
    flakes: Flakes,
    flaked: Flaked,
    /// Whether images are in view.
    has_images: bool,
    faces: usize,
}

/// Instances of a sub-object's triangles that are drawn as polygons.
#[derive(Debug, Clone, PartialEq)]
struct PolygonDraw {
    /// The place of the tree among those in view.
    slot: u32,
    species: usize,
    /// The sub-object; `None` for all of them.
    object: Option<usize>,
    /// In [`Plants::parts`]; those of all sub-objects are in [`SpeciesBuffers::instances`].
    instances: Range<u32>,
}

impl Plants {
    /// Uploads the trees of a site whose model has this many faces.
    ///
    /// # Errors
    /// [`crate::Error::Request`] for a plant without images that has too many instances.
    pub fn new(gpu: &Gpu, wood: Arc<Wood>, faces: usize) -> Result<Self> {
        let shot = bindings::layout(gpu, "frame", ShaderStages::VERTEX_FRAGMENT, &[BindingKind::Uniform]);
        let layouts = [shot, tree_layout(gpu), material_layout(gpu), daylight::layout(gpu)];
        let species = (0..).zip(&wood.species);
        let species = species.map(|(number, species)| SpeciesBuffers::new(gpu, species, number, &layouts[2]));
        let alignment = u64::from(gpu.device.limits().min_uniform_buffer_offset_alignment);
        Ok(Self {
            species: species.collect::<Result<_>>()?,
            layouts,
            pipelines: FxHashMap::default(),
            daylight: GrowingBuffer::new(gpu, "daylight", BufferUsages::UNIFORM),
            trees: GrowingBuffer::new(gpu, "trees", BufferUsages::UNIFORM),
            stride: (size_of::<TreeWords>() as u64).next_multiple_of(alignment),
            polygons: Vec::new(),
            parts: GrowingBuffer::new(gpu, "parts of trees", BufferUsages::VERTEX),
            flakes: Flakes::new(gpu),
            flaked: Flaked::new(gpu),
            has_images: false,
            faces,
            wood,
        })
    }

    /// Returns whether the species of other trees are on the device already, in the same order.
    fn has_species_of(&self, wood: &Wood) -> bool {
        let same = |(known, other): (&WoodSpecies, &WoodSpecies)| {
            let images = [known, other].map(|species| species.images.as_ref().map(Arc::as_ptr));
            let openness = [known, other].map(|species| species.openness.as_ref().map(Arc::as_ptr));
            Arc::ptr_eq(&known.plant, &other.plant) && images[0] == images[1] && openness[0] == openness[1]
        };
        let (known, other) = (&self.wood.species, &wood.species);
        known.len() == other.len() && known.iter().zip(other).all(same)
    }

    /// Returns the depths of the nearest and the farthest point of the trees that a view may show; `None` where there are none.
    pub fn depths(&self, shot: &Shot) -> Option<[f64; 2]> {
        let balls = self.wood.trees.iter().map(|tree| self.wood.ball(tree));
        let depths = balls.filter_map(|ball| {
            let middle = shot.pose.camera_from_world(ball.middle).z;
            let far = middle + ball.radius;
            (far > 0.0).then(|| [(middle - ball.radius).max(0.0), far])
        });
        depths.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
    }

    /// Writes what is different from view to view, and makes the pipelines. `of_common` is the factor from the photos' common
    /// exposure to the view's. Returns whether some tree may be in view.
    ///
    /// # Errors
    /// [`crate::Error::Request`] for a plant that has too many instances to be drawn as polygons.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        shot: &Shot,
        (program, samples): (TreeProgram, u32),
        of_common: [f64; 3],
    ) -> Result<bool> {
        let is_in_view = |number: &usize| {
            let ball = self.wood.ball(&self.wood.trees[*number]);
            let middle = shot.pose.camera_from_world(ball.middle);
            crate::foliage::sees(&shot.camera, &crate::foliage::Ball { middle, ..ball })
        };
        let in_view: Vec<usize> = (0..self.wood.trees.len()).filter(is_in_view).collect();
        if in_view.is_empty() {
            return Ok(false);
        }
        self.daylight.write(gpu, &[DaylightWords::new(&self.wood.light, shot)]);
        self.write_parts(gpu, shot, (&in_view, samples))?;
        let exposure = DVec3::from_array(of_common).as_vec3();
        self.write_trees(gpu, shot, &in_view, exposure);
        let layouts = &self.layouts;
        for cut in [false, true] {
            let key = (program, cut, samples);
            self.pipelines.entry(key).or_insert_with(|| pipeline(gpu, key, layouts));
        }
        if self.has_images {
            let shown: Vec<ShownWords> =
                in_view.iter().map(|number| self.shown(shot, *number, exposure)).collect();
            self.flaked.prepare(gpu, &shown, (program, samples), [&layouts[0], &layouts[3]]);
        }
        Ok(true)
    }

    /// Finds what of the trees in view is drawn from images, and what as polygons.
    fn write_parts(&mut self, gpu: &Gpu, shot: &Shot, (in_view, samples): (&[usize], u32)) -> Result<()> {
        let from_images = |number: usize| {
            let images = self.species[self.wood.trees[number].species].images.as_ref()?;
            (shot.trees == TreeMethod::Flakes).then(|| self.seen(shot, number, images))
        };
        let seen: Vec<Option<InView>> = in_view.par_iter().map(|number| from_images(*number)).collect();
        let (mut images, mut parts) = (vec![Vec::new(); self.species.len()], Vec::new());
        self.polygons.clear();
        for ((slot, &number), seen) in (0u32..).zip(in_view).zip(seen) {
            let species = self.wood.trees[number].species;
            let WoodSpecies { plant, .. } = &self.wood.species[species];
            let buffers = &mut self.species[species];
            let Some((InView { images: of_tree, polygons }, of_species)) = seen.zip(buffers.images.as_ref())
            else {
                buffers.want_instances(gpu, plant)?;
                self.polygons.push(PolygonDraw { slot, species, object: None, instances: 0..0 });
                continue;
            };
            let words = |image: &ImageInView| FlakeImageWords {
                tree: slot,
                species: species as u32,
                ..of_species.words(plant, image)
            };
            images[species].extend(of_tree.iter().map(words));
            for of_object in polygons.chunk_by(|(a, _), (b, _)| a == b) {
                let first = parts.len() as u32;
                parts.extend(
                    of_object.iter().map(|(_, camera_from_object)| instance_words(camera_from_object)),
                );
                let (object, instances) = (Some(of_object[0].0), first..parts.len() as u32);
                self.polygons.push(PolygonDraw { slot, species, object, instances });
            }
        }
        if !parts.is_empty() {
            self.parts.write(gpu, &parts);
        }
        let size = [shot.camera.width, shot.camera.height, samples];
        self.has_images = self.flakes.prepare(gpu, &mut images.concat(), self.species.len(), size);
        Ok(())
    }

    /// Returns what a view shows of a tree that has images.
    fn seen(&self, shot: &Shot, number: usize, images: &SpeciesImages) -> InView {
        let tree = &self.wood.trees[number];
        let plant = &self.wood.species[tree.species].plant;
        let ball = plant.whole().bounds.ball;
        let view = View::of_tree(shot.camera, &shot.pose, &tree.world_from_plant, &ball);
        let options = match shot.quality {
            Quality::Preview => FlakeOptions::PREVIEW,
            Quality::Final => FlakeOptions::FINAL,
        };
        in_view(plant, &images.images, &view, &options.walk, u64::from(tree.number))
    }

    fn write_trees(&mut self, gpu: &Gpu, shot: &Shot, in_view: &[usize], exposure: Vec3) {
        let camera_from_world = DAffine3::from_mat3_translation(shot.pose.rotation, shot.pose.translation);
        let is_whole: Vec<bool> = self.polygons.iter().fold(vec![false; in_view.len()], |mut whole, draw| {
            whole[draw.slot as usize] |= draw.object.is_none();
            whole
        });
        let mut bytes = vec![0u8; self.stride as usize * in_view.len()];
        for ((place, &number), is_whole) in
            bytes.chunks_exact_mut(self.stride as usize).zip(in_view).zip(is_whole)
        {
            // Parts are mapped to the camera's frame already.
            let map = match is_whole {
                true => camera_from_world * self.wood.trees[number].world_from_plant,
                false => DAffine3::IDENTITY,
            };
            let [right, down, forward] = rows_of(&map);
            let ShownWords { tint, number, plain, crown } = self.shown(shot, number, exposure);
            let words = TreeWords { right, down, forward, tint, number, plain, crown };
            place[..size_of::<TreeWords>()].copy_from_slice(bytemuck::bytes_of(&words));
        }
        self.trees.write(gpu, &bytes);
    }

    /// Returns what a view shows of a tree.
    fn shown(&self, shot: &Shot, number: usize, exposure: Vec3) -> ShownWords {
        let tree = &self.wood.trees[number];
        let camera_from_world = DAffine3::from_mat3_translation(shot.pose.rotation, shot.pose.translation);
        let camera_from_plant = camera_from_world * tree.world_from_plant;
        let textures = &self.species[tree.species].crown;
        let crown = textures.words(shot, &camera_from_plant, self.wood.light.towards_sun);
        let (tint, plain) = ((tree.tint * exposure).to_array(), self.plain(shot, tree.number));
        ShownWords { tint, number: TREE | tree.number, plain, crown }
    }

    /// Returns the colour of a tree where a view shows no light.
    fn plain(&self, shot: &Shot, number: u32) -> [f32; 4] {
        let opaque = |colour: [u8; 3]| {
            let [r, g, b] = linear(colour).map(|light| light as f32);
            [r, g, b, 1.0]
        };
        match shot.display {
            DisplayMode::Item => opaque(colour_of_number(self.faces as u32 + number)),
            DisplayMode::Provenance => opaque(legend::TREE),
            // No photo serves trees.
            _ => {
                let flat = FLAT_LINEAR as f32;
                [flat, flat, flat, 0.0]
            }
        }
    }

    fn images(&self) -> Vec<Option<&SpeciesImages>> {
        self.species.iter().map(|species| species.images.as_ref()).collect()
    }

    /// Finds the nearest samples of images in view, before the trees are drawn.
    pub fn find(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, frame: wgpu::BindingResource) {
        if self.has_images {
            self.flakes.record(gpu, encoder, frame, &self.images());
        }
    }

    /// Draws the trees in view, for which [`Self::prepare`] was called.
    pub fn draw(
        &self,
        gpu: &Gpu,
        drawing: &mut RenderPass,
        frame: wgpu::BindingResource,
        (program, samples): (TreeProgram, u32),
    ) {
        let frame = bindings::bind(gpu, "frame", &self.layouts[0], &[frame]);
        let lights =
            self.species.iter().map(|of| of.crown.bind(gpu, &self.layouts[3], self.daylight.binding()));
        let species: Vec<_> = self.images().into_iter().zip(lights).collect();
        drawing.set_bind_group(0, &frame, &[]);
        let size = NonZeroU64::new(size_of::<TreeWords>() as u64);
        let tree = wgpu::BufferBinding { buffer: self.trees.buffer(), offset: 0, size };
        let tree = bindings::bind(gpu, "tree", &self.layouts[1], &[wgpu::BindingResource::Buffer(tree)]);
        for draw in &self.polygons {
            drawing.set_bind_group(1, &tree, &[(u64::from(draw.slot) * self.stride) as u32]);
            drawing.set_bind_group(3, &species[draw.species].1, &[]);
            self.draw_polygons(drawing, draw, (program, samples));
        }
        if self.has_images {
            self.flaked.draw(gpu, drawing, (program, samples), (&self.flakes, &species));
        }
    }

    fn draw_polygons(
        &self,
        drawing: &mut RenderPass,
        draw: &PolygonDraw,
        (program, samples): (TreeProgram, u32),
    ) {
        let species = &self.species[draw.species];
        let all = species.instances.as_ref().filter(|_| draw.object.is_none());
        match all {
            Some(all) => drawing.set_vertex_buffer(1, all.words.slice(..)),
            None => drawing.set_vertex_buffer(1, self.parts.slice()),
        }
        for mesh in
            species.meshes.iter().filter(|mesh| draw.object.is_none_or(|object| object == mesh.object))
        {
            let instances = all.map_or(&draw.instances, |all| &all.of_object[mesh.object]);
            drawing.set_pipeline(&self.pipelines[&(program, mesh.is_cut, samples)]);
            drawing.set_bind_group(2, &mesh.material, &[]);
            drawing.set_vertex_buffer(0, mesh.corners.slice(..));
            drawing.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
            drawing.draw_indexed(0..mesh.index_count, 0, instances.clone());
        }
    }
}

impl Renderer {
    /// Sets the trees that stand in the site.
    ///
    /// # Errors
    /// [`crate::Error::Request`] for a plant without images that has too many instances to be drawn as polygons; [`crate::Error::Gpu`]. The trees
    /// before remain.
    pub fn set_trees(&mut self, wood: Option<Arc<Wood>>) -> Result<()> {
        self.ready = None;
        if let (Some(plants), Some(wood)) = (&mut self.plants, &wood)
            && plants.has_species_of(wood)
        {
            plants.wood = wood.clone();
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
        match self.trees(shot).and_then(|plants| plants.depths(shot)) {
            Some([nearest, farthest]) if depths[1] > 0.0 => [depths[0].min(nearest), depths[1].max(farthest)],
            Some(of_trees) => of_trees,
            None => depths,
        }
    }
}

/// Returns the layout of a tree; trees are bound at dynamic offsets.
fn tree_layout(gpu: &Gpu) -> BindGroupLayout {
    let entries = &[wgpu::BindGroupLayoutEntry {
        binding: 0,
        visibility: ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: true,
            min_binding_size: None,
        },
        count: None,
    }];
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("tree"), entries })
}

/// Returns the complete WGSL source of a program.
pub(super) fn source(is_cut: bool) -> String {
    format!("const CUT = {is_cut};\n{SURFACES}{}{PLANTS}", daylight::SOURCE)
}

fn pipeline(gpu: &Gpu, (program, is_cut, samples): Key, layouts: &[BindGroupLayout; 4]) -> RenderPipeline {
    let corner = wgpu::VertexBufferLayout {
        array_stride: size_of::<CornerWords>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 6 => Float32x3],
    };
    let instance = wgpu::VertexBufferLayout {
        array_stride: size_of::<InstanceWords>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![3 => Float32x4, 4 => Float32x4, 5 => Float32x4],
    };
    let (source, buffers) = (source(is_cut), [Some(corner), Some(instance)]);
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
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
