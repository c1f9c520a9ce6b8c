//! The cells of a segment become a mesh without cracks.
//!
//! Corners of cells are shared: each has one inverse depth, the mean of what the cells around it say. A cell whose neighbour is
//! finer has that neighbour's corners on its sides, and its triangles go through them, so no gap opens between cells of
//! different size. Cells that are wrong then are divided further (`check`). Outwards, sides are moved by a pixel, over which
//! the atlas's opacity fades.

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::cells::{CellLimits, Node, SegmentPatch};
use super::check::Exceptions;
use super::{SMALLEST_CELL, TILE};
use crate::layout::ResolutionLevel;
use quadratura_base::error::Result;
use quadratura_base::task::Task;

/// A corner of triangles, homogeneous: (x, y, 1, d).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertex {
    /// The column in the frame, in pixels from its left side; up to a pixel outside.
    pub x: i32,
    /// The row in the frame, in pixels from its upper side; up to a pixel outside.
    pub y: i32,
    /// Inverse depth in 1/world unit.
    pub inverse_depth: f32,
}

/// A part of a segment whose texels are a rectangle of an atlas.
#[derive(Debug, Clone, PartialEq)]
pub struct TexturedPart {
    /// The number of the segment.
    pub segment: u32,
    /// The atlas.
    pub atlas: usize,
    /// The position in the frame of the rectangle's upper left texel, in pixels.
    pub origin: [i32; 2],
    /// The upper left texel in the atlas.
    pub at: [u32; 2],
    /// Width and height in texels.
    pub size: [u32; 2],
    /// The corners of the triangles.
    pub vertices: Vec<Vertex>,
    /// Triangles, clockwise as the reference camera sees them, y down.
    pub triangles: Vec<[u16; 3]>,
}

/// The mesh of a segment, in parts of a rectangle of tiles each.
#[derive(Debug, Clone, PartialEq)]
pub struct SegmentMesh {
    /// The parts.
    pub parts: Vec<MeshPart>,
}

/// A part of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshPart {
    /// The number of the segment.
    pub segment: u32,
    /// The rectangle that its cells cover, in pixels of the frame: left, top, right, bottom.
    pub bounds: [i32; 4],
    /// The corners.
    pub vertices: Vec<Vertex>,
    /// The triangles.
    pub triangles: Vec<[u16; 3]>,
    /// The places of its patches.
    pub patches: Vec<usize>,
}

impl SegmentMesh {
    /// Returns the number of triangles.
    pub fn triangles(&self) -> usize {
        self.parts.iter().map(|part| part.triangles.len()).sum()
    }
}

/// Makes the meshes of all segments, in their order.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub fn meshes(
    level: &ResolutionLevel,
    patches: &[SegmentPatch],
    limits: &CellLimits,
    task: &Task,
) -> Result<Vec<SegmentMesh>> {
    let mut first = 0;
    let groups: Vec<(usize, &[SegmentPatch])> = patches
        .chunk_by(|a, b| a.segment == b.segment)
        .map(|group| {
            first += group.len();
            (first - group.len(), group)
        })
        .collect();
    let of_segment = |(first, group): &(usize, &[SegmentPatch])| {
        let mut exceptions = Exceptions::default();
        loop {
            task.check_cancelled()?;
            let mesher = Mesher::new(group, limits, &exceptions);
            if !exceptions.add(&mesher.poor_cells(level, limits)) {
                return Ok(mesher.mesh(*first));
            }
        }
    };
    groups.par_iter().map(of_segment).collect()
}

/// The side of the largest part in tiles: also where each of the smallest cells has four corners of its own, a part has fewer
/// than 16 bits count.
const LARGEST_PART: u32 = 3;
/// A tile of which a segment has less than this share is a part of its own, so that parts are mostly full.
const MOSTLY: usize = (TILE * TILE / 2) as usize;

/// Divides the tiles of a segment into rectangles of mostly full ones, and single ones; returns the places of their patches.
fn rectangles(group: &[SegmentPatch]) -> Vec<Vec<usize>> {
    let mut places: FxHashMap<[u32; 2], usize> = group.iter().map(|patch| patch.tile).zip(0..).collect();
    let mut out = Vec::new();
    for (place, patch) in group.iter().enumerate() {
        if places.remove(&patch.tile).is_none() {
            continue;
        }
        let mut part = vec![place];
        let [left, top] = patch.tile;
        let full = |places: &FxHashMap<[u32; 2], usize>, tile: [u32; 2]| {
            places.get(&tile).copied().filter(|&place| group[place].pixels.len() >= MOSTLY)
        };
        if patch.pixels.len() >= MOSTLY {
            let mut right = left + 1;
            while right < left + LARGEST_PART
                && let Some(place) = full(&places, [right, top])
            {
                places.remove(&[right, top]);
                part.push(place);
                right += 1;
            }
            for y in top + 1..top + LARGEST_PART {
                let row: Option<Vec<usize>> = (left..right).map(|x| full(&places, [x, y])).collect();
                let Some(row) = row else { break };
                for x in left..right {
                    places.remove(&[x, y]);
                }
                part.extend(row);
            }
        }
        out.push(part);
    }
    out
}

/// A cell in the frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct MeshCell<'a> {
    x: i32,
    y: i32,
    side: i32,
    pub node: &'a Node,
    /// The places of its patch in the group and of its node in the patch.
    pub place: (usize, u32),
    /// Whether it shares no corners with others.
    is_alone: bool,
}

impl MeshCell<'_> {
    /// Its corners, clockwise from the upper left.
    fn corners(&self) -> [[i32; 2]; 4] {
        let (right, bottom) = (self.x + self.side, self.y + self.side);
        [[self.x, self.y], [right, self.y], [right, bottom], [self.x, bottom]]
    }

    /// Returns what it says of the inverse depth at a corner that was moved.
    fn inverse_depth(&self, at: [i32; 2], moved: [i32; 2]) -> f64 {
        let depth = self.node.inverse_depth(moved[0], moved[1]);
        // Where what is hidden ends at what hides it, it must not come before it beyond the end.
        if self.node.hidden && moved != at { depth.min(self.node.range[1].into()) } else { depth }
    }
}

/// What the cells around a corner say.
#[derive(Debug, Clone, Copy, Default)]
struct SharedCorner {
    /// Its place, which may be moved outwards.
    moved: [i32; 2],
    weight: f64,
    sum: f64,
}

/// A segment whose mesh is made.
pub(super) struct Mesher<'a> {
    pub group: &'a [SegmentPatch],
    /// The cells of each patch.
    pub cells: Vec<Vec<MeshCell<'a>>>,
    corners: FxHashMap<[i32; 2], SharedCorner>,
    /// By tile, which squares of the smallest cells are covered, a word a row.
    covered: FxHashMap<[i32; 2], [u32; (TILE / SMALLEST_CELL) as usize]>,
}

const STEP: i32 = SMALLEST_CELL as i32;

impl<'a> Mesher<'a> {
    fn new(group: &'a [SegmentPatch], limits: &CellLimits, exceptions: &Exceptions) -> Self {
        let mut mesher =
            Self { group, cells: Vec::new(), corners: FxHashMap::default(), covered: FxHashMap::default() };
        for (i, patch) in group.iter().enumerate() {
            let [left, top] = patch.tile.map(|at| (at * TILE) as i32);
            let mut cells = Vec::new();
            patch.leaves(limits, &|number| exceptions.is_divided((i, number)), &mut |number, node| {
                let [x, y] = node.at.map(i32::from);
                let (place, side) = ((i, number), node.side.into());
                let is_alone = exceptions.is_alone(place);
                cells.push(MeshCell { x: left + x, y: top + y, side, node, place, is_alone });
            });
            for cell in &cells {
                mesher.cover(cell);
                for corner in cell.corners() {
                    mesher.corners.entry(corner).or_default();
                }
            }
            mesher.cells.push(cells);
        }
        let mut corners = std::mem::take(&mut mesher.corners);
        corners.iter_mut().for_each(|(at, corner)| corner.moved = mesher.outwards(*at));
        for cell in mesher.cells.iter().flatten().filter(|cell| !cell.is_alone) {
            // A fine cell knows the place better than a large one, and a full one better than one of few depth pixels.
            let weight = f64::from(cell.node.pixels) / f64::from(cell.side).powi(4);
            for at in sides(cell) {
                if let Some(corner) = corners.get_mut(&at) {
                    corner.weight += weight;
                    corner.sum += weight * cell.inverse_depth(at, corner.moved);
                }
            }
        }
        mesher.corners = corners;
        mesher
    }

    fn cover(&mut self, cell: &MeshCell) {
        let tile = [cell.x, cell.y].map(|at| at.div_euclid(TILE as i32));
        let rows = self.covered.entry(tile).or_default();
        let [x, y, side] =
            [cell.x - tile[0] * TILE as i32, cell.y - tile[1] * TILE as i32, cell.side].map(|at| at / STEP);
        let bits = (((1u64 << side) - 1) << x) as u32;
        rows[y as usize..(y + side) as usize].iter_mut().for_each(|row| *row |= bits);
    }

    fn is_covered(&self, x: i32, y: i32) -> bool {
        let tile = [x, y].map(|at| at.div_euclid(TILE as i32));
        let within = |at: i32| (at.rem_euclid(TILE as i32) / STEP) as usize;
        self.covered.get(&tile).is_some_and(|rows| rows[within(y)] >> within(x) & 1 == 1)
    }

    /// Returns where a corner is: moved by a pixel from the cells where there is nothing on the other side.
    fn outwards(&self, [x, y]: [i32; 2]) -> [i32; 2] {
        let (mut along, mut held) = ([0, 0], 0);
        for (dx, dy) in [(-1, -1), (1, -1), (-1, 1), (1, 1)] {
            if self.is_covered(x + dx.min(0), y + dy.min(0)) {
                held += 1;
                along = [along[0] - dx, along[1] - dy];
            }
        }
        if held == 4 { [x, y] } else { [x + along[0].signum(), y + along[1].signum()] }
    }

    fn mesh(&self, first: usize) -> SegmentMesh {
        let part = |places: Vec<usize>| {
            let mut part = MeshPartBuilder {
                mesher: self,
                numbers: FxHashMap::default(),
                vertices: vec![],
                triangles: vec![],
            };
            let mut bounds = [i32::MAX, i32::MAX, i32::MIN, i32::MIN];
            for cell in places.iter().flat_map(|&place| &self.cells[place]) {
                let [[left, top], _, [right, bottom], _] = cell.corners();
                bounds =
                    [bounds[0].min(left), bounds[1].min(top), bounds[2].max(right), bounds[3].max(bottom)];
                part.add(cell);
            }
            let (vertices, triangles) = (part.vertices, part.triangles);
            let patches = places.iter().map(|place| first + place).collect();
            MeshPart { segment: self.group[0].segment, bounds, vertices, triangles, patches }
        };
        SegmentMesh { parts: rectangles(self.group).into_iter().map(part).collect() }
    }
}

/// Returns the places on the sides of a cell that can be corners, clockwise from the upper left one.
fn sides(cell: &MeshCell) -> impl Iterator<Item = [i32; 2]> + use<> {
    let corners = cell.corners();
    let steps = cell.side / STEP;
    (0..4).flat_map(move |side| {
        let ([x0, y0], [x1, y1]) = (corners[side], corners[(side + 1) % 4]);
        (0..steps)
            .map(move |step| [x0 + (x1 - x0).signum() * STEP * step, y0 + (y1 - y0).signum() * STEP * step])
    })
}

/// The mesh of a cell.
pub(super) struct CellMesh {
    /// The corners on its sides, clockwise from the upper left one: where each was before it was moved, and what it is.
    ring: Vec<([i32; 2], Vertex)>,
    /// A corner within it.
    centre: Option<Vertex>,
    /// The triangles by the corners' places in the ring; the one within it has the place behind the last one.
    triangles: Vec<[usize; 3]>,
}

impl CellMesh {
    /// Returns the corners of the triangles.
    pub fn triangles(&self) -> impl Iterator<Item = [Vertex; 3]> + '_ {
        let corner =
            |at: usize| self.ring.get(at).map_or_else(|| self.centre.expect("it has one"), |(_, at)| *at);
        self.triangles.iter().map(move |triangle| triangle.map(corner))
    }
}

impl Mesher<'_> {
    /// Returns the mesh of a cell.
    pub fn shape(&self, cell: &MeshCell) -> CellMesh {
        let vertex = |at: [i32; 2]| {
            let corner = self.corners.get(&at)?;
            let [x, y] = corner.moved;
            let depth =
                if cell.is_alone { cell.inverse_depth(at, corner.moved) } else { corner.sum / corner.weight };
            Some((at, Vertex { x, y, inverse_depth: depth as f32 }))
        };
        let ring: Vec<([i32; 2], Vertex)> = sides(cell).filter_map(vertex).collect();
        if ring.len() == 4 {
            let depth = |at: usize| ring[at].1.inverse_depth;
            // The diagonal that changes less follows ridges and valleys.
            let along = (depth(0) - depth(2)).abs() <= (depth(1) - depth(3)).abs();
            let triangles = if along { [[0, 1, 2], [0, 2, 3]] } else { [[0, 1, 3], [1, 2, 3]] };
            return CellMesh { ring, centre: None, triangles: triangles.to_vec() };
        }
        let (x, y) = (cell.x + cell.side / 2, cell.y + cell.side / 2);
        let centre = Vertex { x, y, inverse_depth: middle(&ring, cell, [x, y]) as f32 };
        let triangles = (0..ring.len()).map(|i| [ring.len(), i, (i + 1) % ring.len()]).collect();
        CellMesh { ring, centre: Some(centre), triangles }
    }
}

/// Returns the inverse depth in the middle of a cell: its own, moved as its corners were.
fn middle(ring: &[([i32; 2], Vertex)], cell: &MeshCell, [x, y]: [i32; 2]) -> f64 {
    let plane = cell.node.plane;
    let off = |(_, Vertex { x, y, inverse_depth }): &([i32; 2], Vertex)| {
        f64::from(*inverse_depth) - plane.dot(DVec3::new((*x).into(), (*y).into(), 1.0))
    };
    let mean = ring.iter().map(off).sum::<f64>() / ring.len() as f64;
    // Half of it: the middle is nearer to the cell's own depth pixels than its corners are.
    cell.node.inverse_depth(x, y) + 0.5 * mean
}

/// A part whose mesh is made.
struct MeshPartBuilder<'a> {
    mesher: &'a Mesher<'a>,
    numbers: FxHashMap<[i32; 2], u16>,
    vertices: Vec<Vertex>,
    triangles: Vec<[u16; 3]>,
}

impl MeshPartBuilder<'_> {
    /// Adds the triangles of a cell.
    fn add(&mut self, cell: &MeshCell) {
        let shape = self.mesher.shape(cell);
        let mut numbers: Vec<u16> = Vec::with_capacity(shape.ring.len() + 1);
        for (at, vertex) in &shape.ring {
            let number = match self.numbers.get(at).filter(|_| !cell.is_alone) {
                Some(&number) => number,
                None => self.push(*vertex),
            };
            if !cell.is_alone {
                self.numbers.insert(*at, number);
            }
            numbers.push(number);
        }
        numbers.extend(shape.centre.map(|centre| self.push(centre)));
        self.triangles.extend(shape.triangles.iter().map(|triangle| triangle.map(|at| numbers[at])));
    }

    fn push(&mut self, vertex: Vertex) -> u16 {
        self.vertices.push(vertex);
        u16::try_from(self.vertices.len() - 1).expect("a part has fewer corners than 16 bits count")
    }
}
