//! The model's triangles on the device (`shaders/surfaces.wgsl`), with f64 coordinates split into two f32.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use wgpu::{Buffer, BufferUsages};

use crate::bindings;
use crate::device::Gpu;
use quadratura_base::geometry::Plane;
use quadratura_base::geometry::polygon::fit_plane;
use quadratura_base::scene::{FaceId, Model};
use quadratura_projection::Sources;
use quadratura_projection::back_to_front::{Piece, back_to_front};
use quadratura_projection::peeling::PlanarPart;
use quadratura_projection::sides::{BackSides, Side};
use quadratura_projection::skirts::Skirts;

/// A corner of a triangle in the layout of the shader (`Corner`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct SurfaceVertex {
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
    pub half_width: f32,
    pub foot_high: [f32; 3],
    pub pad0: f32,
    pub foot_low: [f32; 3],
    pub pad1: f32,
    pub axis: [f32; 3],
    pub pad2: f32,
}

/// The model's data that is the same for all views.
#[derive(Debug)]
pub struct ModelBuffers {
    /// The world point that positions are relative to.
    origin: DVec3,
    /// The corners of all triangles, for the vertex stage.
    pub corners: Buffer,
    /// The number of corners of all faces; those of skirts are made for each view.
    pub count: u32,
    /// The table of [`SurfaceWords`], to which corners refer by index.
    pub planes: Buffer,
    /// The corners of all faces but the see-through ones, in ranges, and those of the see-through ones.
    pub opaque: Vec<Range<u32>>,
    /// See [`Self::opaque`].
    pub not_opaque: Vec<Range<u32>>,
    /// The corners of the faces that cast shadows: those that are neither see-through nor on billboards.
    pub casting: Vec<Range<u32>>,
    /// The planar part of each surface.
    pub parts: Vec<PlanarPart>,
    /// The rectangles of impostors.
    turning: Vec<Turning>,
    /// The see-through surfaces, in model order.
    see_through: Vec<SeeThrough>,
    /// The surfaces of the skirts, in order.
    skirts: Range<u32>,
}

/// A surface of a see-through face.
#[derive(Debug)]
struct SeeThrough {
    face: FaceId,
    /// The index of the surface.
    surface: u32,
    triangles: Vec<[u32; 3]>,
}

/// The rectangle of an impostor on the device.
#[derive(Debug)]
struct Turning {
    face: FaceId,
    /// The index of its surface.
    surface: u32,
    /// The index of its first corner.
    corner: u32,
}

impl ModelBuffers {
    /// Uploads all faces in model order, so that of faces at one depth the last is drawn last.
    pub fn new(gpu: &Gpu, model: &Model, sources: &Sources, sides: &BackSides, skirts: &Skirts) -> Self {
        let origin = origin(model, sources);
        let (mut corners, mut surfaces, mut turning) = (Vec::new(), Vec::new(), Vec::new());
        let (mut opaque, mut not_opaque, mut see_through) = (Vec::new(), Vec::new(), Vec::new());
        let (mut all_parts, mut casting) = (Vec::new(), Vec::new());
        let seen_through = sources.see_through_faces(model);
        for face in model.face_ids().filter(|face| !skirts.holds(*face)) {
            let first = corners.len() as u32;
            for (part, plane, triangles) in parts(model, face) {
                all_parts.push(part);
                let surface = surfaces.len() as u32;
                if seen_through.contains(&face) {
                    see_through.push(SeeThrough { face, surface, triangles: triangles.clone() });
                }
                if model.stands_for_impostor(face) {
                    turning.push(Turning { face, surface, corner: corners.len() as u32 });
                }
                let flags = flags(model, face, sides);
                surfaces.push(SurfaceWords { flags, ..words(model, face, &plane, origin) });
                corners.extend(corners_of(model, &triangles, origin, surface));
            }
            let ranges = if seen_through.contains(&face) { &mut not_opaque } else { &mut opaque };
            add(ranges, first..corners.len() as u32);
            if !seen_through.contains(&face) && !model.object(model.face(face).object).billboard {
                add(&mut casting, first..corners.len() as u32);
            }
        }
        let count = corners.len() as u32;
        let first_skirt = surfaces.len() as u32;
        for face in skirts.faces().map(FaceId) {
            all_parts.push(PlanarPart { face, triangle: None });
            let words = words(model, face, &model.face(face).plane, origin);
            surfaces.push(SurfaceWords { flags: FLAG_SKIRT, ..words });
        }
        let skirts = first_skirt..surfaces.len() as u32;
        // An empty model has a buffer, too, because no binding may be empty.
        if surfaces.is_empty() {
            surfaces.push(SurfaceWords::zeroed());
            corners.push(SurfaceVertex::zeroed());
        }
        Self {
            origin,
            corners: bindings::filled(
                gpu,
                "corners",
                &corners,
                BufferUsages::VERTEX | BufferUsages::COPY_DST,
            ),
            count,
            planes: bindings::filled(
                gpu,
                "surfaces",
                &surfaces,
                BufferUsages::STORAGE | BufferUsages::COPY_DST,
            ),
            opaque,
            not_opaque,
            casting,
            parts: all_parts,
            turning,
            see_through,
            skirts,
        }
    }

    /// Returns whether a face is drawn after all others, because one sees through it in places.
    pub fn is_see_through(&self, face: FaceId) -> bool {
        self.see_through.binary_search_by_key(&face, |surface| surface.face).is_ok()
    }

    /// Returns the corners of the see-through faces that a view may show, as triangles from back to front; `is_in_view` tells
    /// which these are.
    pub fn back_to_front(
        &self,
        model: &Model,
        eye: DVec3,
        is_in_view: impl Fn(FaceId) -> bool,
    ) -> Vec<SurfaceVertex> {
        let seen = self.see_through.iter().filter(|surface| is_in_view(surface.face));
        let pieces = seen.flat_map(|SeeThrough { face, surface, triangles }| {
            let piece = |triangle: &[u32; 3]| {
                let corners = triangle.map(|vertex| model.vertices[vertex as usize]);
                let face = model.face(*face);
                let plane = if face.planar { face.plane } else { fit_plane(&corners)? };
                Some(Piece { surface: *surface, plane, corners: corners.to_vec() })
            };
            triangles.iter().filter_map(piece)
        });
        let ordered = back_to_front(pieces.collect(), eye);
        let corner = |point: DVec3, surface: u32| {
            let (high, low) = split(point - self.origin);
            SurfaceVertex { high, low, surface }
        };
        let corners = |piece: &Piece| {
            let surface = piece.surface;
            piece.triangles().into_iter().flatten().map(move |point| corner(point, surface))
        };
        ordered.iter().flat_map(corners).collect()
    }

    /// Returns the corners of these skirts, as triangles.
    pub fn corners_of_skirts(&self, model: &Model, skirts: &Skirts, drawn: &[FaceId]) -> Vec<SurfaceVertex> {
        let corners = |face: &FaceId| {
            let surface = self.skirts.start + (face.0 - skirts.faces().start);
            corners_of(model, model.face_triangles(*face), self.origin, surface)
        };
        drawn.iter().flat_map(corners).collect()
    }

    /// Takes over the rectangles of impostors from the model, which has turned ([`Model::turn_towards`]).
    pub fn turn(&self, gpu: &Gpu, model: &Model) {
        for &Turning { face, surface, corner } in &self.turning {
            let triangles = model.face_triangles(face);
            let corners: Vec<SurfaceVertex> = corners_of(model, triangles, self.origin, surface).collect();
            let at = u64::from(corner) * size_of::<SurfaceVertex>() as u64;
            gpu.queue.write_buffer(&self.corners, at, bytemuck::cast_slice(&corners));
            // Impostors have no back sides.
            let plane = model.face(face).plane;
            let flags = FLAG_BILLBOARD | FLAG_IMPOSTOR;
            let words = SurfaceWords { flags, ..words(model, face, &plane, self.origin) };
            let at = u64::from(surface) * size_of::<SurfaceWords>() as u64;
            gpu.queue.write_buffer(&self.planes, at, bytemuck::bytes_of(&words));
        }
    }

    /// Returns the world point that positions are relative to.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }
}

/// Adds a range to ranges, to the last one where it continues it.
fn add(ranges: &mut Vec<Range<u32>>, range: Range<u32>) {
    match ranges.last_mut() {
        Some(last) if last.end == range.start => last.end = range.end,
        _ => ranges.push(range),
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
fn parts(model: &Model, face: FaceId) -> Vec<(PlanarPart, Plane, Vec<[u32; 3]>)> {
    let triangles = model.face_triangles(face);
    if model.face(face).planar {
        return vec![(PlanarPart { face, triangle: None }, model.face(face).plane, triangles.to_vec())];
    }
    let plane_of = |t: &[u32; 3]| fit_plane(&t.map(|v| model.vertices[v as usize]));
    let part = |(triangle, t): (u32, &[u32; 3])| {
        Some((PlanarPart { face, triangle: Some(triangle) }, plane_of(t)?, vec![*t]))
    };
    (0..).zip(triangles).filter_map(part).collect()
}

/// Returns the corners of triangles of a surface.
fn corners_of(
    model: &Model,
    triangles: &[[u32; 3]],
    origin: DVec3,
    surface: u32,
) -> impl Iterator<Item = SurfaceVertex> {
    triangles.iter().flatten().map(move |&vertex| {
        let (high, low) = split(model.vertices[vertex as usize] - origin);
        SurfaceVertex { high, low, surface }
    })
}

const FLAG_BILLBOARD: u32 = 1;
const FLAG_IMPOSTOR: u32 = 8;
const FLAG_SKIRT: u32 = 16;

/// Returns the flags of a surface that do not depend on the view, as the shader names them.
fn flags(model: &Model, face: FaceId, sides: &BackSides) -> u32 {
    let billboard = model.object(model.face(face).object).billboard;
    let [front, back] = [Side::Front, Side::Back].map(|side| sides.is_back(face, side));
    let impostor = if model.impostor(face).is_some() { FLAG_IMPOSTOR } else { 0 };
    (if billboard { FLAG_BILLBOARD } else { 0 }) | u32::from(front) << 1 | u32::from(back) << 2 | impostor
}

fn words(model: &Model, face: FaceId, plane: &Plane, origin: DVec3) -> SurfaceWords {
    let impostor = model.impostor(face);
    let (foot_high, foot_low) = impostor.map_or_else(Default::default, |it| split(it.foot - origin));
    let distance = plane.normal.dot(plane.point - origin);
    let distance_high = distance as f32;
    SurfaceWords {
        normal: plane.normal.as_vec3().to_array(),
        distance_high,
        distance_low: (distance - f64::from(distance_high)) as f32,
        face: face.0,
        flags: 0,
        half_width: impostor.map_or(0.0, |it| it.half_width as f32),
        foot_high,
        pad0: 0.0,
        foot_low,
        pad1: 0.0,
        axis: impostor.map_or([0.0; 3], |it| it.axis.as_vec3().to_array()),
        pad2: 0.0,
    }
}

/// Splits a point into the sum of two f32 vectors.
pub fn split(p: DVec3) -> ([f32; 3], [f32; 3]) {
    let high = p.as_vec3();
    (high.to_array(), (p - high.as_dvec3()).as_vec3().to_array())
}
