//! The light on trees on the device, and how open their crowns are to it (`shaders/daylight.wgsl`).

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DMat3, DVec3};
use wgpu::{BindGroup, BindGroupLayout, Buffer, BufferUsages, ShaderStages, TextureFormat, TextureView};

use super::flake::rows_of;
use crate::bindings::{self, BindingKind};
use crate::device::Gpu;
use quadratura_foliage::directions::{DIRECTIONS, Serving, serving};
use quadratura_foliage::{Openness, OutdoorLight};
use quadratura_view::Shot;

/// The WGSL source that is put before passes that light trees.
pub const SOURCE: &str = include_str!("../../../../shaders/daylight.wgsl");

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

impl DaylightWords {
    /// Returns the light in the camera's frame of a view.
    pub fn new(light: &OutdoorLight, shot: &Shot) -> Self {
        let in_camera = |direction: DVec3| (shot.pose.rotation * direction).as_vec3().to_array();
        let OutdoorLight { towards_sun, up, sun, sky, ground } = light;
        Self {
            towards_sun: in_camera(*towards_sun),
            up: in_camera(*up),
            sun: sun.to_array(),
            sky: sky.to_array(),
            ground: ground.to_array(),
            ..Self::zeroed()
        }
    }
}

/// A tree's crown in the layout of the shader (`Crown`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct CrownWords {
    pub x: [f32; 4],
    pub y: [f32; 4],
    pub z: [f32; 4],
    pub suns: [u32; 4],
    pub weights: [f32; 4],
}

/// The grid of a species in the layout of the shader (`Grid`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct CrownGridWords {
    pub size: [f32; 3],
    pub pad0: f32,
}

/// Blocks of cells in a row of the texture of all directions, as in the shader (`ACROSS`).
const ACROSS: usize = 5;

/// How open the crown of a species is, on the device.
#[derive(Debug)]
pub struct CrownTextures {
    /// The corner of the grid with the smallest coordinates and the side of a cell, in the plant's frame.
    grid: (DVec3, f64),
    words: Buffer,
    openness: TextureView,
    open_towards: TextureView,
}

/// Returns the layout of light and crowns.
pub fn layout(gpu: &Gpu) -> BindGroupLayout {
    use BindingKind::{Filtered, FilteredVolume, Read, Sampler, Uniform};
    let kinds = [Uniform, Uniform, FilteredVolume, FilteredVolume, Sampler, Read, Filtered, FilteredVolume];
    bindings::layout(gpu, "daylight", ShaderStages::FRAGMENT, &kinds)
}

impl CrownTextures {
    /// Uploads how open a crown is; all light reaches all of one of which nothing is known.
    pub fn new(gpu: &Gpu, openness: Option<&Openness>) -> Self {
        let (low, cell, size) = openness.map_or((DVec3::ZERO, 1.0, [1; 3]), Openness::grid);
        let values = openness.map_or_else(|| vec![[127, 0, 0, 0]], |openness| openness.values().to_vec());
        let open = openness.map_or_else(|| vec![[u8::MAX; DIRECTIONS]], |openness| openness.open().to_vec());
        let words = CrownGridWords { size: size.map(|count| count as f32), pad0: 0.0 };
        Self {
            grid: (low, cell),
            words: bindings::filled(gpu, "grid of a crown", &[words], BufferUsages::UNIFORM),
            openness: volume(gpu, size, TextureFormat::Rgba8Snorm, bytemuck::cast_slice(&values)),
            open_towards: volume(gpu, blocks_of(size), TextureFormat::R8Unorm, &in_blocks(size, &open)),
        }
    }

    /// Binds the crown, and light: [`DaylightWords`], the ratio images in view with the cells of all, and the share of sunlight that reaches the trees.
    pub fn bind(
        &self,
        gpu: &Gpu,
        layout: &BindGroupLayout,
        [daylight, ratios, ratio_cells, sunlit]: [wgpu::BindingResource; 4],
    ) -> BindGroup {
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("grid of a crown"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let resources = [
            daylight,
            self.words.as_entire_binding(),
            wgpu::BindingResource::TextureView(&self.openness),
            wgpu::BindingResource::TextureView(&self.open_towards),
            wgpu::BindingResource::Sampler(&sampler),
            ratios,
            ratio_cells,
            sunlit,
        ];
        bindings::bind(gpu, "daylight", layout, &resources)
    }

    /// Returns the crown of a tree in a view, whose plant is mapped to the camera's frame so; `towards_sun` is in the world.
    pub fn words(&self, shot: &Shot, camera_from_plant: &DAffine3, towards_sun: DVec3) -> CrownWords {
        let (low, cell) = self.grid;
        let cells_from_plant =
            DAffine3 { matrix3: DMat3::from_diagonal(DVec3::splat(1.0 / cell)), translation: -low / cell };
        let plant_from_camera = camera_from_plant.inverse();
        let [x, y, z] = rows_of(&(cells_from_plant * plant_from_camera));
        let sun = plant_from_camera.transform_vector3(shot.pose.rotation * towards_sun);
        let (mut suns, mut weights) = ([0; 4], [0.0; 4]);
        for (at, Serving { direction, weight }) in serving(sun).into_iter().enumerate() {
            (suns[at], weights[at]) = (direction as u32, weight as f32);
        }
        CrownWords { x, y, z, suns, weights }
    }
}

/// Returns the size of the texture that holds a block of cells for each direction.
fn blocks_of([x, y, z]: [u32; 3]) -> [u32; 3] {
    [x * ACROSS as u32, y * DIRECTIONS.div_ceil(ACROSS) as u32, z]
}

/// Orders cells into blocks, one for each direction.
fn in_blocks(size: [u32; 3], open: &[[u8; DIRECTIONS]]) -> Vec<u8> {
    let [columns, rows, _] = blocks_of(size).map(|count| count as usize);
    let [x_cells, y_cells, _] = size.map(|count| count as usize);
    let mut texels = vec![0; columns * rows * size[2] as usize];
    for (cell, of_cell) in open.iter().enumerate() {
        let [x, y, z] = [cell % x_cells, cell / x_cells % y_cells, cell / (x_cells * y_cells)];
        for (direction, open) in of_cell.iter().enumerate() {
            let (column, row) = (direction % ACROSS * x_cells + x, direction / ACROSS * y_cells + y);
            texels[(z * rows + row) * columns + column] = *open;
        }
    }
    texels
}

/// Uploads a texture of three dimensions, x fastest, then y.
pub fn volume(
    gpu: &Gpu,
    [width, height, depth]: [u32; 3],
    format: TextureFormat,
    texels: &[u8],
) -> TextureView {
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: depth };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("crown"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D3,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let row = texels.len() as u32 / (height * depth);
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: Some(height) };
    gpu.queue.write_texture(texture.as_image_copy(), texels, layout, size);
    texture.create_view(&Default::default())
}
