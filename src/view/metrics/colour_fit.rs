//! The least squares line between two channels, `truth ~ gain * predicted + offset`, from sums alone.

/// Sums over pairs of samples. They are whole numbers, so that the order of addition does not matter; 2^64
/// holds the squares of 10^14 samples.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PairSums {
    count: u64,
    predicted: u64,
    truth: u64,
    predicted_squared: u64,
    truth_squared: u64,
    product: u64,
}

impl PairSums {
    /// Adds a pair of samples.
    pub fn add(&mut self, predicted: u8, truth: u8) {
        let (p, t) = (u64::from(predicted), u64::from(truth));
        self.count += 1;
        self.predicted += p;
        self.truth += t;
        self.predicted_squared += p * p;
        self.truth_squared += t * t;
        self.product += p * t;
    }

    /// Returns the number of pairs.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Returns the sum of `(predicted - truth)^2`.
    pub fn squared_error(&self) -> f64 {
        (self.predicted_squared + self.truth_squared - 2 * self.product) as f64
    }

    /// Returns the sum of squared errors that remains with the best gain and offset: `S_tt - S_pt^2 / S_pp`
    /// of the centred sums. The fitted samples are neither rounded nor clipped.
    pub fn fitted_squared_error(&self) -> f64 {
        let Self { count, predicted, truth, .. } = *self;
        if count == 0 {
            return 0.0;
        }
        // The sums are multiplied by `count` and so remain whole: centred sums as differences of f64 would
        // cancel.
        let centred = |product: u64, a: u64, b: u64| {
            (i128::from(count) * i128::from(product) - i128::from(a) * i128::from(b)) as f64
        };
        let pp = centred(self.predicted_squared, predicted, predicted);
        let tt = centred(self.truth_squared, truth, truth);
        let pt = centred(self.product, predicted, truth);
        let explained = if pp > 0.0 { pt * pt / pp } else { 0.0 };
        (tt - explained).max(0.0) / count as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    #[test]
    fn no_other_gain_and_offset_does_better() {
        let mut rng = Rng::new(5);
        let pairs: Vec<(u8, u8)> = (0..200)
            .map(|_| {
                let p = rng.whole(0, 255);
                (p as u8, (p / 2 + rng.whole(0, 60)) as u8)
            })
            .collect();
        let mut sums = PairSums::default();
        pairs.iter().for_each(|&(p, t)| sums.add(p, t));
        let error = |gain: f64, offset: f64| -> f64 {
            pairs.iter().map(|&(p, t)| (gain * f64::from(p) + offset - f64::from(t)).powi(2)).sum()
        };
        let best = sums.fitted_squared_error();
        assert!((error(1.0, 0.0) - sums.squared_error()).abs() < 1e-6);
        for _ in 0..2000 {
            assert!(error(rng.between(0.3, 0.7), rng.between(10.0, 50.0)) >= best - 1e-6);
        }
        assert!(best < sums.squared_error() / 4.0);
    }

    #[test]
    fn a_channel_of_one_shade_is_fitted_by_its_offset() {
        let mut sums = PairSums::default();
        [(7, 10), (7, 20)].into_iter().for_each(|(p, t)| sums.add(p, t));
        assert_eq!(sums.fitted_squared_error(), 50.0);
    }
}
