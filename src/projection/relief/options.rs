//! Options of the estimation of relief.

/// Options of [`super::estimate_relief`]. Lengths are relative, because the unit of a site is unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReliefOptions {
    /// Side of a cell, in pixels of the photos that see the face best (a quarter of the photos see it
    /// better).
    pub cell_px: f64,
    /// The largest number of cells of one face; larger faces get larger cells.
    pub most_cells: u32,
    /// The largest height, as a share of the photos' median distance from the face. It is also at most half
    /// the face's own extent, because thin objects do not deviate by more than their width.
    pub reach: f64,
    /// The number of heights tried on each side of the plane, evenly spaced.
    pub steps: u32,
    /// The largest number of photos compared at one cell: those with the highest resolution there.
    pub most_photos: usize,
    /// The least cosine of the angle to the normal under which a photo is compared. More oblique photos show
    /// details as stripes, and the spurious heights that they suggest for flat ground are visible in every
    /// grazing view.
    pub least_cosine: f64,
    /// The cost of the largest height; smaller heights cost in proportion. The photos' disagreement per cell
    /// is between 0 and about 1, so this decides where there is little texture.
    pub prior: f32,
    /// The cost of one step of height between neighbouring cells, as on slanted surfaces.
    pub slope_cost: f32,
    /// The cost of a larger difference of height between neighbouring cells, as at reveals and mouldings.
    pub jump_cost: f32,
}

impl Default for ReliefOptions {
    fn default() -> Self {
        Self {
            cell_px: 8.0,
            most_cells: 1 << 19,
            reach: 0.06,
            steps: 48,
            most_photos: 12,
            least_cosine: 0.3,
            prior: 0.1,
            slope_cost: 0.03,
            jump_cost: 1.0,
        }
    }
}

impl ReliefOptions {
    /// Returns the number of heights tried, including that of the plane itself.
    pub fn hypotheses(&self) -> usize {
        2 * self.steps as usize + 1
    }
}
