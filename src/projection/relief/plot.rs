//! The part of a face's plane that gets heights: its bounding box, in cells.

use glam::{DVec2, DVec3};

use super::FaceRelief;
use super::options::ReliefOptions;
use super::witness::Witness;
use crate::geometry::polygon::PlaneFrame;
use crate::raster::robust::quantile;
use crate::scene::{FaceId, Model};

/// Cells in the plane of a face.
#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    /// Whose.
    pub face: FaceId,
    /// Flat coordinates in the plane.
    pub frame: PlaneFrame,
    /// Of the plane.
    pub normal: DVec3,
    /// Flat coordinates of the first cell's low corner.
    pub low: DVec2,
    /// Side of a cell, in world units.
    pub cell: f64,
    /// Columns and rows.
    pub size: [u32; 2],
    /// The largest height, in world units.
    pub reach: f64,
}

impl Plot {
    /// For a face and its witnesses with their pixels per world unit; `None` where there is nothing to
    /// see: fewer than two witnesses, or a face smaller than two cells.
    pub fn new(
        model: &Model,
        face: FaceId,
        witnesses: &[(&Witness, f64)],
        options: &ReliefOptions,
    ) -> Option<Self> {
        if witnesses.len() < 2 {
            return None;
        }
        let plane = &model.face(face).plane;
        let frame = PlaneFrame::of(plane);
        let corners = || model.ring_points(face).map(|point| frame.flat(point));
        let low = corners().fold(DVec2::INFINITY, DVec2::min);
        let extent = corners().fold(DVec2::NEG_INFINITY, DVec2::max) - low;
        let cell = cell_side(witnesses, extent, options)?;
        if cell == 0.0 || !cell.is_finite() {
            return None;
        }
        let size = [extent.x, extent.y].map(|length| (length / cell).ceil().max(1.0) as u32);
        if size[0] * size[1] < 4 {
            return None;
        }
        let distances = witnesses.iter().map(|(w, px_per_unit)| w.camera.fx / px_per_unit);
        let reach = options.reach * at_share(distances, 0.5)?;
        let reach = reach.min(0.5 * (extent.x * extent.y).sqrt());
        Some(Self { face, frame, normal: plane.normal, low, cell, size, reach })
    }

    /// Cells in a row.
    pub fn columns(&self) -> usize {
        self.size[0] as usize
    }

    /// Rows.
    pub fn rows(&self) -> usize {
        self.size[1] as usize
    }

    /// Cells.
    pub fn cells(&self) -> usize {
        self.columns() * self.rows()
    }

    /// With its heights, one a cell, row by row.
    pub fn with_heights(self, heights: Vec<f32>) -> FaceRelief {
        FaceRelief { frame: self.frame, low: self.low, cell: self.cell, size: self.size, heights }
    }
}

fn cell_side(witnesses: &[(&Witness, f64)], extent: DVec2, options: &ReliefOptions) -> Option<f64> {
    // A quarter of the witnesses see it better.
    let px_per_unit = at_share(witnesses.iter().map(|(_, px)| *px), 0.75)?;
    let wanted = options.cell_px / px_per_unit;
    let most = f64::from(options.most_cells);
    // The second bound is for slivers, which have length but no area.
    Some(wanted.max((extent.x * extent.y / most).sqrt()).max(extent.max_element() / most))
}

/// None of nothing.
fn at_share(values: impl Iterator<Item = f64>, share: f64) -> Option<f64> {
    quantile(&mut values.collect::<Vec<_>>(), share)
}
