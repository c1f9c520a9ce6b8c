//! Sums of squared errors, by which the quality of parts of images, such as surfaces, is reported.

use std::ops::AddAssign;

use super::psnr;

/// The summed errors of some pixels, over any number of images.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ErrorSum {
    /// The number of pixels that were predicted.
    pub covered: u64,
    /// The number of pixels that were not predicted.
    pub holes: u64,
    /// The sum of squared differences over the three channels of the predicted pixels.
    pub squared_error: u64,
}

impl ErrorSum {
    /// Adds a predicted pixel.
    pub fn add(&mut self, truth: [u8; 3], predicted: [u8; 3]) {
        let squares = truth.iter().zip(predicted).map(|(t, p)| u64::from(t.abs_diff(p)).pow(2));
        self.covered += 1;
        self.squared_error += squares.sum::<u64>();
    }

    /// Computes the PSNR of the predicted pixels in dB; `None` when there are none.
    pub fn psnr(&self) -> Option<f64> {
        (self.covered > 0).then(|| psnr(self.squared_error as f64, 3 * self.covered))
    }
}

impl AddAssign for ErrorSum {
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
        let (mut a, mut b) = (ErrorSum { holes: 3, ..ErrorSum::default() }, ErrorSum::default());
        a.add([10, 10, 10], [13, 10, 6]);
        b.add([0, 0, 0], [0, 5, 0]);
        a += b;
        assert_eq!(a, ErrorSum { covered: 2, holes: 3, squared_error: 50 });
        assert!((a.psnr().unwrap() - psnr(50.0, 6)).abs() < 1e-12);
        assert_eq!(ErrorSum::default().psnr(), None);
    }
}
