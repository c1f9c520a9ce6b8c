//! Segments: connected parts of a layered depth image as textured triangle meshes, for programs that draw triangles.
//!
//! A segment holds at most one depth pixel of each ray ([`join`]). It is covered by square cells, in which inverse depth is
//! nearly affine ([`cells`]); the corners are shared, so that a segment has no cracks ([`mesh`]). Its colours lie in atlases
//! ([`atlas`], `paint`), whose opacity cuts the rims. Vertices are homogeneous, (x, y, 1, d) in the frame: the division that
//! brings them to the picture is also the one that textures need, so pictures are exact wherever d is affine, and what is
//! infinitely far (d = 0) is drawn where it is.

pub mod atlas;
pub mod cells;
mod check;
pub mod join;
pub mod mesh;
mod paint;
pub mod reach;
#[cfg(test)]
mod tests;

use glam::DVec2;

pub use self::atlas::{Atlas, BORDER};
use self::cells::CellLimits;
pub use self::mesh::{TexturedPart, Vertex};
use super::layout::Ldi;
use quadratura_base::error::Result;
use quadratura_base::task::Task;

/// The side of the largest cells, in pixels, and of the tiles in which depth pixels are collected.
pub const TILE: u32 = 64;
/// The side of the smallest cells, in pixels. Corners of cells are at multiples of it.
pub const SMALLEST_CELL: u32 = 2;

/// The options of [`segments`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SegmentOptions {
    /// The difference of the logarithms of inverse depths up to which neighbours belong together.
    pub epsilon: f64,
    /// The largest error of inverse depth in a cell, in pixels of parallax for a step of half the reach ([`reach`]).
    pub parallax: f64,
    /// The number of triangles above which cells become coarser.
    pub triangles: usize,
    /// The largest error of a texture that is not divided per pixel, in pixels; `None` where it is divided.
    pub undivided: Option<f64>,
}

impl Default for SegmentOptions {
    fn default() -> Self {
        // The tolerance of merging; half a pixel is not seen; twice the budget of triangles that Seurat had in 2018, which phones
        // draw by now.
        Self { epsilon: 0.01, parallax: 0.5, triangles: 144_000, undivided: None }
    }
}

/// A layered depth image as textured meshes.
#[derive(Debug, Clone, PartialEq)]
pub struct Segments {
    /// The number of segments.
    pub count: u32,
    /// The parts of the segments, each with its place in an atlas; those of one segment follow each other.
    pub parts: Vec<TexturedPart>,
    /// The colours.
    pub atlases: Vec<Atlas>,
    /// The reach in world units: see [`reach`].
    pub reach: f64,
    /// The largest error of inverse depth in a cell that was allowed, in pixels of parallax for a step of half the reach.
    pub parallax: f64,
}

impl Segments {
    /// Returns the number of triangles.
    pub fn triangles(&self) -> usize {
        self.parts.iter().map(|part| part.triangles.len()).sum()
    }

    /// Returns the number of vertices.
    pub fn vertices(&self) -> usize {
        self.parts.iter().map(|part| part.vertices.len()).sum()
    }

    /// Returns a vertex's position in its atlas, in texels.
    pub fn texel(part: &TexturedPart, vertex: &Vertex) -> DVec2 {
        let along = |i: usize, at: i32| f64::from(at - part.origin[i] + part.at[i] as i32);
        DVec2::new(along(0, vertex.x), along(1, vertex.y))
    }
}

/// Makes the segments of the first level of a layered depth image. The same image gives the same segments, whatever the number
/// of threads. Cells are made coarser until there are no more triangles than asked for, or until all have [`TILE`] pixels.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub fn segments(ldi: &Ldi, options: &SegmentOptions, task: &Task) -> Result<Segments> {
    let level = &ldi.levels[0];
    let labels = task.timed("join", || join::label(level, &ldi.surfaces, options.epsilon, task))?;
    let patches = task.timed("collect", || cells::patches(ldi, &labels, task))?;
    let reach = reach::reach(ldi);
    // Sideways steps move points the most; the focal length is that of the wider spread axis.
    let pixels_per_depth = level.camera.fx.max(level.camera.fy) * reach / 2.0;
    let mut parallax = options.parallax;
    let mut last = usize::MAX;
    loop {
        task.check_cancelled()?;
        // Both errors grow alike.
        let undivided = options.undivided.map(|most| most * parallax / options.parallax);
        let limits = CellLimits { error: parallax / pixels_per_depth, undivided };
        let leaves = cells::count_leaves(&patches, &limits);
        let coarsest =
            leaves <= cells::count_leaves(&patches, &CellLimits { error: f64::INFINITY, undivided: None });
        // A cell has two triangles or more; making the mesh tells the number.
        if 2 * leaves <= options.triangles || coarsest {
            let meshes = task.timed("mesh", || mesh::meshes(level, &patches, &limits, task))?;
            let triangles: usize = meshes.iter().map(mesh::SegmentMesh::triangles).sum();
            // Cells that keep layers apart stay, whatever the error that is allowed.
            if triangles <= options.triangles || (coarsest && triangles >= last) {
                let (parts, atlases) =
                    task.timed("atlas", || paint::painted(level, &patches, meshes, task))?;
                return Ok(Segments { count: labels.count, parts, atlases, reach, parallax });
            }
            last = triangles;
        }
        parallax *= std::f64::consts::SQRT_2;
    }
}
