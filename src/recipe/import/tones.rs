//! Statistics of how colours have changed: whether by one curve per channel.

use crate::document::paint::PaintColour;
use crate::raster::in_8_bits;

/// The largest deviation from one curve, in steps of 8 bits, as a root mean square: rounding and noise of conversions
/// are less, other pictures much more.
const NEAR_CURVE: f64 = 4.0;
/// The number of levels.
const LEVELS: usize = 256;

/// For each level of a channel before: the number, sum and sum of squares of the levels after.
#[derive(Debug, Clone, Default)]
pub struct Tones {
    /// Three channels of 256 levels, or empty.
    levels: Vec<[u64; 3]>,
}

impl Tones {
    /// Adds a pixel that was visible before; where it was erased it has no colour.
    pub fn add(&mut self, before: PaintColour, after: PaintColour) {
        if after[3] == 0 {
            return;
        }
        self.levels.resize(3 * LEVELS, [0; 3]);
        for channel in 0..3 {
            let level = &mut self.levels[channel * LEVELS + usize::from(in_8_bits(before[channel]))];
            let after = u64::from(in_8_bits(after[channel]));
            *level = [level[0] + 1, level[1] + after, level[2] + after * after];
        }
    }

    /// Returns the sum of both.
    pub fn with(mut self, other: &Self) -> Self {
        self.levels.resize(self.levels.len().max(other.levels.len()), [0; 3]);
        let pairs = self.levels.iter_mut().zip(&other.levels);
        pairs.for_each(|(sum, other)| (0..3).for_each(|i| sum[i] += other[i]));
        self
    }

    /// Returns true when every level has become another one by the same curve everywhere.
    pub fn are_one_curve(&self) -> bool {
        let (mut pixels, mut squares) = (0, 0.0);
        for [count, sum, sum_of_squares] in self.levels.iter().filter(|level| level[0] > 0) {
            pixels += count;
            squares += *sum_of_squares as f64 - (*sum as f64).powi(2) / *count as f64;
        }
        pixels > 0 && (squares / pixels as f64).sqrt() < NEAR_CURVE
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::synthetic::Rng;

    /// The statistics of random pixels that an edit changes.
    fn tones(edit: impl Fn([f64; 3]) -> [f64; 3]) -> Tones {
        let mut rng = Rng::new(3);
        let mut tones = Tones::default();
        for _ in 0..5000 {
            let before = [0; 3].map(|_: i32| rng.between(0.0, 255.0).floor());
            let colour = |rgb: [f64; 3]| {
                let [r, g, b] = rgb.map(|value| (257.0 * value.clamp(0.0, 255.0).round()) as u16);
                [r, g, b, u16::MAX]
            };
            tones.add(colour(before), colour(edit(before)));
        }
        tones
    }

    #[test]
    fn a_gamma_is_a_curve_and_a_saturation_or_another_picture_is_none() {
        assert!(tones(|rgb| rgb.map(|value| 255.0 * (value / 255.0).powf(1.8))).are_one_curve());
        let gains = |[r, g, b]: [f64; 3]| [0.9 * r, g, 1.3 * b];
        assert!(tones(gains).with(&tones(gains)).are_one_curve());
        assert!(!tones(|[r, g, b]| [g, b, r]).are_one_curve());
        assert!(!tones(|[r, g, b]| [(r + g + b) / 3.0; 3]).are_one_curve());
        assert!(!Tones::default().are_one_curve());
    }
}
