//! Stippled transparency: which sub-pixels something is drawn in that is drawn in part, so that it comes and goes without a jump.

use std::sync::LazyLock;

use super::seed::mixed;

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

/// Stipples open by this share of a pixel: 1/256, of which sixteen are a sub-pixel. Pixels open their sub-pixels at different moments, so
/// that a stipple that opens steadily changes few pixels at a time.
const FULL: u32 = 256;
/// A sub-pixel in those shares.
const SUB_PIXEL: u32 = FULL / 16;

/// The part of the sub-pixels that something draws in: an interval of the order in which they open. The order begins elsewhere in
/// each pixel, and stipples with the same seed have the same order: those whose intervals follow each other share the sub-pixels among them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stipple {
    /// Where it begins, below [`FULL`].
    first: u16,
    /// How much is open, up to [`FULL`].
    count: u16,
    seed: u64,
}

/// How much of a pixel all directions draw in together. Leaves are at slightly different places in the images of different
/// directions: where each sub-pixel is drawn by one of them alone, a maple's coverage is 1 to 5 % too small, and where each direction
/// with a fifth of the weight draws in all, up to 8 % too large. With a third of the sub-pixels drawn twice it is right within 3 % for
/// a maple and an oak of 11 to 311 rows (docs/quality.md).
const TOGETHER: f64 = 4.0 / 3.0;

impl Stipple {
    /// Makes the stipple that is open in all sub-pixels.
    pub fn wide(seed: u64) -> Self {
        Self { first: 0, count: FULL as u16, seed }
    }

    /// Makes the stipple that is open in this share of the sub-pixels; from 1 on in all.
    pub(super) fn open(share: f64, seed: u64) -> Self {
        Self { count: shares(share).min(FULL) as u16, ..Self::wide(seed) }
    }

    /// Returns true where nothing is drawn.
    pub fn is_closed(&self) -> bool {
        self.count == 0
    }

    /// Returns true where all is drawn.
    pub fn is_wide(&self) -> bool {
        u32::from(self.count) == FULL
    }

    /// Makes the stipple of a direction that has the weights from `from` to `to` of all, which go from 0 to 1: as wide as its weight, and
    /// beginning where that of the direction before ends, so that few sub-pixels are drawn twice.
    pub(super) fn between(from: f64, to: f64, seed: u64) -> Self {
        let [first, last] = [from, to].map(|weight| shares(TOGETHER * weight));
        Self { first: (first % FULL) as u16, count: (last - first).min(FULL) as u16, seed }
    }

    /// Divides the sub-pixels of this stipple: the first share of them, and the rest.
    pub(super) fn divided(&self, share: f64) -> [Self; 2] {
        let count = (share * f64::from(self.count)).round() as u16;
        let first = Self { count, ..*self };
        let first_of_rest = (u32::from(self.first + count) % FULL) as u16;
        [first, Self { first: first_of_rest, count: self.count - count, ..*self }]
    }

    /// Returns the stipple in the layout of the shaders: where it begins (8 bits), how much is open (9 bits), and the seed (15 bits).
    pub fn word(&self) -> u32 {
        u32::from(self.first) | u32::from(self.count) << 8 | ((self.seed >> 49) as u32) << 17
    }

    /// Returns the sub-pixels of a pixel that are open.
    #[inline]
    pub(super) fn open_at(&self, x: i32, y: i32) -> u16 {
        if self.is_wide() {
            return u16::MAX;
        }
        let pixel = (x as u32 as u64) << 32 | y as u32 as u64;
        let of_pixel = (mixed(self.seed ^ mixed(pixel)) >> 56) as u32;
        let begin = (of_pixel + FULL - u32::from(self.first)) % FULL;
        // Sub-pixel by sub-pixel the order goes on by 16 shares; the first of them is open from the offset within these on.
        let open = (u32::from(self.count) + SUB_PIXEL - 1).saturating_sub(begin % SUB_PIXEL) / SUB_PIXEL;
        OPEN[open as usize][(begin / SUB_PIXEL) as usize]
    }
}

/// Returns a share of a pixel in the steps of stipples.
fn shares(share: f64) -> u32 {
    (f64::from(FULL) * share).round() as u32
}

/// What something is drawn through: stipples of which all have to be open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Stipples {
    /// That of the direction of an image.
    pub of_direction: Stipple,
    /// That of the part of a plant, while it comes or goes.
    pub of_part: Stipple,
}

impl Stipples {
    /// Returns true where all is drawn.
    pub fn are_wide(&self) -> bool {
        self.of_direction.is_wide() && self.of_part.is_wide()
    }

    /// Returns the sub-pixels of a pixel that are open.
    #[inline]
    pub fn open_at(&self, x: i32, y: i32) -> u16 {
        self.of_direction.open_at(x, y) & self.of_part.open_at(x, y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    #[test]
    fn a_stipple_opens_by_one_sub_pixel_after_the_other_from_closed_to_wide() {
        for begin in 0..16 {
            for count in 0..=16 {
                assert_eq!(OPEN[count][begin].count_ones() as usize, count);
                assert_eq!(OPEN[count][begin] & OPEN[16.min(count + 1)][begin], OPEN[count][begin]);
            }
        }
    }

    #[test]
    fn stipples_of_several_directions_are_as_wide_as_their_weights_and_leave_no_sub_pixel_out() {
        let mut rng = Rng::new(7);
        for _ in 0..500 {
            let mut weights = [0.0; 4].map(|_: f64| rng.between(0.0, 1.0));
            let sum: f64 = weights.iter().sum();
            weights.iter_mut().for_each(|weight| *weight /= sum);
            let (mut from, mut all, mut opened) = (0.0, 0u16, 0);
            for weight in weights {
                let open = Stipple::between(from, from + weight, 9).open_at(5, -6);
                // Rounded to a share of a pixel at either end, and to whole sub-pixels.
                assert!(
                    (f64::from(open.count_ones()) - 16.0 * TOGETHER * weight).abs() <= 1.1
                        || open == u16::MAX
                );
                (from, all, opened) = (from + weight, all | open, opened + open.count_ones());
            }
            assert!(all == u16::MAX && opened <= 22, "{weights:?}: {all:016b}, {opened}");
        }
        assert_eq!(Stipple::between(0.0, 1.0, 3).open_at(5, 6), u16::MAX);
        assert_eq!(Stipple::between(0.5, 0.5, 3).open_at(5, 6), 0);
    }

    #[test]
    fn a_stipple_that_is_divided_again_and_again_opens_each_sub_pixel_once() {
        let mut rng = Rng::new(11);
        for seed in 0..200 {
            let (mut rest, mut parts) = (Stipple::wide(seed), Vec::new());
            for _ in 0..4 {
                let [first, others] = rest.divided(rng.unit());
                parts.push(first);
                rest = others;
            }
            parts.push(rest);
            for (x, y) in [(0, 0), (5, -6), (1023, 511)] {
                let open = parts.iter().map(|stipple| stipple.open_at(x, y));
                assert_eq!(open.clone().fold(0, |all, open| all | open), u16::MAX);
                assert_eq!(open.map(u16::count_ones).sum::<u32>(), 16);
            }
        }
        let [all, nothing] = Stipple::wide(5).divided(1.0);
        assert!(all.is_wide() && nothing.is_closed() && nothing.open_at(3, 4) == 0);
        let [nothing, all] = Stipple::wide(5).divided(0.0);
        assert!(all.is_wide() && nothing.is_closed());
    }

    #[test]
    fn a_stipple_that_opens_steadily_changes_few_pixels_at_a_time_and_no_sub_pixel_twice() {
        let pixels = || (0..64).flat_map(|y| (0..64).map(move |x| (x, y)));
        let (mut before, mut most) = (vec![0u16; 64 * 64], 0);
        for step in 0..=FULL {
            let stipple = Stipple::open(f64::from(step) / f64::from(FULL), 9);
            let now: Vec<u16> = pixels().map(|(x, y)| stipple.open_at(x, y)).collect();
            assert!(
                before.iter().zip(&now).all(|(before, now)| before & !now == 0),
                "what is open stays open"
            );
            most = most.max(before.iter().zip(&now).filter(|(before, now)| before != now).count());
            before = now;
        }
        assert!(before.iter().all(|open| *open == u16::MAX));
        // A sixteenth of 4,096 pixels in the mean, 256; six standard deviations more.
        assert!(most < 256 + 6 * 16, "{most}");
    }
}
