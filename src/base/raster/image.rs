//! An image is the pixels of a rectangle, row by row from the top.

use crate::geometry::PixelRect;

/// The pixels of a rectangle, all of one format. `P` is the format: `[u8; 4]` for RGBA, `[f32; 3]` for light, `bool`
/// for a set.
///
/// The rectangle may lie anywhere: an image layer's lies in its photo, and may reach outside of it. Rows are from the
/// top, pixels in a row from the left, without gaps.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Image<P> {
    rect: PixelRect,
    pixels: Vec<P>,
}

impl<P> Image<P> {
    /// Makes an image of the pixels of `rect`, row by row.
    ///
    /// # Panics
    /// When their number is not the rectangle's area.
    #[inline]
    pub fn new(rect: PixelRect, pixels: Vec<P>) -> Self {
        assert_eq!(pixels.len() as u64, rect.area(), "pixels of {rect:?}");
        Self { rect, pixels }
    }

    /// Makes an image whose pixels are computed from column and row.
    #[inline]
    pub fn from_fn(rect: PixelRect, pixel: impl FnMut((i32, i32)) -> P) -> Self {
        Self { rect, pixels: rect.pixels().map(pixel).collect() }
    }

    /// Returns the rectangle of the pixels.
    #[inline]
    pub fn rect(&self) -> PixelRect {
        self.rect
    }

    /// Returns the numbers of columns and of rows.
    #[inline]
    pub fn size(&self) -> [usize; 2] {
        [self.rect.w as usize, self.rect.h as usize]
    }

    /// Returns all pixels, row by row.
    #[inline]
    pub fn pixels(&self) -> &[P] {
        &self.pixels
    }

    /// Returns all pixels, row by row, to change them.
    #[inline]
    pub fn pixels_mut(&mut self) -> &mut [P] {
        &mut self.pixels
    }

    /// Turns the image into its pixels, row by row.
    #[inline]
    pub fn into_pixels(self) -> Vec<P> {
        self.pixels
    }

    /// Returns the pixel in column `x`, row `y`; `None` outside.
    #[inline]
    pub fn get(&self, x: i32, y: i32) -> Option<&P> {
        self.rect.index(x, y).map(|index| &self.pixels[index])
    }

    /// Returns the pixel in column `x`, row `y`, to change it; `None` outside.
    #[inline]
    pub fn get_mut(&mut self, x: i32, y: i32) -> Option<&mut P> {
        self.rect.index(x, y).map(|index| &mut self.pixels[index])
    }

    /// Makes an image of the same rectangle by changing each pixel, perhaps to another format.
    pub fn map<Q>(&self, change: impl FnMut(&P) -> Q) -> Image<Q> {
        Image { rect: self.rect, pixels: self.pixels.iter().map(change).collect() }
    }

    /// Iterates over the pixels with their column and row, row by row.
    #[inline]
    pub fn iter(&self) -> impl Iterator<Item = ((i32, i32), &P)> {
        self.rect.pixels().zip(&self.pixels)
    }
}

impl<P: Clone> Image<P> {
    /// Makes an image with the same pixel everywhere.
    #[inline]
    pub fn filled(rect: PixelRect, pixel: P) -> Self {
        Self { rect, pixels: vec![pixel; rect.area() as usize] }
    }
}

/// A set of pixels within a rectangle.
impl Image<bool> {
    /// Returns true when a pixel is in the set; pixels outside the rectangle never are.
    #[inline]
    pub fn holds(&self, x: i32, y: i32) -> bool {
        self.get(x, y) == Some(&true)
    }

    /// Adds a pixel to the set or removes it; has no effect outside the rectangle.
    #[inline]
    pub fn put(&mut self, x: i32, y: i32, within: bool) {
        if let Some(pixel) = self.get_mut(x, y) {
            *pixel = within;
        }
    }

    /// Iterates over the pixels in the set, row by row: column and row.
    #[inline]
    pub fn held(&self) -> impl Iterator<Item = (i32, i32)> {
        self.iter().filter(|(_, within)| **within).map(|(pixel, _)| pixel)
    }

    /// Returns the number of pixels in the set.
    #[inline]
    pub fn count(&self) -> u64 {
        self.pixels.iter().filter(|within| **within).count() as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RECT: PixelRect = PixelRect { x: -1, y: 5, w: 3, h: 2 };

    #[test]
    fn a_pixel_is_found_where_it_was_put_and_nothing_outside() {
        let mut image = Image::from_fn(RECT, |(x, y)| 10 * y + x);
        assert_eq!(image.pixels(), [49, 50, 51, 59, 60, 61]);
        assert_eq!((image.get(1, 6), image.get(2, 6), image.get(-1, 4)), (Some(&61), None, None));
        assert_eq!(image.map(|pixel| pixel % 10 == 0).held().collect::<Vec<_>>(), [(0, 5), (0, 6)]);
        *image.get_mut(0, 5).unwrap() = 7;
        assert_eq!(image.iter().nth(1), Some(((0, 5), &7)));
        assert_eq!((image.size(), image.into_pixels().len()), ([3, 2], 6));
    }

    #[test]
    fn a_set_holds_what_was_put_in() {
        let mut set = Image::filled(RECT, false);
        set.put(0, 6, true);
        set.put(1, 5, true);
        set.put(2, 5, true);
        set.put(1, 5, false);
        assert!(set.holds(0, 6) && !set.holds(1, 5) && !set.holds(2, 5));
        assert_eq!((set.held().collect::<Vec<_>>(), set.count()), (vec![(0, 6)], 1));
    }

    #[test]
    #[should_panic(expected = "pixels of")]
    fn an_image_has_as_many_pixels_as_its_rectangle() {
        Image::new(RECT, vec![0; 5]);
    }
}
