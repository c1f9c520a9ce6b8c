//! What decides on the heights of a relief besides the site, as a text.

use super::options::ReliefOptions;
use super::{detail, estimate, sweep, sweep_view};

/// The version of the method. It is increased with every change of the method that neither an option nor a
/// constant reflects, so that relief estimated by an older version is not reused.
const METHOD: u32 = 1;

impl ReliefOptions {
    /// Returns a text of all settings that decide on the heights besides the site: equal texts mean equal
    /// heights.
    pub fn fingerprint(&self) -> String {
        let details = (detail::MOST_TEXELS, detail::AROUND, detail::NOISE, detail::STEPS);
        let sweep_views = (sweep_view::BLOCK_PX, sweep_view::SAME_SURFACE, estimate::LEAST_BLOCKS);
        let sweep = sweep::TEXELS_PER_CELL;
        format!("method {METHOD}, {self:?}, details {details:?}, witnesses {sweep_views:?}, sweep {sweep:?}")
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
