//! Rectangles of whole pixels, which may extend beyond the photo.

use glam::DVec2;

/// The pixels `[x, x+w) x [y, y+h)`, y down; x and y may be negative. In files it is `[x, y, w, h]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(from = "[i64; 4]", into = "[i64; 4]")]
pub struct PixelRect {
    /// The left edge, inclusive.
    pub x: i32,
    /// The top edge, inclusive.
    pub y: i32,
    /// The width; 0 for an empty rectangle.
    pub w: u32,
    /// The height; 0 for an empty rectangle.
    pub h: u32,
}

impl PixelRect {
    /// The rectangle without pixels.
    pub const EMPTY: Self = Self::of_size(0, 0);

    /// Makes the rectangle of all pixels of an image of this size, whose corner is (0, 0).
    #[inline]
    pub const fn of_size(w: u32, h: u32) -> Self {
        Self { x: 0, y: 0, w, h }
    }

    /// Makes the rectangle of the one pixel in column `x`, row `y`.
    #[inline]
    pub const fn of_pixel(x: i32, y: i32) -> Self {
        Self { x, y, w: 1, h: 1 }
    }

    /// Makes the rectangle from left, top (inclusive) and right, bottom (exclusive); empty where they are reversed.
    #[inline]
    pub fn from_edges(x0: i32, y0: i32, x1: i32, y1: i32) -> Self {
        Self { x: x0, y: y0, w: x1.saturating_sub(x0).max(0) as u32, h: y1.saturating_sub(y0).max(0) as u32 }
    }

    /// Returns the right edge (exclusive).
    #[inline]
    pub fn right(&self) -> i32 {
        self.x + self.w as i32
    }

    /// Returns the bottom edge (exclusive).
    #[inline]
    pub fn bottom(&self) -> i32 {
        self.y + self.h as i32
    }

    /// Returns the number of pixels.
    #[inline]
    pub fn area(&self) -> u64 {
        u64::from(self.w) * u64::from(self.h)
    }

    /// Returns true when it has no pixels.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.w == 0 || self.h == 0
    }

    /// Returns true when the pixel in column `x`, row `y` is one of its pixels.
    #[inline]
    pub fn contains(&self, x: i32, y: i32) -> bool {
        self.index(x, y).is_some()
    }

    /// Returns true when an image position, in pixels, lies within. The left and the upper edge belong to it, the
    /// others do not.
    #[inline]
    pub fn contains_position(&self, px: DVec2) -> bool {
        let low = DVec2::new(f64::from(self.x), f64::from(self.y));
        let high = low + DVec2::new(f64::from(self.w), f64::from(self.h));
        px.cmpge(low).all() && px.cmplt(high).all()
    }

    /// Returns the index of a pixel in row order, from 0; `None` outside.
    #[inline]
    pub fn index(&self, x: i32, y: i32) -> Option<usize> {
        let (dx, dy) = (i64::from(x) - i64::from(self.x), i64::from(y) - i64::from(self.y));
        let inside = dx >= 0 && dy >= 0 && dx < i64::from(self.w) && dy < i64::from(self.h);
        inside.then(|| dy as usize * self.w as usize + dx as usize)
    }

    /// Returns the index of a pixel in row order, from 0, for loops that stay inside: it has no meaning outside.
    #[inline]
    pub fn offset(&self, x: i32, y: i32) -> usize {
        debug_assert!(self.contains(x, y), "({x}, {y}) is not in {self:?}");
        (y - self.y) as usize * self.w as usize + (x - self.x) as usize
    }

    /// Returns all pixels as pairs of column and row, row by row.
    #[inline]
    pub fn pixels(&self) -> impl Iterator<Item = (i32, i32)> + Clone + use<> {
        let (columns, rows) = (self.x..self.right(), self.y..self.bottom());
        rows.flat_map(move |y| columns.clone().map(move |x| (x, y)))
    }

    /// Returns the smallest rectangle that contains both; one without pixels counts as nothing, wherever it lies.
    #[inline]
    pub fn hull(&self, other: &Self) -> Self {
        match (self.is_empty(), other.is_empty()) {
            (true, _) => *other,
            (_, true) => *self,
            _ => self.union(other),
        }
    }

    /// Returns the smallest rectangle that contains both, also the corner of one without pixels.
    #[inline]
    pub fn union(&self, other: &Self) -> Self {
        Self::from_edges(
            self.x.min(other.x),
            self.y.min(other.y),
            self.right().max(other.right()),
            self.bottom().max(other.bottom()),
        )
    }

    /// Returns the pixels that are in both; empty where they do not overlap.
    #[inline]
    pub fn intersection(&self, other: &Self) -> Self {
        Self::from_edges(
            self.x.max(other.x),
            self.y.max(other.y),
            self.right().min(other.right()),
            self.bottom().min(other.bottom()),
        )
    }

    /// Returns the rectangle grown by `margin` pixels on every side.
    #[inline]
    pub fn grown(&self, margin: u32) -> Self {
        let m = margin as i32;
        Self::from_edges(self.x - m, self.y - m, self.right() + m, self.bottom() + m)
    }
}

impl From<[i64; 4]> for PixelRect {
    fn from([x, y, w, h]: [i64; 4]) -> Self {
        Self { x: x as i32, y: y as i32, w: w as u32, h: h as u32 }
    }
}

impl From<PixelRect> for [i64; 4] {
    fn from(r: PixelRect) -> Self {
        [r.x.into(), r.y.into(), r.w.into(), r.h.into()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RECT: PixelRect = PixelRect { x: -2, y: 3, w: 4, h: 2 };

    #[test]
    fn pixels_are_numbered_row_by_row_and_those_outside_have_no_number() {
        let numbers: Vec<_> = RECT.pixels().map(|(x, y)| RECT.index(x, y)).collect();
        assert_eq!(numbers, (0..8).map(Some).collect::<Vec<_>>());
        assert!(
            RECT.pixels().all(|(x, y)| RECT.contains(x, y) && Some(RECT.offset(x, y)) == RECT.index(x, y))
        );
        for (x, y) in [(-3, 3), (2, 3), (-2, 2), (-2, 5), (i32::MIN, 3), (i32::MAX, i32::MAX)] {
            assert!(!RECT.contains(x, y), "{x}, {y}");
        }
        assert_eq!(PixelRect::EMPTY.pixels().count(), 0);
        let farthest = PixelRect { x: i32::MAX - 1, y: 0, w: 9, h: 1 };
        assert!(farthest.contains(i32::MAX, 0) && !farthest.contains(i32::MIN, 0), "edges beyond 32 bits");
    }

    #[test]
    fn a_position_on_the_lower_edges_is_within_and_one_on_the_upper_edges_is_not() {
        let within = |x, y| RECT.contains_position(DVec2::new(x, y));
        assert!(within(-2.0, 3.0) && within(1.999, 4.999));
        assert!(!within(2.0, 4.0) && !within(0.0, 5.0) && !within(-2.001, 3.0) && !within(f64::NAN, 4.0));
    }

    #[test]
    fn a_hull_leaves_out_what_is_empty_and_a_union_does_not() {
        let far = PixelRect { x: 50, y: 50, w: 0, h: 7 };
        assert_eq!((RECT.hull(&far), far.hull(&RECT)), (RECT, RECT));
        assert_eq!(RECT.union(&far), PixelRect::from_edges(-2, 3, 50, 57));
        assert_eq!(RECT.hull(&PixelRect::of_pixel(9, 9)), PixelRect::from_edges(-2, 3, 10, 10));
    }
}
