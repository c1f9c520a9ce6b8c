//! Corners that cells share are compromises. A cell whose depth pixels its triangles miss is divided further; one that cannot be
//! divided has corners of its own, which open no gap that is seen from the reference camera.

use glam::DVec2;
use rustc_hash::FxHashSet;

use super::TILE;
use super::cells::{CLOSEST, CellLimits, PixelsOnRay, SegmentPatch};
use super::mesh::{CellMesh, MeshCell, Mesher, Vertex};
use crate::layout::ResolutionLevel;

/// The error of triangles is no more than this times that of cells: corners are means of two cells or more.
const COMPROMISE: f64 = 2.0;
/// The error of triangles is no more than this share of the difference to another layer: two layers that each err by so much
/// still do not cross.
const CROWDED: f64 = 1.5 * CLOSEST;

/// Cells that are treated in another way than the limits say, each by the places of its patch in the segment and of its node.
#[derive(Debug, Default)]
pub(super) struct Exceptions {
    divided: FxHashSet<(usize, u32)>,
    alone: FxHashSet<(usize, u32)>,
}

impl Exceptions {
    /// Returns whether a cell is divided whatever the limits say.
    pub fn is_divided(&self, cell: (usize, u32)) -> bool {
        self.divided.contains(&cell)
    }

    /// Returns whether a cell shares no corners with others.
    pub fn is_alone(&self, cell: (usize, u32)) -> bool {
        self.alone.contains(&cell)
    }

    /// Divides cells, or gives them corners of their own where they have no quarters. Returns whether that changes anything.
    pub fn add(&mut self, cells: &[MeshCell]) -> bool {
        let mut changed = false;
        for cell in cells {
            let kind = if cell.node.quarters == [0; 4] { &mut self.alone } else { &mut self.divided };
            changed |= kind.insert(cell.place);
        }
        changed
    }
}

impl<'a> Mesher<'a> {
    /// Returns the cells whose triangles miss one of their depth pixels by more than is allowed.
    pub fn poor_cells(&self, level: &ResolutionLevel, limits: &CellLimits) -> Vec<MeshCell<'a>> {
        let most = COMPROMISE * limits.error;
        let mut poor = Vec::new();
        for (patch, cells) in self.group.iter().zip(&self.cells) {
            let mut rows = None;
            for cell in cells {
                let shape = self.shape(cell);
                // No triangle is farther from the plane than its corners are.
                if shape.differs_most(cell) + cell.node.error <= most.min(CROWDED * cell.node.closest) {
                    continue;
                }
                let rows = rows.get_or_insert_with(|| rows_of(patch));
                let misses = |(x, y, index): (u8, u8, u32)| {
                    let at = DVec2::new((patch.tile[0] * TILE).into(), (patch.tile[1] * TILE).into())
                        + DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                    let index = index as usize;
                    let depth = f64::from(level.inverse_depths[index]);
                    // Beside triangles of no area, where corners were moved together, there is nothing to be seen.
                    let off = shape.inverse_depth(at).map_or(0.0, |found| (found - depth).abs());
                    let row = patch.tile[1] * TILE + u32::from(y);
                    off > most || off > CROWDED * PixelsOnRay::of(level, row, index).gap(level, index)
                };
                if pixels_in(patch, rows, cell).any(misses) {
                    poor.push(*cell);
                }
            }
        }
        poor
    }
}

/// Returns where each row of a patch begins in its depth pixels, and the end.
fn rows_of(patch: &SegmentPatch) -> Vec<usize> {
    (0..=TILE).map(|y| patch.pixels.partition_point(|pixel| u32::from(pixel.y) < y)).collect()
}

/// Returns the depth pixels in a cell: column and row in the tile, and index in the level.
fn pixels_in<'a>(
    patch: &'a SegmentPatch,
    rows: &'a [usize],
    cell: &MeshCell<'_>,
) -> impl Iterator<Item = (u8, u8, u32)> + use<'a> {
    let ([left, top], side) = (cell.node.at, cell.node.side);
    (top..top + side).flat_map(move |y| {
        let row = &patch.pixels[rows[usize::from(y)]..rows[usize::from(y) + 1]];
        let start = row.partition_point(|pixel| pixel.x < left);
        let within = row[start..].iter().take_while(move |pixel| pixel.x < left + side);
        within.map(|pixel| (pixel.x, pixel.y, pixel.index))
    })
}

impl CellMesh {
    /// Returns the largest difference of a corner from the cell's own plane.
    fn differs_most(&self, cell: &MeshCell) -> f64 {
        let off = |Vertex { x, y, inverse_depth }: Vertex| {
            (f64::from(inverse_depth) - cell.node.inverse_depth(x, y)).abs()
        };
        self.triangles().flatten().map(off).fold(0.0, f64::max)
    }

    /// Returns the inverse depth of the triangle that holds a position of the frame.
    fn inverse_depth(&self, at: DVec2) -> Option<f64> {
        self.triangles().find_map(|corners| {
            let [a, b, c] = corners.map(|corner| DVec2::new(corner.x.into(), corner.y.into()));
            let area = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a);
            let whole = area(a, b, c);
            let shares = [area(at, b, c) / whole, area(a, at, c) / whole, area(a, b, at) / whole];
            // Triangles without area give no numbers, which fail the comparison.
            let holds = shares.iter().all(|share| *share >= -1e-9);
            let depth = || (0..3).map(|i| shares[i] * f64::from(corners[i].inverse_depth)).sum();
            holds.then(depth)
        })
    }
}
