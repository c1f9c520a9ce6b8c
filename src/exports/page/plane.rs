//! Bytes of a picture as they are packed: rows less the row before, which leaves zeros where nothing changes.

/// Returns rows of bytes, each less the one before, modulo 256.
pub fn differences(bytes: &[u8], width: usize) -> Vec<u8> {
    let above = std::iter::repeat_n(0, width).chain(bytes.iter().copied());
    bytes.iter().zip(above).map(|(byte, above)| byte.wrapping_sub(above)).collect()
}

/// The cells into which the pixels of a photo fall when it is shown with fewer. Sizes are widths and heights.
#[derive(Debug, Clone, Copy)]
pub struct PhotoCells {
    photo: [usize; 2],
    size: [usize; 2],
}

impl PhotoCells {
    /// Divides a photo into so many cells, at most one a pixel.
    pub fn new(photo: [u32; 2], size: [u32; 2]) -> Self {
        Self { photo: photo.map(|side| side as usize), size: size.map(|side| side as usize) }
    }

    /// Divides a photo into cells of two by two pixels; an odd side is rounded up.
    pub fn halves(photo: [u32; 2]) -> Self {
        Self::new(photo, photo.map(|side| side.div_ceil(2)))
    }

    /// Returns a value of each cell, by rows, which `of` computes from the pixel in its middle and from all of them.
    pub fn map<T>(self, of: impl Fn(usize, &mut dyn Iterator<Item = usize>) -> T) -> Vec<T> {
        let [width, height] = self.photo;
        let first = |along: usize, cell: usize| (cell * self.photo[along]).div_ceil(self.size[along]);
        let middle = |along: usize, cell: usize| (2 * cell + 1) * self.photo[along] / (2 * self.size[along]);
        let mut values = Vec::with_capacity(self.size[0] * self.size[1]);
        for row in 0..self.size[1] {
            let rows = first(1, row)..first(1, row + 1).min(height);
            for column in 0..self.size[0] {
                let columns = first(0, column)..first(0, column + 1).min(width);
                let mut pixels = rows.clone().flat_map(|y| columns.clone().map(move |x| y * width + x));
                values.push(of(middle(1, row) * width + middle(0, column), &mut pixels));
            }
        }
        values
    }

    /// Returns the mean of those values of each cell that `counts` allows; 0 where there are none.
    pub fn means(self, values: &[u8], counts: impl Fn(usize) -> bool) -> Vec<u8> {
        self.map(|_, pixels| mean(pixels.filter(|at| counts(*at)).map(|at| values[at])))
    }
}

/// Returns the mean of values, rounded; 0 of none.
pub fn mean(values: impl Iterator<Item = u8>) -> u8 {
    let (sum, count) = values.fold((0u32, 0u32), |(sum, count), value| (sum + u32::from(value), count + 1));
    (sum + count / 2).checked_div(count).unwrap_or(0) as u8
}

/// Rounds to one of 16 values, of which all but 0 stay above 0.
pub fn in_16_steps(value: u8) -> u8 {
    let step = (u32::from(value) + 8) / 17;
    if value > 0 { (step.max(1) * 17) as u8 } else { 0 }
}

/// Rounds to one of 8 values, likewise: what was filled is known so well.
pub fn in_8_steps(value: u8) -> u8 {
    let step = (u32::from(value) + 17) / 36;
    if value > 0 { (step.max(1) * 36).min(255) as u8 } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_that_repeat_leave_zeros() {
        assert_eq!(differences(&[5, 250, 5, 250, 1, 251], 2), [5, 250, 0, 0, 252, 1]);
    }

    #[test]
    fn halves_count_only_what_they_may() {
        let values = [10, 20, 30, 40, 50, 60];
        let halves = PhotoCells::halves([3, 2]);
        assert_eq!(halves.means(&values, |_| true), [30, 45]);
        assert_eq!(halves.means(&values, |at| at == 4), [50, 0]);
        assert_eq!([0, 1, 9, 128, 255].map(in_16_steps), [0, 17, 17, 136, 255]);
    }

    #[test]
    fn each_pixel_is_in_one_cell_which_has_a_middle_of_its_own() {
        let cells = PhotoCells::new([7, 5], [3, 2]);
        let found = cells.map(|middle, pixels| (middle, pixels.collect::<Vec<_>>()));
        assert!(found.iter().all(|(middle, pixels)| pixels.contains(middle)), "{found:?}");
        let mut all: Vec<usize> = found.into_iter().flat_map(|(_, pixels)| pixels).collect();
        all.sort_unstable();
        assert_eq!(all, (0..35).collect::<Vec<_>>());
        let whole = PhotoCells::new([3, 2], [3, 2]).map(|middle, _| middle);
        assert_eq!(whole, [0, 1, 2, 3, 4, 5]);
    }
}
