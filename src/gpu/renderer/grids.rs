//! What lies on grids in the planes of faces, on the device: the heights of all faces packed into one texture, the colours with which
//! they continue in another one, and the positions of both (`FaceGrids` of `shaders/project.wgsl`).

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};
use half::f16;
use wgpu::{Buffer, BufferUsages, TextureFormat, TextureView};

use super::grid_packing::GridPacking;
use crate::bindings;
use crate::device::Gpu;
use quadratura_base::geometry::polygon::PlaneFrame;
use quadratura_base::scene::{FaceId, Model};
use quadratura_projection::continuation::Continuation;
use quadratura_projection::relief::Relief;

/// The grids of one face in the layout of the shader (`FaceGrids`).
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct FaceGridsWords {
    pub relief: GridWords,
    pub continued: GridWords,
}

/// A grid of one face in the layout of the shader (`FaceGrid`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct GridWords {
    pub across: [f32; 3],
    pub across_high: f32,
    pub up: [f32; 3],
    pub up_high: f32,
    pub across_low: f32,
    pub up_low: f32,
    pub corner: [f32; 2],
    pub size: [f32; 2],
    pub pad0: [f32; 2],
}

/// The textures of all grids and their table. A clone shares them.
#[derive(Debug, Clone)]
pub struct FaceGrids {
    /// The heights of all faces, in world units.
    pub heights: TextureView,
    /// The colours with which faces continue, in the common exposure.
    pub colours: TextureView,
    /// The table of [`FaceGridsWords`], one per face.
    pub places: Buffer,
    words: Vec<FaceGridsWords>,
    /// The largest height of each face, in world units.
    pub largest: Vec<f64>,
}

impl FaceGrids {
    /// Uploads the relief, and no colours; `origin` is the world point that positions are relative to.
    pub fn new(gpu: &Gpu, model: &Model, relief: &Relief, origin: DVec3) -> Self {
        let words = vec![FaceGridsWords::zeroed(); model.faces.len().max(1)];
        let none = GridPacking::new(std::iter::empty::<(FaceId, [u32; 2])>(), LEAST_SIDE);
        let empty = |format, bytes: usize| none.texture(gpu, "grids", format, &vec![0; bytes * none.cells()]);
        let mut grids = Self {
            heights: empty(TextureFormat::R16Float, 2),
            colours: empty(TextureFormat::Rgba8UnormSrgb, 4),
            places: table(gpu, &words),
            words,
            largest: Vec::new(),
        };
        grids.set_relief(gpu, relief, origin);
        grids
    }

    /// Replaces the relief.
    pub fn set_relief(&mut self, gpu: &Gpu, relief: &Relief, origin: DVec3) {
        let faces = || (0..self.words.len() as u32).map(FaceId);
        // Faces whose grids exceed the device's textures stay flat.
        let grids = faces().filter_map(|face| Some((face, relief.of(face)?.size)));
        let packing = GridPacking::new(grids, gpu.device.limits().max_texture_dimension_2d);
        let mut cells = vec![f16::ZERO; packing.cells()];
        self.largest = vec![0.0; self.words.len()];
        self.words.iter_mut().for_each(|words| words.relief = GridWords::zeroed());
        for &(face, corner) in &packing.positions {
            let Some(heights) = relief.of(face) else { continue };
            let place = PlacedGrid {
                frame: &heights.frame,
                low: heights.low,
                cell: heights.cell,
                size: heights.size,
            };
            self.words[face.0 as usize].relief = place.words(corner, origin);
            self.largest[face.0 as usize] = heights.largest();
            let values: Vec<f16> = heights.heights.iter().map(|height| f16::from_f32(*height)).collect();
            packing.copy(&mut cells, &values, corner, heights.size[0]);
        }
        let bytes: Vec<u8> = cells.iter().flat_map(|h| h.to_le_bytes()).collect();
        self.heights = packing.texture(gpu, "heights", TextureFormat::R16Float, &bytes);
        self.places = table(gpu, &self.words);
    }

    /// Replaces the colours with which faces continue.
    pub fn set_continuation(&mut self, gpu: &Gpu, continuation: &Continuation, origin: DVec3) {
        let faces = || (0..self.words.len() as u32).map(FaceId);
        let grids = faces().filter_map(|face| Some((face, continuation.of(face)?.size)));
        let packing = GridPacking::new(grids, gpu.device.limits().max_texture_dimension_2d);
        let mut cells = vec![[0u8; 4]; packing.cells()];
        self.words.iter_mut().for_each(|words| words.continued = GridWords::zeroed());
        for &(face, corner) in &packing.positions {
            let Some(colours) = continuation.of(face) else { continue };
            let place = PlacedGrid {
                frame: &colours.frame,
                low: colours.low,
                cell: colours.cell,
                size: colours.size,
            };
            self.words[face.0 as usize].continued = place.words(corner, origin);
            let values: Vec<[u8; 4]> =
                colours.colours.iter().map(|[r, g, b]| [*r, *g, *b, u8::MAX]).collect();
            packing.copy(&mut cells, &values, corner, colours.size[0]);
        }
        self.colours = packing.texture(gpu, "continued", TextureFormat::Rgba8UnormSrgb, cells.as_flattened());
        self.places = table(gpu, &self.words);
    }
}

/// The side that any device's textures may have.
const LEAST_SIDE: u32 = 2048;

fn table(gpu: &Gpu, words: &[FaceGridsWords]) -> Buffer {
    bindings::filled(gpu, "grids of faces", words, BufferUsages::STORAGE)
}

/// A grid in the plane of a face, in world units.
struct PlacedGrid<'a> {
    frame: &'a PlaneFrame,
    low: DVec2,
    cell: f64,
    size: [u32; 2],
}

impl PlacedGrid<'_> {
    fn words(&self, corner: [u32; 2], origin: DVec3) -> GridWords {
        // Flat coordinates are affine, so their directions are what a step along each world axis adds.
        let zero = self.frame.flat(origin);
        let step = |axis: DVec3| self.frame.flat(origin + axis) - zero;
        let x = step(DVec3::X);
        let y = step(DVec3::Y);
        let z = step(DVec3::Z);
        let scale = 1.0 / self.cell;
        let offset: DVec2 = (zero - self.low) * scale;
        let split = |v: f64| (v as f32, (v - f64::from(v as f32)) as f32);
        let (across_high, across_low) = split(offset.x);
        let (up_high, up_low) = split(offset.y);
        GridWords {
            across: (DVec3::new(x.x, y.x, z.x) * scale).as_vec3().to_array(),
            across_high,
            up: (DVec3::new(x.y, y.y, z.y) * scale).as_vec3().to_array(),
            up_high,
            across_low,
            up_low,
            corner: corner.map(|v| v as f32),
            size: self.size.map(|v| v as f32),
            pad0: [0.0; 2],
        }
    }
}
