//! How relief is estimated.

use super::{detail, estimate, sweep, witness};

/// Counts the ways in which heights were ever estimated: one more with every change that neither an option
/// nor a constant tells, so that heights kept from before are not taken for today's.
const METHOD: u32 = 1;

/// Options of [`super::estimate_relief`]. Lengths are relative, because a site's unit is not known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReliefOptions {
    /// Side of a cell, in pixels of the photos that see the face best (a quarter of them see it better).
    pub cell_px: f64,
    /// Most cells of one face; larger faces get larger cells.
    pub most_cells: u32,
    /// Largest height, as a share of the photos' median distance from the face. It is also at most
    /// half the face's own extent: thin things don't stand off by more than they are wide.
    pub reach: f64,
    /// Heights tried on each side of the plane, evenly spaced.
    pub steps: u32,
    /// Photos that are asked at one cell: those with most pixels there.
    pub most_photos: usize,
    /// Photos that see a cell more obliquely have no say: cosine of the angle to the normal. Their details
    /// are stripes elsewhere, and what they take for heights of a flat ground shows in every view along it.
    pub least_cosine: f64,
    /// Cost of the largest height; smaller ones cost in proportion. Disagreement of photos is between 0
    /// and about 1 per cell, so this decides where there is little to see.
    pub prior: f32,
    /// Cost of one step of height between neighbours: slanted surfaces.
    pub slope_cost: f32,
    /// Cost of any larger one: reveals and mouldings.
    pub jump_cost: f32,
}

impl Default for ReliefOptions {
    fn default() -> Self {
        Self {
            cell_px: 8.0,
            most_cells: 1 << 19,
            reach: 0.03,
            steps: 24,
            most_photos: 12,
            least_cosine: 0.3,
            prior: 0.1,
            slope_cost: 0.1,
            jump_cost: 1.0,
        }
    }
}

impl ReliefOptions {
    /// Heights tried, the plane's own among them.
    pub fn hypotheses(&self) -> usize {
        2 * self.steps as usize + 1
    }

    /// All that decides on the heights besides the site: equal texts, equal heights.
    pub fn fingerprint(&self) -> String {
        let details = (detail::MOST_TEXELS, detail::AROUND, detail::NOISE, detail::STEPS);
        let witnesses = (witness::BLOCK_PX, witness::SAME_SURFACE, estimate::LEAST_BLOCKS);
        let sweep = sweep::TEXELS_PER_CELL;
        format!("method {METHOD}, {self:?}, details {details:?}, witnesses {witnesses:?}, sweep {sweep:?}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_options_have_another_fingerprint() {
        let options = ReliefOptions::default();
        let others = [
            ReliefOptions { cell_px: 9.0, ..options },
            ReliefOptions { reach: 0.02, ..options },
            ReliefOptions { jump_cost: 2.0, ..options },
        ];
        assert_eq!(options.fingerprint(), ReliefOptions::default().fingerprint());
        assert!(others.iter().all(|other| other.fingerprint() != options.fingerprint()));
    }
}
