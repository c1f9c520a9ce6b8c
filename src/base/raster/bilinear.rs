//! Bilinear interpolation: the four pixels about a position, and how much each counts. Positions are in pixels; the
//! centre of the first pixel is at (0.5, 0.5).

use glam::DVec2;

/// The four pixels about a position, wherever it is: those outside the image are the caller's to judge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BilinearCorner {
    /// The column and the row of the upper left one.
    pub first: [i32; 2],
    /// The distance of the position from its centre, across and down, in pixels: 0 to 1.
    pub share: DVec2,
}

impl BilinearCorner {
    /// Finds the four pixels about a position.
    #[inline]
    pub fn from_px(px: DVec2) -> Self {
        let at = px - 0.5;
        let first = at.floor();
        Self { first: [first.x as i32, first.y as i32], share: at - first }
    }

    /// Returns column, row and weight of each, column by column; the weights add up to 1.
    #[inline]
    pub fn taps(&self) -> [(i32, i32, f64); 4] {
        let [x, y] = self.first;
        let (right, below) = (x.saturating_add(1), y.saturating_add(1));
        let [(u0, u1), (v0, v1)] = [self.share.x, self.share.y].map(|share| (1.0 - share, share));
        [(x, y, u0 * v0), (x, below, u0 * v1), (right, y, u1 * v0), (right, below, u1 * v1)]
    }
}

/// The four pixels about a position in an image whose border is repeated outwards without end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clamped {
    columns: [usize; 2],
    rows: [usize; 2],
    share: [f32; 2],
}

impl Clamped {
    /// Finds the four pixels about a position in an image of `size` columns and rows, one at least.
    #[inline]
    pub fn new(px: DVec2, size: [usize; 2]) -> Self {
        let last = size.map(|count| count - 1);
        let at = (px - 0.5).clamp(DVec2::ZERO, DVec2::new(last[0] as f64, last[1] as f64));
        let (x, y) = (at.x as usize, at.y as usize);
        Self {
            columns: [x, (x + 1).min(last[0])],
            rows: [y, (y + 1).min(last[1])],
            share: [(at.x - x as f64) as f32, (at.y - y as f64) as f32],
        }
    }

    /// Interpolates between the values that `value` returns for column and row: across first, then down.
    #[inline]
    pub fn mix(&self, value: impl Fn(usize, usize) -> f32) -> f32 {
        let ([x0, x1], [y0, y1], [sx, sy]) = (self.columns, self.rows, self.share);
        let above = value(x0, y0) * (1.0 - sx) + value(x1, y0) * sx;
        let below = value(x0, y1) * (1.0 - sx) + value(x1, y1) * sx;
        above * (1.0 - sy) + below * sy
    }

    /// Returns column, row and weight of each, row by row; the weights add up to 1.
    #[inline]
    pub fn taps(&self) -> [(usize, usize, f32); 4] {
        let ([x0, x1], [y0, y1], [sx, sy]) = (self.columns, self.rows, self.share);
        [
            (x0, y0, (1.0 - sx) * (1.0 - sy)),
            (x1, y0, sx * (1.0 - sy)),
            (x0, y1, (1.0 - sx) * sy),
            (x1, y1, sx * sy),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plane over the pixels of a grid: bilinear interpolation keeps it exactly.
    fn ramp(x: f64, y: f64) -> f64 {
        3.0 * x - 0.25 * y + 1.0
    }

    #[test]
    fn a_ramp_is_met_between_pixels_by_both_and_held_at_the_border_by_one() {
        let size = [7, 5];
        for (x, y) in [(0.5, 0.5), (3.25, 2.0), (6.5, 4.5), (1.75, 4.25)] {
            let expected = ramp(x - 0.5, y - 0.5);
            let corner = BilinearCorner::from_px(DVec2::new(x, y)).taps();
            let found: f64 = corner.iter().map(|(x, y, w)| w * ramp(f64::from(*x), f64::from(*y))).sum();
            assert!((found - expected).abs() < 1e-12, "{found} at {x}, {y}");
            let clamped = Clamped::new(DVec2::new(x, y), size);
            let mixed = f64::from(clamped.mix(|x, y| ramp(x as f64, y as f64) as f32));
            // Values and weights are multiples of 1/64: exact in 24 bits.
            assert_eq!(mixed, expected);
            let taps = clamped.taps().map(|(x, y, w)| f64::from(w) * ramp(x as f64, y as f64));
            assert_eq!(taps.iter().sum::<f64>(), expected);
        }
        let beyond = Clamped::new(DVec2::new(-9.0, 99.0), size);
        assert_eq!(beyond.mix(|x, y| ramp(x as f64, y as f64) as f32), ramp(0.0, 4.0) as f32);
    }

    #[test]
    fn at_a_pixels_centre_it_alone_counts() {
        let taps = BilinearCorner::from_px(DVec2::new(-1.5, 2.5)).taps();
        assert_eq!(taps.map(|tap| tap.2), [1.0, 0.0, 0.0, 0.0]);
        assert_eq!((taps[0].0, taps[0].1, taps[3].0, taps[3].1), (-2, 2, -1, 3));
        assert_eq!(Clamped::new(DVec2::new(0.5, 0.5), [1, 1]).taps()[3], (0, 0, 0.0));
    }
}
