//! The grid of cells on a face's plane for which heights are estimated.

use glam::{DVec2, DVec3};

use super::FaceRelief;
use super::options::ReliefOptions;
use super::sweep::FaceView;
use quadratura_base::geometry::polygon::PlaneFrame;
use quadratura_base::raster::robust::quantile;
use quadratura_base::scene::{FaceId, Model};

/// A grid of cells that covers the bounding box of a face in its plane.
#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    /// The face.
    pub face: FaceId,
    /// The frame of flat coordinates in the plane, in world units.
    pub frame: PlaneFrame,
    /// The unit normal of the plane.
    pub normal: DVec3,
    /// The low corner of the first cell, in flat coordinates.
    pub low: DVec2,
    /// Side of a cell, in world units.
    pub cell: f64,
    /// The number of columns and rows.
    pub size: [u32; 2],
    /// The largest height tried, in world units.
    pub reach: f64,
}

impl Plot {
    /// Lays out the grid for a face and its sweep views. Returns `None` where
    /// heights cannot be estimated: with fewer than two sweep views, or for a face smaller than four cells.
    pub fn new(
        model: &Model,
        face: FaceId,
        sweep_views: &[FaceView],
        options: &ReliefOptions,
    ) -> Option<Self> {
        if sweep_views.len() < 2 {
            return None;
        }
        let plane = &model.face(face).plane;
        let frame = PlaneFrame::from_plane(plane);
        let corners = || model.ring_points(face).map(|point| frame.flat(point));
        let low = corners().fold(DVec2::INFINITY, DVec2::min);
        let extent = corners().fold(DVec2::NEG_INFINITY, DVec2::max) - low;
        let cell = cell_side(sweep_views, extent, options)?;
        if cell == 0.0 || !cell.is_finite() {
            return None;
        }
        let size = [extent.x, extent.y].map(|length| (length / cell).ceil().max(1.0) as u32);
        if size[0] * size[1] < 4 {
            return None;
        }
        let distances = sweep_views.iter().map(|view| view.camera.fx / view.px_per_unit);
        let reach = options.reach * at_share(distances, 0.5)?;
        let reach = reach.min(0.5 * (extent.x * extent.y).sqrt());
        Some(Self { face, frame, normal: plane.normal, low, cell, size, reach })
    }

    /// Returns the number of cells in a row.
    pub fn columns(&self) -> usize {
        self.size[0] as usize
    }

    /// Returns the number of rows.
    pub fn rows(&self) -> usize {
        self.size[1] as usize
    }

    /// Returns the number of cells.
    pub fn cells(&self) -> usize {
        self.columns() * self.rows()
    }

    /// Combines the grid with its heights, one per cell, row by row.
    pub fn with_heights(self, heights: Vec<f32>) -> FaceRelief {
        FaceRelief { frame: self.frame, low: self.low, cell: self.cell, size: self.size, heights }
    }
}

fn cell_side(sweep_views: &[FaceView], extent: DVec2, options: &ReliefOptions) -> Option<f64> {
    // The resolution that a quarter of the sweep views exceed.
    let px_per_unit = at_share(sweep_views.iter().map(|view| view.px_per_unit), 0.75)?;
    let wanted = options.cell_px / px_per_unit;
    let most = f64::from(options.most_cells);
    // The second bound is for slivers, which have length but hardly any area.
    Some(wanted.max((extent.x * extent.y / most).sqrt()).max(extent.max_element() / most))
}

/// Returns the quantile of the values at `share` (0 to 1); `None` without any value.
fn at_share(values: impl Iterator<Item = f64>, share: f64) -> Option<f64> {
    quantile(&mut values.collect::<Vec<_>>(), share)
}
