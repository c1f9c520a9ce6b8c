//! The model's triangles on the device (`shaders/surfaces.wgsl`), with f64 coordinates split into two f32.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use wgpu::{Buffer, BufferUsages};

use crate::geometry::Plane;
use crate::geometry::polygon::fit_plane;
use crate::gpu::bindings;
use crate::gpu::device::Gpu;
use crate::projection::Sources;
use crate::projection::sides::{BackSides, Side};
use crate::scene::{FaceId, Model};

/// A corner of a triangle in the layout of the shader (`Corner`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct Corner {
    high: [f32; 3],
    low: [f32; 3],
    surface: u32,
}

/// A planar part of a face in the layout of the shader (`Surface`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct SurfaceWords {
    pub normal: [f32; 3],
    pub distance_high: f32,
    pub distance_low: f32,
    pub face: u32,
    pub flags: u32,
    pub pad0: u32,
}

/// The model's data that is the same for all views.
#[derive(Debug)]
pub struct ModelBuffers {
    /// The world point that positions are relative to.
    origin: DVec3,
    /// The corners of all triangles, for the vertex stage.
    pub corners: Buffer,
    /// The number of corners.
    pub count: u32,
    /// The table of [`SurfaceWords`], to which corners refer by index.
    pub planes: Buffer,
}

impl ModelBuffers {
    /// Uploads all faces in model order, so that of faces at one depth the last is drawn last.
    pub fn new(gpu: &Gpu, model: &Model, sources: &Sources, sides: &BackSides) -> Self {
        let origin = origin(model, sources);
        let (mut corners, mut surfaces) = (Vec::new(), Vec::new());
        for face in model.face_ids() {
            for (plane, triangles) in parts(model, face) {
                let surface = surfaces.len() as u32;
                surfaces
                    .push(SurfaceWords { flags: flags(model, face, sides), ..words(face, &plane, origin) });
                let points = triangles.iter().flatten().map(|&v| model.vertices[v as usize] - origin);
                corners.extend(points.map(|p| {
                    let (high, low) = split(p);
                    Corner { high, low, surface }
                }));
            }
        }
        let count = corners.len() as u32;
        // An empty model has a buffer, too, because no binding may be empty.
        if surfaces.is_empty() {
            surfaces.push(SurfaceWords::zeroed());
            corners.push(Corner::zeroed());
        }
        Self {
            origin,
            corners: bindings::filled(gpu, "corners", &corners, BufferUsages::VERTEX),
            count,
            planes: bindings::filled(gpu, "surfaces", &surfaces, BufferUsages::STORAGE),
        }
    }

    /// Returns the world point that positions are relative to.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }
}

/// Returns a point with whole coordinates near the cameras.
fn origin(model: &Model, sources: &Sources) -> DVec3 {
    let centers: Vec<DVec3> = sources.photos.iter().map(|p| p.pose.center_in_world()).collect();
    let points = if centers.is_empty() { &model.vertices } else { &centers };
    let sum: DVec3 = points.iter().sum();
    (sum / points.len().max(1) as f64).round()
}

/// Returns the planar parts of a face: the face with its triangles, or each triangle when it is not planar.
fn parts(model: &Model, face: FaceId) -> Vec<(Plane, Vec<[u32; 3]>)> {
    let triangles = model.face_triangles(face);
    if model.face(face).planar {
        return vec![(model.face(face).plane, triangles.to_vec())];
    }
    let plane_of = |t: &[u32; 3]| fit_plane(&t.map(|v| model.vertices[v as usize]));
    triangles.iter().filter_map(|t| Some((plane_of(t)?, vec![*t]))).collect()
}

/// Returns `FLAG_BILLBOARD`, `FLAG_FRONT_IS_BACK` and `FLAG_BACK_IS_BACK` of the shader.
fn flags(model: &Model, face: FaceId, sides: &BackSides) -> u32 {
    let billboard = model.object(model.face(face).object).billboard;
    let [front, back] = [Side::Front, Side::Back].map(|side| sides.is_back(face, side));
    u32::from(billboard) | u32::from(front) << 1 | u32::from(back) << 2
}

fn words(face: FaceId, plane: &Plane, origin: DVec3) -> SurfaceWords {
    let distance = plane.normal.dot(plane.point - origin);
    let distance_high = distance as f32;
    SurfaceWords {
        normal: plane.normal.as_vec3().to_array(),
        distance_high,
        distance_low: (distance - f64::from(distance_high)) as f32,
        face: face.0,
        flags: 0,
        pad0: 0,
    }
}

/// Splits a point into the sum of two f32 vectors.
pub fn split(p: DVec3) -> ([f32; 3], [f32; 3]) {
    let high = p.as_vec3();
    (high.to_array(), (p - high.as_dvec3()).as_vec3().to_array())
}
