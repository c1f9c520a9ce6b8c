//! The factors that bring photos' surroundings to one sky, on the device: the grids of all photos in one texture (`to_one_sky` of
//! `shaders/surroundings.wgsl`).

use half::f16;
use wgpu::{TextureFormat, TextureView};

use super::grid_packing::texture;
use crate::device::Gpu;
use quadratura_base::scene::PhotoId;
use quadratura_projection::exposure::SurroundingsGains;
use quadratura_projection::exposure::surroundings::GRID;

/// The number of grids in a row of the texture: 2048 cells, which any device supports.
pub const COLUMNS: usize = 64;

/// The factors' texture, and where each photo's are.
#[derive(Debug)]
pub struct SkyFactors {
    /// Logarithms, R, G, B.
    pub texture: TextureView,
    /// One more than the number of each photo's grid in the texture; 0 for photos without any.
    places: Vec<u32>,
}

impl SkyFactors {
    /// Uploads the factors. Photos that exceed the device's textures, of tens of thousands, stay as they are.
    pub fn new(gpu: &Gpu, gains: &SurroundingsGains) -> Self {
        let most = COLUMNS * (gpu.device.limits().max_texture_dimension_2d as usize / GRID);
        let grids: Vec<_> = gains.of_photo.iter().flatten().take(most).collect();
        let mut next = 0;
        let mut place = |is_there: bool| {
            next += u32::from(is_there);
            if is_there && next as usize <= most { next } else { 0 }
        };
        let places = gains.of_photo.iter().map(|factors| place(factors.is_some())).collect();
        let rows = grids.len().div_ceil(COLUMNS).max(1);
        let size = [COLUMNS * GRID, rows * GRID];
        let mut cells = vec![[f16::ZERO; 4]; size[0] * size[1]];
        for (at, grid) in grids.into_iter().enumerate() {
            let corner = at / COLUMNS * GRID * size[0] + at % COLUMNS * GRID;
            for (row, logs) in grid.cells.chunks_exact(GRID).enumerate() {
                let first = corner + row * size[0];
                for (cell, [r, g, b]) in cells[first..first + GRID].iter_mut().zip(logs) {
                    *cell = [*r, *g, *b, 0.0].map(f16::from_f32);
                }
            }
        }
        let bytes: Vec<u8> = cells.as_flattened().iter().flat_map(|log| log.to_le_bytes()).collect();
        let size = size.map(|side| side as u32);
        Self { texture: texture(gpu, "one sky", TextureFormat::Rgba16Float, size, &bytes), places }
    }

    /// Returns whether a photo's factors are in the texture; true for the dome, which needs none.
    pub fn holds(&self, photo: PhotoId) -> bool {
        self.places.get(photo.index()).is_none_or(|place| *place > 0)
    }

    /// Returns one more than the number of a photo's grid in the texture; 0 where it has none, and for the dome.
    pub fn place(&self, photo: PhotoId) -> u32 {
        self.places.get(photo.index()).copied().unwrap_or(0)
    }
}
