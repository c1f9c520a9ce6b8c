//! Trees as polygons (`shaders/plants.wgsl`), drawn between *nearness* and *project*: they hide faces and faces hide them,
//! sample by sample.

pub(super) mod species;
#[cfg(test)]
mod tests;

use std::num::NonZeroU64;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DVec3, Vec3};
use rustc_hash::FxHashMap;
use wgpu::{BindGroupLayout, BufferUsages, RenderPass, RenderPipeline, ShaderStages, TextureFormat};

use self::species::{CornerWords, InstanceWords, SpeciesBuffers, material_layout};
use super::Renderer;
use super::project::SURFACES;
use super::table::GrowingBuffer;
use super::target::{COLOR, FACES, FLAT_LINEAR};
use crate::error::Result;
use crate::foliage::{Light, Wood};
use crate::gpu::bindings::{self, BindingKind};
use crate::gpu::device::Gpu;
use crate::gpu::drawing::DEPTH;
use crate::projection::legend::{self, colour_of_number, linear};
use crate::projection::{DisplayMode, Shot, TREE, TreeMethod};

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
}

/// The light in the layout of the shader (`Daylight`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct DaylightWords {
    pub towards_sun: [f32; 3],
    pub pad0: f32,
    pub up: [f32; 3],
    pub pad1: f32,
    pub sun: [f32; 3],
    pub pad2: f32,
    pub sky: [f32; 3],
    pub pad3: f32,
    pub ground: [f32; 3],
    pub pad4: f32,
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
    /// Frame, then light and tree, then material.
    layouts: [BindGroupLayout; 3],
    pipelines: FxHashMap<Key, RenderPipeline>,
    daylight: GrowingBuffer,
    /// The trees in view, each at a multiple of [`Self::stride`].
    trees: GrowingBuffer,
    stride: u64,
    /// The trees that are in view, by number.
    in_view: Vec<usize>,
    faces: usize,
}

impl Plants {
    /// Uploads the trees of a site whose model has this many faces.
    ///
    /// # Errors
    /// [`crate::Error::Request`] for a plant with too many instances.
    pub fn new(gpu: &Gpu, wood: Arc<Wood>, faces: usize) -> Result<Self> {
        let shot = bindings::layout(gpu, "frame", ShaderStages::VERTEX_FRAGMENT, &[BindingKind::Uniform]);
        let layouts = [shot, tree_layout(gpu), material_layout(gpu)];
        let species = wood.species.iter().map(|plant| SpeciesBuffers::new(gpu, plant, &layouts[2]));
        let alignment = u64::from(gpu.device.limits().min_uniform_buffer_offset_alignment);
        Ok(Self {
            species: species.collect::<Result<_>>()?,
            layouts,
            pipelines: FxHashMap::default(),
            daylight: GrowingBuffer::new(gpu, "daylight", BufferUsages::UNIFORM),
            trees: GrowingBuffer::new(gpu, "trees", BufferUsages::UNIFORM),
            stride: (size_of::<TreeWords>() as u64).next_multiple_of(alignment),
            in_view: Vec::new(),
            faces,
            wood,
        })
    }

    /// Returns whether the species of other trees are on the device already, in the same order.
    fn has_species_of(&self, wood: &Wood) -> bool {
        let (known, other) = (&self.wood.species, &wood.species);
        known.len() == other.len() && known.iter().zip(other).all(|(known, other)| Arc::ptr_eq(known, other))
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
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        shot: &Shot,
        (program, samples): (TreeProgram, u32),
        of_common: [f64; 3],
    ) -> bool {
        let is_in_view = |number: &usize| {
            let ball = self.wood.ball(&self.wood.trees[*number]);
            let middle = shot.pose.camera_from_world(ball.middle);
            crate::foliage::sees(&shot.camera, &crate::foliage::Ball { middle, ..ball })
        };
        self.in_view = (0..self.wood.trees.len()).filter(is_in_view).collect();
        if self.in_view.is_empty() {
            return false;
        }
        let exposure = DVec3::from_array(of_common).as_vec3();
        let mut bytes = vec![0u8; self.stride as usize * self.in_view.len()];
        for (slot, &number) in bytes.chunks_exact_mut(self.stride as usize).zip(&self.in_view) {
            let words = self.tree_words(shot, number, exposure);
            slot[..size_of::<TreeWords>()].copy_from_slice(bytemuck::bytes_of(&words));
        }
        self.trees.write(gpu, &bytes);
        self.daylight.write(gpu, &[daylight_words(&self.wood.light, shot)]);
        for cut in [false, true] {
            let layouts = &self.layouts;
            let key = (program, cut, samples);
            self.pipelines.entry(key).or_insert_with(|| pipeline(gpu, key, layouts));
        }
        true
    }

    fn tree_words(&self, shot: &Shot, index: usize, exposure: Vec3) -> TreeWords {
        let tree = &self.wood.trees[index];
        let camera_from_world = DAffine3::from_mat3_translation(shot.pose.rotation, shot.pose.translation);
        let map = camera_from_world * tree.world_from_plant;
        let rows = map.matrix3.transpose();
        let row = |axis: usize| rows.col(axis).extend(map.translation[axis]).as_vec4().to_array();
        let [right, down, forward] = [0, 1, 2].map(row);
        let tint = (tree.tint * exposure).to_array();
        let number = tree.number;
        TreeWords { right, down, forward, tint, number: TREE | number, plain: self.plain(shot, number) }
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

    /// Draws the trees in view, for which [`Self::prepare`] was called.
    pub fn draw(
        &self,
        gpu: &Gpu,
        drawing: &mut RenderPass,
        frame: wgpu::BindingResource,
        (program, samples): (TreeProgram, u32),
    ) {
        let frame = bindings::bind(gpu, "frame", &self.layouts[0], &[frame]);
        let size = NonZeroU64::new(size_of::<TreeWords>() as u64);
        let tree = wgpu::BufferBinding { buffer: self.trees.buffer(), offset: 0, size };
        let resources = [self.daylight.binding(), wgpu::BindingResource::Buffer(tree)];
        let tree = bindings::bind(gpu, "tree", &self.layouts[1], &resources);
        drawing.set_bind_group(0, &frame, &[]);
        for (slot, &number) in self.in_view.iter().enumerate() {
            drawing.set_bind_group(1, &tree, &[(slot as u64 * self.stride) as u32]);
            let species = &self.species[self.wood.trees[number].species];
            drawing.set_vertex_buffer(1, species.instances.slice(..));
            for mesh in &species.meshes {
                drawing.set_pipeline(&self.pipelines[&(program, mesh.is_cut, samples)]);
                drawing.set_bind_group(2, &mesh.material, &[]);
                drawing.set_vertex_buffer(0, mesh.corners.slice(..));
                drawing.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
                drawing.draw_indexed(0..mesh.index_count, 0, mesh.instances.clone());
            }
        }
    }
}

impl Renderer {
    /// Sets the trees that stand in the site.
    ///
    /// # Errors
    /// [`Error::Request`] for a plant with too many instances to be drawn as polygons; [`Error::Gpu`]. The trees before remain.
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

/// Returns the layout of light and tree; trees are bound at dynamic offsets.
fn tree_layout(gpu: &Gpu) -> BindGroupLayout {
    let entry = |binding, has_dynamic_offset| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset,
            min_binding_size: None,
        },
        count: None,
    };
    let entries = &[entry(0, false), entry(1, true)];
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("tree"), entries })
}

fn daylight_words(light: &Light, shot: &Shot) -> DaylightWords {
    let in_camera = |direction: DVec3| (shot.pose.rotation * direction).as_vec3().to_array();
    let Light { towards_sun, up, sun, sky, ground } = light;
    DaylightWords {
        towards_sun: in_camera(*towards_sun),
        up: in_camera(*up),
        sun: sun.to_array(),
        sky: sky.to_array(),
        ground: ground.to_array(),
        ..DaylightWords::zeroed()
    }
}

/// Returns the complete WGSL source of a program.
pub(super) fn source(is_cut: bool) -> String {
    format!("const CUT = {is_cut};\n{SURFACES}{PLANTS}")
}

fn pipeline(gpu: &Gpu, (program, is_cut, samples): Key, layouts: &[BindGroupLayout; 3]) -> RenderPipeline {
    let (entry, format) = program.entry();
    let module = bindings::shader(gpu, entry, &source(is_cut));
    let corner = wgpu::VertexBufferLayout {
        array_stride: size_of::<CornerWords>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2],
    };
    let instance = wgpu::VertexBufferLayout {
        array_stride: size_of::<InstanceWords>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![3 => Float32x4, 4 => Float32x4, 5 => Float32x4],
    };
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(entry),
        layout: Some(&bindings::pipeline_layout(gpu, entry, &layouts.each_ref())),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("grown"),
            compilation_options: Default::default(),
            buffers: &[Some(corner), Some(instance)],
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
