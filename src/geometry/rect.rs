//! Rectangles of whole pixels, which may extend beyond the photo.

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
    /// Makes the rectangle from left, top (inclusive) and right, bottom (exclusive); empty where they are reversed.
    pub fn from_edges(x0: i32, y0: i32, x1: i32, y1: i32) -> Self {
        Self { x: x0, y: y0, w: x1.saturating_sub(x0).max(0) as u32, h: y1.saturating_sub(y0).max(0) as u32 }
    }

    /// Returns the right edge (exclusive).
    pub fn right(&self) -> i32 {
        self.x + self.w as i32
    }

    /// Returns the bottom edge (exclusive).
    pub fn bottom(&self) -> i32 {
        self.y + self.h as i32
    }

    /// Returns the number of pixels.
    pub fn area(&self) -> u64 {
        u64::from(self.w) * u64::from(self.h)
    }

    /// Returns true when it has no pixels.
    pub fn is_empty(&self) -> bool {
        self.w == 0 || self.h == 0
    }

    /// Returns the smallest rectangle that contains both.
    pub fn union(&self, other: &Self) -> Self {
        Self::from_edges(
            self.x.min(other.x),
            self.y.min(other.y),
            self.right().max(other.right()),
            self.bottom().max(other.bottom()),
        )
    }

    /// Returns the pixels that are in both; empty where they do not overlap.
    pub fn intersection(&self, other: &Self) -> Self {
        Self::from_edges(
            self.x.max(other.x),
            self.y.max(other.y),
            self.right().min(other.right()),
            self.bottom().min(other.bottom()),
        )
    }

    /// Returns the rectangle grown by `margin` pixels on every side.
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
