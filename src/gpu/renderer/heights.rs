//! The relief on the device: all faces' heights packed into one texture, and the position of each (`Relief`
//! of `shaders/project.wgsl`).

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};
use half::f16;
use wgpu::{Buffer, BufferUsages, TextureFormat, TextureView};

use super::packing::Packing;
use crate::gpu::bindings;
use crate::gpu::device::Gpu;
use crate::projection::relief::{FaceRelief, Relief};
use crate::scene::Model;

/// The relief of one face in the layout of the shader (`Relief`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct ReliefWords {
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

/// The relief's texture and table.
#[derive(Debug)]
pub struct Heights {
    /// The heights of all faces, in world units.
    pub texture: TextureView,
    /// The table of [`ReliefWords`], one per face.
    pub places: Buffer,
    /// The largest height of each face, in world units.
    pub largest: Vec<f64>,
}

impl Heights {
    /// Uploads the relief; `origin` is the world point that positions are relative to.
    pub fn new(gpu: &Gpu, model: &Model, relief: &Relief, origin: DVec3) -> Self {
        // Faces whose grids exceed the device's textures stay flat.
        let grids = model.face_ids().filter_map(|face| Some((face, relief.of(face)?.size)));
        let packing = Packing::new(grids, gpu.device.limits().max_texture_dimension_2d);
        let mut cells = vec![f16::ZERO; (packing.size[0] * packing.size[1]) as usize];
        let mut places = vec![ReliefWords::zeroed(); model.faces.len().max(1)];
        let mut largest = vec![0.0; model.faces.len()];
        for &(face, corner) in &packing.positions {
            let Some(heights) = relief.of(face) else { continue };
            places[face.0 as usize] = words(heights, corner, origin);
            largest[face.0 as usize] = heights.largest();
            for (row, line) in heights.heights.chunks_exact(heights.size[0] as usize).enumerate() {
                let first = ((corner[1] + row as u32) * packing.size[0] + corner[0]) as usize;
                let target = &mut cells[first..first + line.len()];
                target.iter_mut().zip(line).for_each(|(t, h)| *t = f16::from_f32(*h));
            }
        }
        let bytes: Vec<u8> = cells.iter().flat_map(|h| h.to_le_bytes()).collect();
        Self {
            texture: packing.texture(gpu, "heights", TextureFormat::R16Float, &bytes),
            places: bindings::filled(gpu, "reliefs", &places, BufferUsages::STORAGE),
            largest,
        }
    }
}

fn words(face: &FaceRelief, corner: [u32; 2], origin: DVec3) -> ReliefWords {
    // Flat coordinates are affine, so their directions are what a step along each world axis adds.
    let zero = face.frame.flat(origin);
    let step = |axis: DVec3| face.frame.flat(origin + axis) - zero;
    let x = step(DVec3::X);
    let y = step(DVec3::Y);
    let z = step(DVec3::Z);
    let scale = 1.0 / face.cell;
    let offset: DVec2 = (zero - face.low) * scale;
    let split = |v: f64| (v as f32, (v - f64::from(v as f32)) as f32);
    let (across_high, across_low) = split(offset.x);
    let (up_high, up_low) = split(offset.y);
    ReliefWords {
        across: (DVec3::new(x.x, y.x, z.x) * scale).as_vec3().to_array(),
        across_high,
        up: (DVec3::new(x.y, y.y, z.y) * scale).as_vec3().to_array(),
        up_high,
        across_low,
        up_low,
        corner: corner.map(|v| v as f32),
        size: face.size.map(|v| v as f32),
        pad0: [0.0; 2],
    }
}
