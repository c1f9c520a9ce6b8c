//! Images at half their size: which pixels make up one of the half. What their mean is, the caller says: of light or of
//! stored values, of all or of those that are valid.

use rayon::prelude::*;

use super::Image;
use crate::geometry::PixelRect;

/// The rule for the last column or row of a side of odd length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OddSide {
    /// It is dropped, so that positions in the half are exactly halves of positions in the whole.
    Dropped,
    /// It makes up pixels of the half alone: those stand for two pixels, or for one.
    Alone,
    /// It counts twice: every pixel of the half stands for four.
    Twice,
}

impl OddSide {
    /// Returns the length of half a side.
    #[inline]
    pub fn half(self, side: usize) -> usize {
        match self {
            Self::Dropped => side / 2,
            Self::Alone | Self::Twice => side.div_ceil(2),
        }
    }

    /// Returns the columns and rows of half an image.
    #[inline]
    pub fn half_size(self, size: [usize; 2]) -> [usize; 2] {
        size.map(|side| self.half(side))
    }
}

/// Computes the pixels of the half of an image of `size` columns and rows, row by row, on all threads. `mean` makes one
/// pixel of the indices, in row order, of those that it stands for: from the left, the upper row first.
pub fn halved<T: Send>(size: [usize; 2], odd: OddSide, mean: impl Fn(&[usize]) -> T + Sync) -> Vec<T> {
    let [width, height] = size;
    let [columns, rows] = odd.half_size(size);
    let mean = &mean;
    let row = |y: usize| {
        let first = 2 * y * width;
        let is_whole = 2 * y + 1 < height;
        (0..columns).map(move |x| {
            let at = first + 2 * x;
            if is_whole && 2 * x + 1 < width {
                return mean(&[at, at + 1, at + width, at + width + 1]);
            }
            let right = (2 * x + 1 < width).then_some(at + 1);
            let below = is_whole.then_some(at + width);
            match (odd, right, below) {
                (OddSide::Twice, ..) => {
                    let (right, below) = (right.unwrap_or(at), below.unwrap_or(at));
                    mean(&[at, right, below, below + right - at])
                }
                (_, Some(other), _) | (_, _, Some(other)) => mean(&[at, other]),
                _ => mean(&[at]),
            }
        })
    };
    (0..rows).into_par_iter().flat_map_iter(row).collect()
}

impl<P> Image<P> {
    /// Makes the half of the image, with its corner at (0, 0), as [`halved`] does.
    pub fn halved<T: Send>(&self, odd: OddSide, mean: impl Fn(&[usize]) -> T + Sync) -> Image<T> {
        let [width, height] = odd.half_size(self.size());
        Image::new(PixelRect::of_size(width as u32, height as u32), halved(self.size(), odd, mean))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(size: [usize; 2], odd: OddSide) -> Vec<Vec<usize>> {
        halved(size, odd, <[usize]>::to_vec)
    }

    #[test]
    fn of_even_sides_every_rule_takes_the_same_four() {
        for odd in [OddSide::Dropped, OddSide::Alone, OddSide::Twice] {
            assert_eq!(places([4, 2], odd), [[0, 1, 4, 5], [2, 3, 6, 7]]);
        }
    }

    #[test]
    fn an_odd_column_and_row_are_dropped_stand_alone_or_count_twice() {
        assert_eq!(places([3, 3], OddSide::Dropped), [[0, 1, 3, 4]]);
        let alone = [vec![0, 1, 3, 4], vec![2, 5], vec![6, 7], vec![8]];
        assert_eq!(places([3, 3], OddSide::Alone), alone);
        let twice = [[0, 1, 3, 4], [2, 2, 5, 5], [6, 7, 6, 7], [8; 4]];
        assert_eq!(places([3, 3], OddSide::Twice), twice);
        assert_eq!(places([1, 4], OddSide::Dropped), Vec::<Vec<usize>>::new());
        assert_eq!(OddSide::Alone.half_size([1, 5]), [1, 3]);
    }
}
