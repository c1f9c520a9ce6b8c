//! Squared errors added up by what is shown: which surfaces are predicted well, and which not.

use std::ops::AddAssign;

use super::psnr;

/// Of some pixels, over any number of pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Pixels that were predicted.
    pub covered: u64,
    /// Pixels that nothing was predicted for.
    pub holes: u64,
    /// Sum of squared differences over the three channels of the covered ones.
    pub squared_error: u64,
}

impl Tally {
    /// Adds a predicted pixel.
    pub fn add(&mut self, truth: [u8; 3], predicted: [u8; 3]) {
        let squares = truth.iter().zip(predicted).map(|(t, p)| u64::from(t.abs_diff(p)).pow(2));
        self.covered += 1;
        self.squared_error += squares.sum::<u64>();
    }

    /// PSNR of the covered pixels in dB; none without any.
    pub fn psnr(&self) -> Option<f64> {
        (self.covered > 0).then(|| psnr(self.squared_error as f64, 3 * self.covered))
    }
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.covered += other.covered;
        self.holes += other.holes;
        self.squared_error += other.squared_error;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tallies_add_up_to_the_psnr_of_all_their_pixels() {
        let (mut a, mut b) = (Tally { holes: 3, ..Tally::default() }, Tally::default());
        a.add([10, 10, 10], [13, 10, 6]);
        b.add([0, 0, 0], [0, 5, 0]);
        a += b;
        assert_eq!(a, Tally { covered: 2, holes: 3, squared_error: 50 });
        assert!((a.psnr().unwrap() - psnr(50.0, 6)).abs() < 1e-12);
        assert_eq!(Tally::default().psnr(), None);
    }
}
