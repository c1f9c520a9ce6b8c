//! The nearest marked pixel of every pixel of a frame.

/// No pixel is marked.
const NONE: u32 = u32::MAX;

/// A distance, in thirds of a pixel, that none is.
const FAR: u32 = u32::MAX / 2;

/// The nearest marked pixel of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NearestMarked {
    /// Its index, row by row.
    index: u32,
    /// Its distance in thirds of a pixel.
    thirds: u32,
}

impl NearestMarked {
    /// Returns the distance in pixels, to 8 %; more than any frame's sides where no pixel is marked.
    pub fn distance_px(self) -> f32 {
        self.thirds as f32 / 3.0
    }

    /// Returns the index of the marked pixel, row by row; `None` where there is none.
    pub fn index(self) -> Option<usize> {
        (self.index != NONE).then_some(self.index as usize)
    }
}

/// Returns the nearest marked pixel of each pixel of a frame, row by row, by two passes over the neighbours (Borgefors 1986,
/// weights 3 and 4).
pub fn nearest(marked: &[bool], width: usize) -> Vec<NearestMarked> {
    let height = marked.len() / width.max(1);
    let own = |(index, is_marked): (u32, &bool)| match is_marked {
        true => NearestMarked { index, thirds: 0 },
        false => NearestMarked { index: NONE, thirds: FAR },
    };
    let mut found: Vec<NearestMarked> = (0..).zip(marked).map(own).collect();
    let mut pass = |order: &mut dyn Iterator<Item = (usize, usize)>, back: isize| {
        for (x, y) in order {
            for (dx, dy, step) in [(back, 0, 3), (-1, back, 4), (0, back, 3), (1, back, 4)] {
                let place = (x.checked_add_signed(dx), y.checked_add_signed(dy));
                let (Some(at_x), Some(at_y)) = place else { continue };
                if at_x < width && at_y < height {
                    let NearestMarked { index, thirds } = found[at_y * width + at_x];
                    if thirds + step < found[y * width + x].thirds {
                        found[y * width + x] = NearestMarked { index, thirds: thirds + step };
                    }
                }
            }
        }
    };
    pass(&mut (0..height).flat_map(|y| (0..width).map(move |x| (x, y))), -1);
    pass(&mut (0..height).rev().flat_map(|y| (0..width).rev().map(move |x| (x, y))), 1);
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_to_the_nearest_mark() {
        let (width, height) = (40usize, 30usize);
        let marks = [(3usize, 4usize), (30, 25), (31, 2)];
        let marked: Vec<bool> =
            (0..width * height).map(|i| marks.contains(&(i % width, i / width))).collect();
        for (i, found) in nearest(&marked, width).into_iter().enumerate() {
            let to = |(x, y): (usize, usize)| {
                let (dx, dy) = ((i % width) as f32 - x as f32, (i / width) as f32 - y as f32);
                dx.hypot(dy)
            };
            let exact = marks.iter().map(|mark| to(*mark)).fold(f32::INFINITY, f32::min);
            // The weights 3 and 4 are off by 8 % at most (Borgefors 1986, table 2).
            assert!(
                (found.distance_px() - exact).abs() <= 0.081 * exact,
                "{found:?} instead of {exact} at {i}"
            );
            let index = found.index().unwrap();
            let of_index = to((index % width, index / width));
            assert!(marked[index] && of_index <= 1.17 * exact, "{index} instead of the one at {exact}");
        }
        let nothing = nearest(&[false; 4], 2);
        assert!(nothing.iter().all(|found| found.index().is_none() && found.distance_px() > 1e8));
    }
}
