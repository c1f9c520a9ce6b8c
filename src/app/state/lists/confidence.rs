//! The confidence of the listed layers.

use crate::state::State;
use quadratura_recipe::fill::shares::LayerShares;

impl State {
    /// Returns the confidence of the filling of each layer of the selected photo, 0 to 1, where it is known.
    pub fn layer_trust(&self) -> Vec<Option<f64>> {
        let shares = self.selected_photo().and_then(|photo| self.quality.fill.shares.get(&photo)?.found());
        let trust = |shares: &LayerShares| (shares.filled() > 0).then_some(shares.confidence);
        shares.map(|shares| shares.iter().map(trust).collect()).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_project_no_layer_is_trusted() {
        assert!(State::default().layer_trust().is_empty());
    }
}
