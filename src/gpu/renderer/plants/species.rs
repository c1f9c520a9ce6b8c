//! The plants of a site on the device: corners, instances and pictures.

use std::ops::Range;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, Vec4};
use half::f16;
use rustc_hash::FxHashMap;
use wgpu::{BindGroup, BindGroupLayout, Buffer, BufferUsages};

use super::daylight::CrownTextures;
use super::flake::{SpeciesImages, rows_of};
use super::painted::Painted;
use crate::bindings;
use crate::device::Gpu;
use quadratura_base::error::{Error, Result};
use quadratura_foliage::{Material, Mesh, Pixels, PlacedSpecies, Plant, Stipple, Use, Wrap};

/// The largest number of instances of sub-objects of a species that are drawn as polygons, 56 bytes each.
const MOST_INSTANCES: u64 = 4_000_000;

/// The attributes of a corner in the layout of the shader (`PlantCorner`).
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct CornerWords {
    position: [f32; 3],
    normal: [f32; 3],
    texture: [f32; 2],
    /// The factors by which paint changes light plus 0.01; 1 without paint.
    change: [f32; 3],
}

/// The attributes of an instance likewise.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct InstanceWords {
    /// The rows of its map to the frame of instances: the plant's, or the camera's.
    rows: [[f32; 4]; 3],
    /// [`Stipple::word`].
    stipple: u32,
    /// The index of its tree among those in view, counted from `first` of [`super::pipeline::PlacementWords`].
    tree: u32,
}

/// A material in the layout of the shader (`Matter`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct MatterWords {
    pub reflected: [f32; 3],
    pub leaf: u32,
    pub through: [f32; 3],
    pub cutout: f32,
    pub size: [f32; 2],
    pub pad0: [f32; 2],
}

/// The triangles of one sub-object and material, at all levels of detail.
#[derive(Debug)]
pub struct MeshBuffers {
    pub corners: Buffer,
    /// Three indices a triangle, of 4 bytes.
    pub indices: Buffer,
    /// Where the levels of detail are, from the full one on.
    levels: Vec<LevelInBuffers>,
    /// The index of the sub-object.
    pub object: usize,
    /// The material with its picture.
    pub material: BindGroup,
    /// True where the picture is cut out.
    pub is_cut: bool,
}

/// A level of detail among the triangles of a sub-object.
#[derive(Debug, Clone)]
pub struct LevelInBuffers {
    /// Its indices.
    pub indices: Range<u32>,
    /// What is added to each index.
    pub first_corner: i32,
}

impl MeshBuffers {
    /// Returns where a level of detail is.
    pub fn level(&self, level: usize) -> &LevelInBuffers {
        &self.levels[level]
    }
}

/// A plant on the device.
#[derive(Debug)]
pub struct SpeciesBuffers {
    /// In the order of the sub-objects.
    pub meshes: Vec<MeshBuffers>,
    /// All instances, where the plant was drawn by polygons alone.
    pub instances: Option<AllInstances>,
    /// The images, where there are any.
    pub images: Option<SpeciesImages>,
    /// How open the crown is.
    pub crown: CrownTextures,
}

/// All instances of a plant's sub-objects that have primitives of their own.
#[derive(Debug)]
pub struct AllInstances {
    /// [`InstanceWords`], sub-object by sub-object.
    pub words: Buffer,
    /// Those of each sub-object.
    pub of_object: Vec<Range<u32>>,
}

/// Returns the layout of materials.
pub fn material_layout(gpu: &Gpu) -> BindGroupLayout {
    use bindings::BindingKind::{Filtered, Sampler, Uniform};
    bindings::layout(gpu, "matter", wgpu::ShaderStages::FRAGMENT, &[Uniform, Filtered, Sampler])
}

impl SpeciesBuffers {
    /// Uploads the plant of a species with its images. `number` is that of the species among those of the site.
    ///
    /// # Errors
    /// [`Error::Request`] for a plant without images that has more instances than are drawn as polygons.
    pub fn new(gpu: &Gpu, species: &PlacedSpecies, number: u32, layout: &BindGroupLayout) -> Result<Self> {
        let images = species.images.as_ref().map(|images| SpeciesImages::new(gpu, images, number));
        if images.is_none() {
            check(&species.plant)?;
        }
        let mut materials = MaterialBindings { gpu, layout, known: FxHashMap::default() };
        let mut meshes = Vec::new();
        for (index, object) in species.plant.objects.iter().enumerate() {
            // Without images trees are drawn in full detail.
            let levels = if images.is_some() { object.detail.count() } else { 1 };
            let painted = |level| {
                Mesh::of_level(object, level).into_iter().map(|mesh| Painted::new(mesh, &object.paint))
            };
            // All levels have the same materials in the same order.
            let mut of_materials: Vec<Vec<Painted>> = painted(0).map(|mesh| vec![mesh]).collect();
            for level in 1..levels {
                of_materials.iter_mut().zip(painted(level)).for_each(|(levels, mesh)| levels.push(mesh));
            }
            for levels in of_materials.iter().filter(|levels| !levels[0].mesh.triangles.is_empty()) {
                let material = materials.bound(&levels[0].mesh.material);
                meshes.push(mesh_buffers(gpu, levels, index, material));
            }
        }
        let crown = CrownTextures::new(gpu, species.openness.as_deref());
        Ok(Self { meshes, instances: None, images, crown })
    }

    /// Uploads all instances of the plant, unless that was done before.
    ///
    /// # Errors
    /// [`Error::Request`] for a plant of more instances than are drawn as polygons.
    pub fn want_instances(&mut self, gpu: &Gpu, plant: &Plant) -> Result<()> {
        if self.instances.is_some() {
            return Ok(());
        }
        check(plant)?;
        let (mut words, mut of_object) = (Vec::new(), Vec::new());
        for maps in instances(plant) {
            let first = words.len() as u32;
            words.extend(maps.iter().map(|map| InstanceWords::new(map, &Stipple::wide(0), 0)));
            of_object.push(first..words.len() as u32);
        }
        let words = bindings::filled(gpu, "instances", &words, BufferUsages::VERTEX);
        self.instances = Some(AllInstances { words, of_object });
        Ok(())
    }
}

/// Refuses a plant of too many instances.
fn check(plant: &Plant) -> Result<()> {
    let counts = plant.instances();
    let drawn = plant.objects.iter().zip(&counts).filter(|(object, _)| !object.primitives.is_empty());
    let all = drawn.fold(0u64, |sum, (_, count)| sum.saturating_add(*count));
    if all <= MOST_INSTANCES {
        return Ok(());
    }
    Err(Error::Request(format!(
        "the plant {:?} has {all} sub-objects, counting every instance, and at most {MOST_INSTANCES} are drawn as polygons; give \
         a plant with fewer uses, or draw it from images",
        plant.whole().name
    )))
}

/// Returns the maps to the plant's frame of the instances of each sub-object that has primitives of its own.
fn instances(plant: &Plant) -> Vec<Vec<DAffine3>> {
    let mut found = vec![Vec::new(); plant.objects.len()];
    let mut left = vec![(plant.root, DAffine3::IDENTITY)];
    while let Some((object, plant_from_object)) = left.pop() {
        let of = &plant.objects[object];
        if of.counts.triangles == 0 {
            continue;
        }
        if !of.primitives.is_empty() {
            found[object].push(plant_from_object);
        }
        let child = |&Use { child, parent_from_child }: &Use| (child, plant_from_object * parent_from_child);
        left.extend(of.uses.iter().rev().map(child));
    }
    found
}

impl InstanceWords {
    /// Returns the attributes of an instance that is drawn through a stipple.
    pub fn new(map: &DAffine3, stipple: &Stipple, tree: u32) -> Self {
        Self { rows: rows_of(map), stipple: stipple.word(), tree }
    }
}

/// Uploads the triangles of one material at all levels of detail.
fn mesh_buffers(gpu: &Gpu, of_levels: &[Painted], object: usize, material: BindGroup) -> MeshBuffers {
    let (mut corners, mut indices, mut levels) = (Vec::new(), Vec::new(), Vec::new());
    for Painted { mesh, changes } in of_levels {
        let (first_corner, first) = (corners.len() as i32, indices.len() as u32);
        corners.extend(mesh.corners.iter().zip(changes).map(|(corner, change)| CornerWords {
            position: corner.position.as_vec3().to_array(),
            normal: corner.normal.as_vec3().to_array(),
            texture: corner.texture.as_vec2().to_array(),
            change: change.factors().to_array(),
        }));
        indices.extend_from_slice(mesh.triangles.as_flattened());
        levels.push(LevelInBuffers { indices: first..indices.len() as u32, first_corner });
    }
    let Material { picture, cutout, .. } = &*of_levels[0].mesh.material;
    MeshBuffers {
        corners: bindings::filled(gpu, "corners of plants", &corners, BufferUsages::VERTEX),
        indices: bindings::filled(gpu, "triangles of plants", &indices, BufferUsages::INDEX),
        levels,
        object,
        is_cut: picture.is_some() && cutout.is_some(),
        material,
    }
}

/// The bindings of the materials that were made so far, by where the materials are stored.
struct MaterialBindings<'a> {
    gpu: &'a Gpu,
    layout: &'a BindGroupLayout,
    known: FxHashMap<*const Material, BindGroup>,
}

impl MaterialBindings<'_> {
    fn bound(&mut self, material: &Arc<Material>) -> BindGroup {
        let (gpu, layout) = (self.gpu, self.layout);
        self.known.entry(Arc::as_ptr(material)).or_insert_with(|| bound(gpu, layout, material)).clone()
    }
}

fn bound(gpu: &Gpu, layout: &BindGroupLayout, material: &Material) -> BindGroup {
    let Material { reflected, through, leaf, cutout, picture, wrap, .. } = material;
    let white = Pixels::new(1, 1, vec![[255; 4]]);
    let pixels = picture.as_deref().unwrap_or(&white);
    let (texture, size) = texture(gpu, pixels);
    let words = MatterWords {
        reflected: *reflected,
        leaf: u32::from(*leaf),
        through: *through,
        cutout: cutout.unwrap_or(0.0),
        size: size.map(|side| side as f32),
        pad0: [0.0; 2],
    };
    let uniform = bindings::filled(gpu, "matter", &[words], BufferUsages::UNIFORM);
    let address = |wrap: Wrap| match wrap {
        Wrap::Held => wgpu::AddressMode::ClampToEdge,
        Wrap::Repeated => wgpu::AddressMode::Repeat,
        Wrap::Mirrored => wgpu::AddressMode::MirrorRepeat,
    };
    let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("picture of a plant"),
        address_mode_u: address(wrap[0]),
        address_mode_v: address(wrap[1]),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..Default::default()
    });
    let resources = [
        uniform.as_entire_binding(),
        wgpu::BindingResource::TextureView(&texture.create_view(&Default::default())),
        wgpu::BindingResource::Sampler(&sampler),
    ];
    bindings::bind(gpu, "matter", layout, &resources)
}

/// Uploads a picture with its coarser copies, from the finest one on that the device can hold; returns the size of that.
fn texture(gpu: &Gpu, pixels: &Pixels) -> (wgpu::Texture, [usize; 2]) {
    let longest = gpu.device.limits().max_texture_dimension_2d as usize;
    let copies = pixels.halves();
    let first = copies.iter().position(|([width, height], _)| (*width).max(*height) <= longest);
    let copies = &copies[first.expect("the coarsest copy is a single pixel")..];
    let size = copies[0].0;
    let extent = |[width, height]: [usize; 2]| wgpu::Extent3d {
        width: width as u32,
        height: height as u32,
        depth_or_array_layers: 1,
    };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture of a plant"),
        size: extent(size),
        mip_level_count: copies.len() as u32,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (mip_level, (size, light)) in (0..).zip(copies) {
        let words: Vec<[u16; 4]> = light
            .iter()
            .map(|light: &Vec4| light.to_array().map(|value| f16::from_f32(value).to_bits()))
            .collect();
        let target = wgpu::TexelCopyTextureInfo { mip_level, ..texture.as_image_copy() };
        let bytes_per_row = Some(size_of::<[u16; 4]>() as u32 * size[0] as u32);
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
        gpu.queue.write_texture(target, bytemuck::cast_slice(&words), layout, extent(*size));
    }
    (texture, size)
}
