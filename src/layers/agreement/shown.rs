//! Which pixels of a reduced photo show something, so that values are kept of these alone: most photos show little of the sky.

/// Pixels per entry.
const WORD: usize = 64;

/// The pixels of a reduced photo that show something, row by row.
#[derive(Debug, Clone, Default, serde::Serialize, serde::Deserialize)]
pub struct ShownPixels {
    /// One bit for each pixel.
    words: Vec<u64>,
    /// How many pixels before each word show something.
    before: Vec<u32>,
    /// The number of all pixels.
    count: usize,
}

impl ShownPixels {
    /// Keeps which pixels show something, row by row.
    pub fn new(shown: impl Iterator<Item = bool>) -> Self {
        let mut pixels = Self::default();
        let mut sum = 0;
        for is_shown in shown {
            if pixels.count.is_multiple_of(WORD) {
                pixels.words.push(0);
                pixels.before.push(sum);
            }
            let bit = u64::from(is_shown) << (pixels.count % WORD);
            *pixels.words.last_mut().expect("one was pushed for the first bit") |= bit;
            sum += u32::from(is_shown);
            pixels.count += 1;
        }
        pixels
    }

    /// Returns the number of all pixels, those that show nothing included.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Returns how many pixels before one show something, which is the place of its values; `None` where it shows nothing.
    #[inline]
    pub fn place(&self, at: usize) -> Option<usize> {
        let (word, bit) = (self.words[at / WORD], at % WORD);
        let below = word & ((1 << bit) - 1);
        (word >> bit & 1 == 1).then(|| (self.before[at / WORD] + below.count_ones()) as usize)
    }

    /// Returns the pixels that show something, in order.
    pub fn iter(&self) -> impl Iterator<Item = usize> {
        (0..self.count).filter(|at| self.words[at / WORD] >> (at % WORD) & 1 == 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    #[test]
    fn places_count_the_pixels_that_show_something() {
        for (seed, count) in [(1, 0), (2, 1), (3, 63), (4, 64), (5, 65), (6, 1000)] {
            let mut rng = Rng::new(seed);
            let shown: Vec<bool> = (0..count).map(|_| rng.chance(0.3)).collect();
            let pixels = ShownPixels::new(shown.iter().copied());
            assert_eq!(pixels.count(), count);
            let mut place = 0;
            for (at, is_shown) in shown.iter().enumerate() {
                assert_eq!(pixels.place(at), is_shown.then_some(place));
                place += usize::from(*is_shown);
            }
            assert!(pixels.iter().eq((0..count).filter(|at| shown[*at])));
        }
    }
}
