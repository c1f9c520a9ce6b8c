//! Square cells in which the inverse depth of a segment is nearly affine: a quadtree in each tile of the frame.

use glam::DVec3;
use rayon::prelude::*;

use super::join::SegmentLabels;
use super::{SMALLEST_CELL, TILE};
use crate::layout::{Ldi, LdiSurface, ResolutionLevel};
use quadratura_base::error::Result;
use quadratura_base::task::Task;

const SIDE: usize = TILE as usize;
/// What a grid has where a segment has no depth pixel.
const NONE: u32 = u32::MAX;
/// How much slopes are drawn to that of the surface, in squares of half a cell's side: what keeps a single row of depth pixels
/// from being turned about itself, and changes nothing where four are.
const RIDGE: f64 = 0.01;

/// The error of a cell is no more than this share of the difference to another layer, so that neither of two comes before the
/// other where it is behind: less than half, since both have one.
pub(super) const CLOSEST: f64 = 0.3;

/// The depth pixels of a segment in a tile of the frame.
#[derive(Debug, Clone, PartialEq)]
pub struct SegmentPatch {
    /// The number of the segment.
    pub segment: u32,
    /// The tile's column and row.
    pub tile: [u32; 2],
    /// The depth pixels in reading order.
    pub pixels: Vec<PatchPixel>,
    /// The cells; the first one is the whole tile.
    pub nodes: Vec<Node>,
}

/// A depth pixel in its tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PatchPixel {
    /// The column in the tile.
    pub x: u8,
    /// The row in the tile.
    pub y: u8,
    /// The index in the level.
    pub index: u32,
}

/// A cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// The left and upper side in the tile, in pixels.
    pub at: [u8; 2],
    /// The side in pixels, a power of 2.
    pub side: u8,
    /// The number of depth pixels in it.
    pub pixels: u16,
    /// The least and largest inverse depth in it.
    pub range: [f32; 2],
    /// The best affine inverse depth, of (x, y, 1) in pixels of the frame.
    pub plane: DVec3,
    /// The largest difference of a depth pixel from it.
    pub error: f64,
    /// The largest one as a share of the difference to the next layer of the ray.
    pub crowding: f64,
    /// The least difference of one of its depth pixels to the next layer of the ray.
    pub closest: f64,
    /// Whether most of its depth pixels have a nearer one on their rays.
    pub hidden: bool,
    /// Its quarters, row by row, by their places in [`SegmentPatch::nodes`]; 0 where there is no depth pixel. All are 0 in a cell
    /// without quarters.
    pub quarters: [u32; 4],
}

/// How coarse cells may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellLimits {
    /// The largest error of inverse depth.
    pub error: f64,
    /// The largest error of a texture that is not divided per pixel, in pixels.
    pub undivided: Option<f64>,
}

impl Node {
    fn is_leaf(&self, limits: &CellLimits) -> bool {
        let only_one = self.quarters.iter().filter(|&&quarter| quarter != 0).count() == 1;
        // What lies in one quarter has a cell of a quarter, so that cells are no larger than their texels.
        let fits = self.error <= limits.error && self.crowding <= CLOSEST && self.is_straight(limits);
        !only_one && fits
    }

    /// Returns whether a texture that is affine on the cell in space is nearly so in the frame. Half way along an edge between
    /// depths z1 and z2, the picture is at z1 / (z1 + z2) of it.
    fn is_straight(&self, limits: &CellLimits) -> bool {
        let [least, largest] = self.range.map(f64::from);
        let Some(most) = limits.undivided else { return true };
        let side = f64::from(self.side);
        let change = (self.plane.x.abs() + self.plane.y.abs()) * side;
        change.max(largest - least) * side / 4.0 <= most * f64::midpoint(least, largest)
    }

    /// Returns the inverse depth at a position of the frame, not far outside of what is in the cell.
    pub fn inverse_depth(&self, x: i32, y: i32) -> f64 {
        let [least, largest] = self.range.map(f64::from);
        // A plane that is continued may meet the horizon; it ends at half the least.
        self.plane.dot(DVec3::new(x.into(), y.into(), 1.0)).clamp(0.5 * least, 2.0 * largest)
    }
}

impl SegmentPatch {
    /// Visits the cells that are not divided, with their numbers, in the order of their first pixels. Cells that have quarters are
    /// divided beyond the limits where `is_divided` says so of their numbers.
    pub fn leaves<'a>(
        &'a self,
        limits: &CellLimits,
        is_divided: &impl Fn(u32) -> bool,
        visit: &mut impl FnMut(u32, &'a Node),
    ) {
        self.leaves_below(0, limits, is_divided, visit);
    }

    fn leaves_below<'a>(
        &'a self,
        number: u32,
        limits: &CellLimits,
        is_divided: &impl Fn(u32) -> bool,
        visit: &mut impl FnMut(u32, &'a Node),
    ) {
        let node = &self.nodes[number as usize];
        if node.quarters == [0; 4] || (node.is_leaf(limits) && !is_divided(number)) {
            visit(number, node);
            return;
        }
        for quarter in node.quarters.into_iter().filter(|&quarter| quarter != 0) {
            self.leaves_below(quarter, limits, is_divided, visit);
        }
    }
}

/// Returns the number of cells.
pub fn count_leaves(patches: &[SegmentPatch], limits: &CellLimits) -> usize {
    let of_patch = |patch: &SegmentPatch| {
        let mut count = 0;
        patch.leaves(limits, &|_| false, &mut |_, _| count += 1);
        count
    };
    patches.par_iter().map(of_patch).sum()
}

/// Collects the depth pixels of segments by tiles and divides these into cells. Patches are in the order of segments, then of
/// tiles, row by row.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub fn patches(ldi: &Ldi, labels: &SegmentLabels, task: &Task) -> Result<Vec<SegmentPatch>> {
    let level = &ldi.levels[0];
    let columns = level.camera.width.div_ceil(TILE);
    let tiles: Vec<[u32; 2]> =
        (0..level.camera.height.div_ceil(TILE)).flat_map(|y| (0..columns).map(move |x| [x, y])).collect();
    let of_tile = |tile: &[u32; 2]| {
        task.check_cancelled()?;
        let mut patches = collected(level, labels, *tile);
        patches.iter_mut().for_each(|patch| patch.nodes = Divider::new(level, &ldi.surfaces, patch).nodes());
        Ok(patches)
    };
    let mut patches = tiles.par_iter().map(of_tile).collect::<Result<Vec<_>>>()?.concat();
    patches.sort_by_key(|patch| (patch.segment, patch.tile[1], patch.tile[0]));
    Ok(patches)
}

/// Collects the depth pixels of a tile by segments.
fn collected(level: &ResolutionLevel, labels: &SegmentLabels, tile: [u32; 2]) -> Vec<SegmentPatch> {
    let [left, top] = tile.map(|at| at * TILE);
    let mut pixels: Vec<(u32, PatchPixel)> = Vec::new();
    for y in top..level.camera.height.min(top + TILE) {
        for index in level.row_within(y, &(left..left + TILE)) {
            let (x, y) = ((u32::from(level.columns[index]) - left) as u8, (y - top) as u8);
            pixels.push((labels.segments[index], PatchPixel { x, y, index: index as u32 }));
        }
    }
    pixels.sort_by_key(|(segment, _)| *segment);
    let of_segment = |part: &[(u32, PatchPixel)]| SegmentPatch {
        segment: part[0].0,
        tile,
        pixels: part.iter().map(|(_, pixel)| *pixel).collect(),
        nodes: Vec::new(),
    };
    pixels.chunk_by(|a, b| a.0 == b.0).map(of_segment).collect()
}

/// A patch that is divided.
struct Divider<'a> {
    level: &'a ResolutionLevel,
    surfaces: &'a [LdiSurface],
    tile: [u32; 2],
    /// By place in the tile, the index of the depth pixel.
    grid: Vec<u32>,
    nodes: Vec<Node>,
}

impl<'a> Divider<'a> {
    fn new(level: &'a ResolutionLevel, surfaces: &'a [LdiSurface], patch: &SegmentPatch) -> Self {
        let mut grid = vec![NONE; SIDE * SIDE];
        for pixel in &patch.pixels {
            grid[usize::from(pixel.y) * SIDE + usize::from(pixel.x)] = pixel.index;
        }
        Self { level, surfaces, tile: patch.tile, grid, nodes: Vec::new() }
    }

    fn nodes(mut self) -> Vec<Node> {
        self.divide([0, 0], TILE as u8);
        self.nodes
    }

    /// Makes the cell at a place and all in it; returns its number, or nothing where there is no depth pixel.
    fn divide(&mut self, at: [u8; 2], side: u8) -> Option<u32> {
        let node = self.fitted(at, side)?;
        let number = self.nodes.len();
        // No error, or the noise of single precision.
        let exact = node.error <= f64::from(node.range[1]) * 1e-6;
        let full = usize::from(node.pixels) == usize::from(side) * usize::from(side);
        let flat = f64::from(node.range[1] - node.range[0]) <= f64::from(node.range[1]) * 1e-3;
        self.nodes.push(node);
        // A cell that cannot be better needs no quarters.
        if u32::from(side) > SMALLEST_CELL && !(exact && full && flat) {
            let half = side / 2;
            let places = [(0, 0), (half, 0), (0, half), (half, half)];
            let quarters = places.map(|(x, y)| self.divide([at[0] + x, at[1] + y], half).unwrap_or(0));
            self.nodes[number].quarters = quarters;
        }
        Some(number as u32)
    }

    /// Returns the depth pixels in a cell: the position of their centres in the frame, and their indices.
    fn pixels(&self, at: [u8; 2], side: u8) -> impl Iterator<Item = (f64, f64, usize)> + '_ {
        let [left, top] = self.tile.map(|at| f64::from(at * TILE));
        let [x0, y0] = at.map(usize::from);
        let side = usize::from(side);
        (y0..y0 + side).flat_map(move |y| {
            let row = &self.grid[y * SIDE + x0..y * SIDE + x0 + side];
            let held = row.iter().zip(x0..).filter(|(index, _)| **index != NONE);
            held.map(move |(&index, x)| (left + x as f64 + 0.5, top + y as f64 + 0.5, index as usize))
        })
    }

    /// Fits an affine inverse depth to a cell by least squares of the differences from the surface of its first depth pixel.
    fn fitted(&self, at: [u8; 2], side: u8) -> Option<Node> {
        let first = self.pixels(at, side).next()?.2;
        let surface = usize::from(self.level.surfaces[first]);
        let base = surface.checked_sub(1).map_or(DVec3::ZERO, |surface| self.surfaces[surface].nu);
        let half = f64::from(side) / 2.0;
        let middle = |axis: usize| f64::from(self.tile[axis] * TILE) + f64::from(at[axis]) + half;
        let centre = [middle(0), middle(1)];
        let depth = |index: usize| f64::from(self.level.inverse_depths[index]);
        let mut sums = PlaneFitSums::default();
        let mut range = [f32::INFINITY, f32::NEG_INFINITY];
        for (x, y, index) in self.pixels(at, side) {
            let d = self.level.inverse_depths[index];
            range = [range[0].min(d), range[1].max(d)];
            sums.add(
                (x - centre[0]) / half,
                (y - centre[1]) / half,
                depth(index) - base.dot(DVec3::new(x, y, 1.0)),
            );
        }
        let [a, b, c] = sums.solved();
        let (b, c) = (b / half, c / half);
        let plane = base + DVec3::new(b, c, a - b * centre[0] - c * centre[1]);
        let (mut error, mut crowding, mut closest, mut behind) = (0.0f64, 0.0f64, f64::INFINITY, 0u16);
        for (x, y, index) in self.pixels(at, side) {
            let off = (plane.dot(DVec3::new(x, y, 1.0)) - depth(index)).abs();
            error = error.max(off);
            let ray = PixelsOnRay::of(self.level, y as u32, index);
            let gap = ray.gap(self.level, index);
            crowding = crowding.max(off / gap);
            closest = closest.min(gap);
            behind += u16::from(ray.has_nearer(self.level, index));
        }
        let pixels = sums.count as u16;
        let hidden = 2 * behind > pixels;
        Some(Node { at, side, pixels, range, plane, error, crowding, closest, hidden, quarters: [0; 4] })
    }
}

/// The depth pixels beside one on its ray, by their indices in the level.
pub(super) struct PixelsOnRay {
    nearer: Option<usize>,
    farther: Option<usize>,
}

impl PixelsOnRay {
    /// Finds them for a depth pixel of a row.
    pub fn of(level: &ResolutionLevel, y: u32, index: usize) -> Self {
        // The depth pixel before it may be the last one of the row above, of the same column.
        let row = level.row(y);
        let of_ray = |other: &usize| row.contains(other) && level.columns[*other] == level.columns[index];
        Self { nearer: index.checked_sub(1).filter(of_ray), farther: Some(index + 1).filter(of_ray) }
    }

    /// Returns whether one is nearer than the depth pixel.
    pub fn has_nearer(&self, level: &ResolutionLevel, index: usize) -> bool {
        self.nearer.is_some_and(|nearer| level.inverse_depths[nearer] > level.inverse_depths[index])
    }

    /// Returns the least difference of inverse depth to them; infinite where there is none or where both are level.
    pub fn gap(&self, level: &ResolutionLevel, index: usize) -> f64 {
        let depth = f64::from(level.inverse_depths[index]);
        let gap = |other: usize| (f64::from(level.inverse_depths[other]) - depth).abs();
        let gaps = [self.nearer, self.farther].into_iter().flatten().map(gap);
        gaps.filter(|gap| *gap > 1e-6 * depth).fold(f64::INFINITY, f64::min)
    }
}

/// The sums of a fit of a + b x + c y, x and y within -1..1.
#[derive(Default)]
struct PlaneFitSums {
    count: f64,
    x: f64,
    y: f64,
    v: f64,
    xx: f64,
    xy: f64,
    yy: f64,
    xv: f64,
    yv: f64,
}

impl PlaneFitSums {
    fn add(&mut self, x: f64, y: f64, v: f64) {
        self.count += 1.0;
        (self.x, self.y, self.v) = (self.x + x, self.y + y, self.v + v);
        (self.xx, self.xy, self.yy) = (self.xx + x * x, self.xy + x * y, self.yy + y * y);
        (self.xv, self.yv) = (self.xv + x * v, self.yv + y * v);
    }

    /// Returns a, b and c.
    fn solved(&self) -> [f64; 3] {
        let [mx, my, mv] = [self.x, self.y, self.v].map(|sum| sum / self.count);
        let centred = |sum: f64, p: f64, q: f64| sum - self.count * p * q;
        let (xx, yy) = (centred(self.xx, mx, mx) + RIDGE, centred(self.yy, my, my) + RIDGE);
        let (xy, xv, yv) = (centred(self.xy, mx, my), centred(self.xv, mx, mv), centred(self.yv, my, mv));
        let determinant = xx * yy - xy * xy;
        let (b, c) = ((xv * yy - yv * xy) / determinant, (yv * xx - xv * xy) / determinant);
        [mv - b * mx - c * my, b, c]
    }
}
