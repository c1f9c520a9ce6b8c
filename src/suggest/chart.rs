//! A raster on a plane.

use glam::{DVec2, DVec3};

use quadratura_base::geometry::Plane;
use quadratura_base::geometry::polygon::PlaneFrame;

/// Cells on a plane: columns to the right as its front is seen, rows upwards.
#[derive(Debug, Clone)]
pub struct PlaneChart {
    /// The axes: `v` is upwards where the plane is not level.
    pub frame: PlaneFrame,
    /// The corner of the first cell.
    pub low: DVec2,
    /// The side of a cell.
    pub cell: f64,
    /// Columns and rows.
    pub size: [usize; 2],
    /// Whether rows go upwards: the plane is not level.
    pub rises: bool,
}

/// The most cells a side.
const MOST_CELLS: f64 = 2000.0;

impl PlaneChart {
    /// Makes the raster around points of the plane, with a margin; cells become larger where there would be too many.
    pub fn around(
        plane: &Plane,
        up: DVec3,
        points: impl Iterator<Item = DVec3>,
        margin: f64,
        cell: f64,
    ) -> Self {
        let (frame, rises) = upright(plane, up);
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for point in points {
            let at = frame.flat(point);
            (low, high) = (low.min(at), high.max(at));
        }
        if !(low.is_finite() && high.is_finite()) {
            (low, high) = (DVec2::ZERO, DVec2::ZERO);
        }
        let (low, high) = (low - margin, high + margin);
        let cell = cell.max((high - low).max_element() / MOST_CELLS);
        let size = ((high - low) / cell).ceil().max(DVec2::ONE);
        Self { frame, low, cell, size: [size.x as usize, size.y as usize], rises }
    }

    /// Returns the number of cells.
    pub fn count(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Returns the position of a point in cells: the middle of the first one is at (0.5, 0.5).
    #[inline]
    pub fn place(&self, point: DVec3) -> DVec2 {
        (self.frame.flat(point) - self.low) / self.cell
    }

    /// Returns the cell of a point of the plane.
    #[inline]
    pub fn index(&self, point: DVec3) -> Option<usize> {
        let at = self.place(point);
        let inside = at.x >= 0.0 && at.y >= 0.0 && at.x < self.size[0] as f64 && at.y < self.size[1] as f64;
        inside.then(|| at.y as usize * self.size[0] + at.x as usize)
    }

    /// Returns the point at a position in cells.
    #[inline]
    pub fn point(&self, at: DVec2) -> DVec3 {
        self.frame.raised(self.low + at * self.cell)
    }

    /// Returns the middle of a cell.
    #[inline]
    pub fn middle(&self, index: usize) -> DVec3 {
        let at = DVec2::new((index % self.size[0]) as f64, (index / self.size[0]) as f64);
        self.point(at + 0.5)
    }
}

/// Returns axes of a plane with `v` as nearly upwards as it goes.
fn upright(plane: &Plane, up: DVec3) -> (PlaneFrame, bool) {
    let rise = up - plane.normal * plane.normal.dot(up);
    if rise.length() < 0.2 {
        return (PlaneFrame::from_plane(plane), false);
    }
    let v = rise.normalize();
    (PlaneFrame { origin: plane.point, u: v.cross(plane.normal), v }, true)
}

/// Fills a mask's gaps of up to so many cells: what is nearer than `reach` to the mask, without what is nearer than that to the
/// rest.
pub fn closed(mask: &[bool], size: [usize; 2], reach: u16) -> Vec<bool> {
    let grown = grown(mask, size, reach);
    // The edge of the raster is no border of the rest.
    let steps = quadratura_base::raster::steps::steps_inside(&grown, size);
    mask.iter().zip(steps).map(|(own, steps)| *own || steps > reach).collect()
}

/// Returns the cells within so many steps of a mask.
pub fn grown(mask: &[bool], size: [usize; 2], reach: u16) -> Vec<bool> {
    let outside: Vec<bool> = mask.iter().map(|own| !own).collect();
    let steps = quadratura_base::raster::steps::steps_inside(&outside, size);
    steps.into_iter().map(|steps| steps <= reach).collect()
}

/// Numbers the connected regions of equal values, four neighbours each: the number of each cell's region, and the sizes.
pub fn regions<T: PartialEq>(values: &[T], [columns, rows]: [usize; 2]) -> (Vec<u32>, Vec<usize>) {
    const NONE: u32 = u32::MAX;
    let (mut number, mut sizes) = (vec![NONE; values.len()], Vec::new());
    let mut open = Vec::new();
    for first in 0..values.len() {
        if number[first] != NONE {
            continue;
        }
        let own = sizes.len() as u32;
        let mut size = 0;
        number[first] = own;
        open.push(first);
        while let Some(at) = open.pop() {
            size += 1;
            let (x, y) = (at % columns, at / columns);
            let beside = [
                (x > 0).then(|| at - 1),
                (x + 1 < columns).then(|| at + 1),
                (y > 0).then(|| at - columns),
                (y + 1 < rows).then(|| at + columns),
            ];
            for next in beside.into_iter().flatten() {
                if number[next] == NONE && values[next] == values[at] {
                    number[next] = own;
                    open.push(next);
                }
            }
        }
        sizes.push(size);
    }
    (number, sizes)
}
