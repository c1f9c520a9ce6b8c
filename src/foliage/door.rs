//! The screen door: which sub-pixels something is drawn in that is drawn in part, so that it comes and goes without a jump.

use std::sync::LazyLock;

use super::walk::mixed;

/// The order in which the sub-pixels of a pixel open (Bayer 1973).
pub(super) const BAYER: [u8; 16] = [0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5];

/// Sub-pixels that are open: by how many of 16, and by where the order begins.
static OPEN: LazyLock<[[u16; 16]; 17]> = LazyLock::new(|| {
    let is_open = |count: usize, begin: usize, bit: usize| (usize::from(BAYER[bit]) + begin) % 16 < count;
    let mask = |count: usize, begin: usize| {
        (0..16).fold(0, |mask, bit| mask | u16::from(is_open(count, begin, bit)) << bit)
    };
    std::array::from_fn(|count| std::array::from_fn(|begin| mask(count, begin)))
});

/// The sub-pixels that one of several directions draws in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Door {
    first: usize,
    count: usize,
    seed: u64,
}

/// How much of a pixel all directions draw in together. Leaves are at slightly different places in the images of different
/// directions: where each sub-pixel is drawn by one of them alone, a maple's coverage is 1 to 5 % too small, and where each direction
/// with a fifth of the weight draws in all, up to 8 % too large. With a third of the sub-pixels drawn twice it is right within 3 % for
/// a maple and an oak of 11 to 311 rows (docs/quality.md).
const TOGETHER: f64 = 4.0 / 3.0;

impl Door {
    /// Makes the door that is open in this share of the sub-pixels; from 1 on in all.
    pub fn open(share: f64, seed: u64) -> Self {
        Self { first: 0, count: ((16.0 * share).round() as usize).min(16), seed }
    }

    /// Returns true where nothing is drawn.
    pub fn is_closed(&self) -> bool {
        self.count == 0
    }

    /// Returns true where all is drawn.
    pub fn is_wide(&self) -> bool {
        self.count == 16
    }

    /// Makes the door of a direction that has the weights from `from` to `to` of all, which go from 0 to 1: as wide as its weight, and
    /// beginning where that of the direction before ends, so that few sub-pixels are drawn twice.
    pub fn between(from: f64, to: f64, seed: u64) -> Self {
        let [first, last] = [from, to].map(|weight| (16.0 * TOGETHER * weight).round() as usize);
        Self { first: first % 16, count: (last - first).min(16), seed }
    }

    /// Returns how many sub-pixels of 16 are open, and where they begin.
    pub fn opening(&self) -> [u32; 2] {
        [self.count as u32, self.first as u32]
    }

    /// Returns the sub-pixels of a pixel that are open.
    #[inline]
    pub fn open_at(&self, x: i32, y: i32) -> u16 {
        if self.count == 16 {
            return u16::MAX;
        }
        let pixel = (x as u32 as u64) << 32 | y as u32 as u64;
        let begin = (mixed(self.seed ^ mixed(pixel)) >> 60) as usize;
        OPEN[self.count][(begin + 16 - self.first) % 16]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::synthetic::Rng;

    #[test]
    fn a_door_opens_by_one_sub_pixel_after_the_other_from_closed_to_wide() {
        for begin in 0..16 {
            for count in 0..=16 {
                assert_eq!(OPEN[count][begin].count_ones() as usize, count);
                assert_eq!(OPEN[count][begin] & OPEN[16.min(count + 1)][begin], OPEN[count][begin]);
            }
        }
    }

    #[test]
    fn doors_of_several_directions_are_as_wide_as_their_weights_and_leave_no_sub_pixel_out() {
        let mut rng = Rng::new(7);
        for _ in 0..500 {
            let mut weights = [0.0; 4].map(|_: f64| rng.between(0.0, 1.0));
            let sum: f64 = weights.iter().sum();
            weights.iter_mut().for_each(|weight| *weight /= sum);
            let (mut from, mut all, mut opened) = (0.0, 0u16, 0);
            for weight in weights {
                let open = Door::between(from, from + weight, 9).open_at(5, -6);
                assert!(
                    (f64::from(open.count_ones()) - 16.0 * TOGETHER * weight).abs() <= 1.0
                        || open == u16::MAX
                );
                (from, all, opened) = (from + weight, all | open, opened + open.count_ones());
            }
            assert!(all == u16::MAX && opened <= 22, "{weights:?}: {all:016b}, {opened}");
        }
        assert_eq!(Door::between(0.0, 1.0, 3).open_at(5, 6), u16::MAX);
        assert_eq!(Door::between(0.5, 0.5, 3).open_at(5, 6), 0);
    }
}
