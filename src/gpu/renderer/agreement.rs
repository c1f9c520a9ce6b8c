//! The photos' agreement on the device: the grids of all image layers packed into one texture, and the position of each
//! (`AgreementPlace` of `shaders/project.wgsl`).

use bytemuck::{Pod, Zeroable};
use wgpu::{Buffer, BufferUsages, TextureFormat, TextureView};

use super::packing::Packing;
use crate::gpu::bindings;
use crate::gpu::device::Gpu;
use crate::projection::LayerTextureId;
use crate::projection::agreement::{Agreement, AgreementGrid};

/// The grid of one image layer in the layout of the shader (`AgreementPlace`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct PlaceWords {
    pub cells_per_px: [f32; 2],
    pub origin: [f32; 2],
    pub size: [f32; 2],
    pub corner: [f32; 2],
}

/// The longest side of the texture: 64 MiB in all.
const LONGEST_SIDE: u32 = 8192;

/// The agreement's texture and table.
#[derive(Debug)]
pub struct AgreementTexture {
    /// The agreement of each cell, 0 to 1.
    pub texture: TextureView,
    /// The table of [`PlaceWords`], one per image layer.
    pub places: Buffer,
    /// The same on the CPU, for bounds of penalties.
    pub agreement: Agreement,
}

impl AgreementTexture {
    /// Uploads the agreement of `layer_textures` image layers. Grids that exceed the device's textures together are all
    /// made coarser: hundreds of photos still agree or not, less sharply.
    pub fn new(gpu: &Gpu, mut agreement: Agreement, layer_textures: usize) -> Self {
        let ids = || (0..layer_textures as u32).map(LayerTextureId);
        let longest = gpu.device.limits().max_texture_dimension_2d.min(LONGEST_SIDE);
        let packing = loop {
            let grids = ids().filter_map(|id| Some((id, agreement.of(id)?.size)));
            let packing = Packing::new(grids, longest);
            if packing.is_complete {
                break packing;
            }
            agreement = agreement.halved();
        };
        let mut cells = vec![u8::MAX; (packing.size[0] * packing.size[1]) as usize];
        let mut places = vec![PlaceWords::zeroed(); layer_textures.max(1)];
        let mut packed = vec![None; agreement.of_texture.len()];
        for &(id, corner) in &packing.positions {
            let Some(grid) = agreement.of_texture[id.0 as usize].take() else { continue };
            places[id.0 as usize] = words(&grid, corner);
            for (row, line) in (0..).zip(grid.values.chunks_exact(grid.size[0] as usize)) {
                let first = ((corner[1] + row) * packing.size[0] + corner[0]) as usize;
                cells[first..first + line.len()].copy_from_slice(line);
            }
            packed[id.0 as usize] = Some(grid);
        }
        Self {
            texture: packing.texture(gpu, "agreement", TextureFormat::R8Unorm, &cells),
            places: bindings::filled(gpu, "agreement places", &places, BufferUsages::STORAGE),
            agreement: Agreement { of_texture: packed },
        }
    }
}

fn words(grid: &AgreementGrid, corner: [u32; 2]) -> PlaceWords {
    PlaceWords {
        cells_per_px: grid.cells_per_px.as_vec2().to_array(),
        origin: grid.corner.map(|at| at as f32),
        size: grid.size.map(|side| side as f32),
        corner: corner.map(|at| at as f32),
    }
}
