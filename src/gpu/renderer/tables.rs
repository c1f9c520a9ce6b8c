//! The tables of a view: the frame, the photos relative to its viewpoint, the cells and their candidates
//! (`shaders/project.wgsl`).

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};
use wgpu::BufferUsages;

use super::frame::CameraUniform;
use super::sky::SkyFactors;
use super::table::GrowingBuffer;
use crate::device::Gpu;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::{FaceId, Model, PhotoId};
use quadratura_projection::cells::Cells;
use quadratura_projection::exposure::{LightGroups, SurfaceFactors, ViewExposure};
use quadratura_projection::frustum::uv_from_rebased;
use quadratura_projection::sources::Projector;
use quadratura_projection::tiles::TextureShape;
use quadratura_projection::{Domain, Server, Sources};
use quadratura_view::Shot;
use quadratura_view::optics::Optics;
use quadratura_view::optics::squared_radius;
use quadratura_view::weights::BORDER_SHARE;

/// A photo in the layout of the shader (`Photo`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct PhotoWords {
    pub row_x: [f32; 4],
    pub row_y: [f32; 4],
    pub row_z: [f32; 4],
    pub center: [f32; 3],
    pub density: f32,
    pub size: [f32; 2],
    pub per_border: f32,
    pub offset: f32,
    pub gain: [f32; 3],
    pub left: f32,
    pub axis: [f32; 2],
    pub falloff: [f32; 2],
    pub leaning: f32,
    pub group: u32,
    pub sky: u32,
    pub sky_share: f32,
}

/// The cells of a face in the layout of the shader (`FaceCells`), which documents the fields.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct FaceCellsWords {
    pub corner: u32,
    pub size: u32,
    pub first: u32,
    pub hidden: u32,
}

/// The data from which the tables are written.
pub struct TableData<'a> {
    /// The view.
    pub shot: &'a Shot,
    /// The cells of the view.
    pub cells: &'a Cells,
    /// The exposure of the view.
    pub exposure: &'a ViewExposure,
    /// The optics of each photo, undone before the factors are applied.
    pub optics: &'a [Optics],
    /// The photos' groups of light.
    pub groups: &'a LightGroups,
    /// The factors that bring photos' surroundings to one sky.
    pub sky: &'a SkyFactors,
    /// The world point that positions are relative to.
    pub origin: DVec3,
}

/// The tables of a view on the device.
#[derive(Debug)]
pub struct Tables {
    /// The uniform of the view.
    pub frame: GrowingBuffer,
    /// The photos, as [`PhotoWords`].
    pub photos: GrowingBuffer,
    /// The cells of each face, as [`FaceCellsWords`].
    pub face_cells: GrowingBuffer,
    /// The index at which each cell's candidates begin.
    pub cells: GrowingBuffer,
    /// The candidates with their half planes.
    pub candidates: GrowingBuffer,
    faces: usize,
}

impl Tables {
    /// Creates the tables for a model and its photos.
    pub fn new(gpu: &Gpu, model: &Model, sources: &Sources) -> Self {
        let mut photos = GrowingBuffer::new(gpu, "photos", BufferUsages::UNIFORM | BufferUsages::STORAGE);
        photos.write(gpu, &vec![PhotoWords::zeroed(); sources.projectors().max(1)]);
        Self {
            frame: GrowingBuffer::new(gpu, "frame", BufferUsages::UNIFORM | BufferUsages::STORAGE),
            photos,
            face_cells: GrowingBuffer::new(gpu, "cells of faces", BufferUsages::STORAGE),
            cells: GrowingBuffer::new(gpu, "cells", BufferUsages::STORAGE),
            candidates: GrowingBuffer::new(gpu, "candidates", BufferUsages::STORAGE),
            faces: model.faces.len(),
        }
    }

    /// Writes all tables for a view.
    pub fn write(&mut self, gpu: &Gpu, sources: &Sources, content: &TableData) {
        let TableData { shot, cells, exposure, optics, groups, sky, origin } = *content;
        let words = |id: PhotoId| {
            let gain = exposure.factor(id).map(|factor| factor as f32);
            // The dome was made without optics, and is of no group.
            let optics = optics.get(id.index()).copied().unwrap_or_default();
            PhotoWords {
                leaning: exposure.leaning_of(id) as f32,
                group: groups.of(id) as u32,
                sky: sky.place(id),
                left: exposure.surroundings.left(id) as f32,
                sky_share: if sky.holds(id) { exposure.surroundings.share(id) as f32 } else { 0.0 },
                ..photo_words(sources.photo(id), gain, &optics, shot.reference())
            }
        };
        let photos: Vec<PhotoWords> = PhotoId::all(sources.projectors()).map(words).collect();
        if !photos.is_empty() {
            self.photos.write(gpu, &photos);
        }
        self.face_cells.write(gpu, &self.face_words(shot, cells));
        let (ranges, mut candidates) = candidate_words(sources, cells);
        let frame = CameraUniform {
            light_first: candidates.len() as u32,
            light_groups: exposure.surfaces.count() as u32,
            of_common: exposure.of_common.map(|factor| factor as f32),
            of_sky: exposure.surroundings.of_sky.map(|factor| factor as f32),
            ..CameraUniform::new(shot, &exposure.lens, origin, cells, sources)
        };
        self.frame.write(gpu, &[frame]);
        push_light(&mut candidates, &exposure.surfaces, self.faces);
        self.cells.write(gpu, &ranges);
        self.candidates.write(gpu, &candidates);
    }

    fn face_words(&self, shot: &Shot, cells: &Cells) -> Vec<FaceCellsWords> {
        let pack = |[x, y]: [u32; 2]| x | y << 16;
        let mut words = vec![FaceCellsWords::zeroed(); self.faces.max(1)];
        for face in &cells.faces {
            words[face.face.0 as usize] = FaceCellsWords {
                corner: pack(face.corner),
                size: pack(face.size),
                first: face.first,
                hidden: 0,
            };
        }
        for face in shot.hidden.iter().filter(|face| (face.0 as usize) < self.faces) {
            words[face.0 as usize].hidden = 1;
        }
        words
    }
}

fn photo_words(photo: &Projector, gain: [f32; 3], optics: &Optics, viewpoint: DVec3) -> PhotoWords {
    let camera = &photo.camera;
    // With a rectangle of one pixel, u and v are photo pixels.
    let pixel = PixelRect::of_size(1, 1);
    let [row_x, row_y, row_z] =
        uv_from_rebased(camera, &photo.pose, pixel, viewpoint).map(|row| row.map(|v| v as f32));
    let center = (photo.pose.center_in_world() - viewpoint).as_vec3();
    let (width, height) = (f64::from(camera.width), f64::from(camera.height));
    let (falloff, per_px2) = (optics.falloff, squared_radius(camera, DVec2::new(camera.cx + 1.0, camera.cy)));
    PhotoWords {
        row_x,
        row_y,
        row_z,
        center: center.to_array(),
        density: (camera.fx * camera.fy) as f32,
        size: [width as f32, height as f32],
        per_border: (1.0 / (BORDER_SHARE * width.min(height))) as f32,
        offset: optics.offset as f32,
        gain,
        left: 0.0,
        axis: [camera.cx as f32, camera.cy as f32],
        falloff: [(falloff[0] * per_px2) as f32, (falloff[1] * per_px2 * per_px2) as f32],
        leaning: 1.0,
        group: 0,
        sky: 0,
        sky_share: 0.0,
    }
}

/// Returns the index at which each cell's words begin, and the words: candidates, each followed by its half
/// planes.
fn candidate_words(sources: &Sources, cells: &Cells) -> (Vec<u32>, Vec<[u32; 4]>) {
    let mut begins = Vec::with_capacity(cells.ranges.len() + 1);
    let mut words = Vec::with_capacity(cells.candidates.len() + 1);
    for range in &cells.ranges {
        begins.push(words.len() as u32);
        for candidate in &cells.candidates[range.start as usize..range.end as usize] {
            let server = &sources.servers[candidate.server as usize];
            push_words(&mut words, sources, server, candidate.least);
        }
    }
    begins.push(words.len() as u32);
    // No binding may be empty.
    words.push([0; 4]);
    (begins, words)
}

/// Adds the factors of groups of light on all faces.
fn push_light(words: &mut Vec<[u32; 4]>, surfaces: &SurfaceFactors, faces: usize) {
    for face in (0..faces).filter(|_| surfaces.count() > 0) {
        let factors = surfaces.of_groups(FaceId(face as u32));
        words.extend((0..surfaces.count()).map(|group| {
            let [r, g, b] =
                factors.get(group).copied().unwrap_or([1.0; 3]).map(|factor| (factor as f32).to_bits());
            [r, g, b, 0]
        }));
    }
}

fn push_words(words: &mut Vec<[u32; 4]>, sources: &Sources, server: &Server, least: f64) {
    let rect = sources.layer_texture(server.layer_texture).rect;
    let sides = match &server.domain {
        Domain::Whole => &[],
        Domain::Inside(sides) => &sides[..],
    };
    let logs = TextureShape::from_rect(rect).log;
    let packed = server.photo.0
        | logs[0] << 16
        | logs[1] << 20
        | u32::from(server.back) << 24
        | (sides.len() as u32) << 25
        | u32::from(server.pinned) << 31;
    // Rounded down, so that it remains a lower bound.
    let least = (least as f32).next_down();
    let corner = (rect.x as u32 & 0xffff) | (rect.y as u32) << 16;
    words.push([least.to_bits(), packed, server.layer_texture.0, corner]);
    for side in sides {
        let half_plane = [side.normal.x as f32, side.normal.y as f32, side.offset as f32, 0.0];
        words.push(half_plane.map(f32::to_bits));
    }
}
