//! The first line of the file: what it says of the layered depth image, and where its chunks are.

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

use super::packing::Packing;
use crate::{Ldi, LdiReport, LdiSurface};
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};
use quadratura_base::scene::FaceIndex;

/// What `format` says.
pub const FORMAT: &str = "quadratura-ldi";

/// The version that this program writes, and the only one that it reads.
pub const VERSION: u32 = 1;

/// The number of rows of a chunk; the last one of a level may have fewer.
pub const CHUNK_ROWS: u32 = 64;

/// The chunks start at a multiple of this many bytes, and so does each of their streams.
pub(super) const ALIGNMENT: usize = 8;

/// The streams of a chunk, in their order.
pub const STREAMS: [&str; 5] = ["counts", "inverse_depths", "colours", "surfaces", "splats"];

/// The first line of the file of a layered depth image. `docs/formats.md` describes it for other programs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LdiHeader {
    /// The name of the format, [`FORMAT`].
    pub format: String,
    /// The version of the format, [`VERSION`].
    pub version: u32,
    /// The hash of everything that it was made of; empty for depth images from elsewhere.
    pub inputs: String,
    /// What it was made from: the name of an [`crate::LdiKind`].
    pub kind: String,
    /// The reference camera.
    pub camera: LdiCamera,
    /// Where the photo is in the frame, in pixels; left out where the camera is no photo's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub photo_rect: Option<PixelRect>,
    /// Natural logarithms of the exposure of its colours over the common exposure: R, G, B.
    pub gain: [f64; 3],
    /// The surfaces that depth pixels name: number i is `surfaces[i - 1]`.
    pub surfaces: Vec<SurfaceEntry>,
    /// The names of the photos or files that it was made from.
    pub sources: Vec<String>,
    /// The levels of resolution, the frame's first.
    pub levels: Vec<LevelEntry>,
    /// The names of a chunk's streams, in their order: [`STREAMS`].
    pub streams: Vec<String>,
    /// How the streams are packed.
    pub packing: Packing,
    /// What its making reported.
    pub report: ReportEntry,
}

/// The reference camera as in `stack.json`, with the size of the frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(non_snake_case)]
pub struct LdiCamera {
    /// The 3 x 3 camera matrix in pixels, by rows.
    pub K: [[f64; 3]; 3],
    /// The 3 x 3 rotation matrix, world to camera, by rows.
    pub R: [[f64; 3]; 3],
    /// The translation, world to camera, in world units.
    pub t: [f64; 3],
    /// The width of the frame in pixels.
    pub width: u32,
    /// The height of the frame in pixels.
    pub height: u32,
}

/// A surface of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SurfaceEntry {
    /// See [`LdiSurface::nu`].
    pub nu: [f64; 3],
    /// The unique name of the object.
    pub object: String,
    /// The face's index within the object; left out for the surroundings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub face: Option<FaceIndex>,
}

/// A level of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LevelEntry {
    /// The width in pixels.
    pub width: u32,
    /// The height in pixels.
    pub height: u32,
    /// The number of depth pixels.
    pub depth_pixels: u64,
    /// The chunks from the top.
    pub chunks: Vec<ChunkEntry>,
}

/// A chunk of the file: [`CHUNK_ROWS`] rows of a level.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChunkEntry {
    /// Its size in the file; a multiple of 8.
    pub bytes: u64,
    /// The number of depth pixels.
    pub depth_pixels: u64,
    /// The largest inverse depth; 0 without depth pixels.
    pub near: f32,
    /// The least inverse depth; 0 without depth pixels.
    pub far: f32,
    /// The first [`super::HASH_DIGITS`] hexadecimal digits of the BLAKE3 of its bytes.
    pub hash: String,
}

/// The report with the size of the chunks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ReportEntry {
    /// What the making reported.
    #[serde(flatten)]
    pub report: LdiReport,
    /// The size of all chunks in bytes.
    pub bytes: u64,
}

impl LdiHeader {
    /// Makes the first line of a layered depth image whose levels have these chunks.
    pub(super) fn of(ldi: &Ldi, packing: Packing, chunks: Vec<Vec<ChunkEntry>>) -> Self {
        let bytes = chunks.iter().flatten().map(|chunk| chunk.bytes).sum();
        let level = |(level, chunks): (&crate::ResolutionLevel, Vec<ChunkEntry>)| LevelEntry {
            width: level.camera.width,
            height: level.camera.height,
            depth_pixels: level.len() as u64,
            chunks,
        };
        Self {
            format: FORMAT.to_owned(),
            version: VERSION,
            inputs: ldi.inputs.clone(),
            kind: ldi.kind.name().to_owned(),
            camera: LdiCamera::of(&ldi.camera, &ldi.pose),
            photo_rect: ldi.photo_rect,
            gain: ldi.gain,
            surfaces: ldi.surfaces.iter().map(SurfaceEntry::of).collect(),
            sources: ldi.sources.clone(),
            levels: ldi.levels.iter().zip(chunks).map(level).collect(),
            streams: STREAMS.map(str::to_owned).to_vec(),
            packing,
            report: ReportEntry { report: ldi.report.clone(), bytes },
        }
    }

    /// Returns the size of all chunks in bytes; `None` where that is no number of 64 bits.
    pub(super) fn chunk_bytes(&self) -> Option<u64> {
        let chunks = self.levels.iter().flat_map(|level| &level.chunks);
        chunks.map(|chunk| chunk.bytes).try_fold(0u64, u64::checked_add)
    }

    /// Returns the surfaces as they are in memory.
    pub(super) fn ldi_surfaces(&self) -> Vec<LdiSurface> {
        self.surfaces.iter().map(SurfaceEntry::surface).collect()
    }
}

impl LevelEntry {
    /// Returns the number of rows of chunk `index`.
    pub(super) fn rows_of(&self, index: usize) -> u32 {
        self.height.saturating_sub(index as u32 * CHUNK_ROWS).min(CHUNK_ROWS)
    }
}

impl SurfaceEntry {
    /// Makes the entry of a surface.
    pub(crate) fn of(surface: &LdiSurface) -> Self {
        Self { nu: surface.nu.to_array(), object: surface.object.clone(), face: surface.face }
    }

    /// Returns the surface as it is in memory.
    pub(crate) fn surface(&self) -> LdiSurface {
        LdiSurface { nu: DVec3::from(self.nu), object: self.object.clone(), face: self.face }
    }
}

impl LdiCamera {
    /// Makes the camera of its parts.
    pub fn of(camera: &Pinhole, pose: &Pose) -> Self {
        let Pinhole { width, height, fx, fy, cx, cy } = *camera;
        Self {
            K: [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]],
            R: pose.rotation.transpose().to_cols_array_2d(),
            t: pose.translation.to_array(),
            width,
            height,
        }
    }

    /// Returns the reference camera of an image.
    pub fn of_ldi(ldi: &Ldi) -> Self {
        Self::of(&ldi.camera, &ldi.pose)
    }

    /// Returns the camera without its pose.
    pub fn pinhole(&self) -> Pinhole {
        let [[fx, _, cx], [_, fy, cy], _] = self.K;
        Pinhole { width: self.width, height: self.height, fx, fy, cx, cy }
    }

    /// Returns the camera's pose, world to camera.
    pub fn pose(&self) -> Pose {
        Pose { rotation: DMat3::from_cols_array_2d(&self.R).transpose(), translation: DVec3::from(self.t) }
    }
}
