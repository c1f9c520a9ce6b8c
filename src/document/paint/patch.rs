//! A patch of paint: some pixels of a photo as they were painted.

use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::Image;

/// R, G, B, A in 16 bits, not premultiplied; 8-bit values are scaled by 257, which is lossless.
pub type PaintColour = [u16; 4];

/// An erased pixel: this photo shows nothing of the surface there.
pub const ERASED: PaintColour = [u16::MAX, u16::MAX, u16::MAX, 0];

/// Painted pixels within a rectangle of the photo.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PaintPatch {
    /// `None` where nothing was painted.
    pixels: Image<Option<PaintColour>>,
}

impl PaintPatch {
    /// Makes an empty patch of `rect`, which is in photo pixels and may extend beyond the photo.
    pub fn new(rect: PixelRect) -> Self {
        Self { pixels: Image::filled(rect, None) }
    }

    /// Returns the rectangle outside of which there is no paint.
    pub fn rect(&self) -> PixelRect {
        self.pixels.rect()
    }

    /// Returns all pixels of the rectangle; `None` where nothing was painted.
    pub fn pixels(&self) -> &Image<Option<PaintColour>> {
        &self.pixels
    }

    /// Returns the paint at a pixel; `None` where nothing was painted, and outside the rectangle.
    pub fn at(&self, x: i32, y: i32) -> Option<PaintColour> {
        self.pixels.get(x, y).copied().flatten()
    }

    /// Paints a pixel within the rectangle. All colours with zero opacity become [`ERASED`].
    pub fn put(&mut self, x: i32, y: i32, colour: PaintColour) {
        if let Some(pixel) = self.pixels.get_mut(x, y) {
            *pixel = Some(if colour[3] == 0 { ERASED } else { colour });
        }
    }

    /// Removes the paint of a pixel.
    pub fn clear(&mut self, x: i32, y: i32) {
        if let Some(pixel) = self.pixels.get_mut(x, y) {
            *pixel = None;
        }
    }

    /// Iterates over the painted pixels with their colours, row by row.
    pub fn iter(&self) -> impl Iterator<Item = (i32, i32, PaintColour)> {
        self.pixels.iter().filter_map(|((x, y), pixel)| pixel.map(|colour| (x, y, colour)))
    }

    /// Returns the number of painted pixels.
    pub fn count(&self) -> u64 {
        self.painted().count() as u64
    }

    /// Returns the number of erased pixels.
    pub fn erased(&self) -> u64 {
        self.painted().filter(|colour| **colour == ERASED).count() as u64
    }

    /// Returns true when nothing was painted.
    pub fn is_empty(&self) -> bool {
        self.painted().next().is_none()
    }

    /// Returns the pixels for which `wanted` is true, in their bounding box.
    pub fn picked(&self, wanted: impl Fn(i32, i32, PaintColour) -> bool) -> Self {
        let kept: Vec<_> = self.iter().filter(|(x, y, colour)| wanted(*x, *y, *colour)).collect();
        Self::of_pixels(&kept)
    }

    /// Makes a patch of these pixels, in their bounding box.
    pub fn of_pixels(pixels: &[(i32, i32, PaintColour)]) -> Self {
        let one = |&(x, y, _): &(i32, i32, PaintColour)| PixelRect::of_pixel(x, y);
        let rect = pixels.iter().map(one).reduce(|a, b| a.union(&b));
        let mut patch = Self::new(rect.unwrap_or(PixelRect::EMPTY));
        pixels.iter().for_each(|(x, y, colour)| patch.put(*x, *y, *colour));
        patch
    }

    /// Returns this patch with `above` on top: a pixel painted in both has the colour of `above`.
    pub fn under(&self, above: &Self) -> Self {
        let mut both = Self::new(self.rect().hull(&above.rect()));
        self.iter().chain(above.iter()).for_each(|(x, y, colour)| both.put(x, y, colour));
        both
    }

    /// Returns true when 8 bits per sample represent it exactly.
    pub fn fits_8_bits(&self) -> bool {
        self.painted().flatten().all(|sample| sample % 257 == 0)
    }

    /// Returns the index of a pixel; `None` outside the rectangle.
    fn painted(&self) -> impl Iterator<Item = &PaintColour> {
        self.pixels.pixels().iter().flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: PaintColour = [65535, 0, 0, 65535];
    const BLUE: PaintColour = [0, 0, 1000, 40000];

    #[test]
    fn a_pixel_is_found_where_it_was_put_and_nowhere_else() {
        let mut patch = PaintPatch::new(PixelRect { x: -2, y: 3, w: 4, h: 2 });
        patch.put(-2, 3, RED);
        patch.put(1, 4, BLUE);
        patch.put(2, 4, BLUE);
        assert_eq!(
            (patch.at(-2, 3), patch.at(1, 4), patch.at(2, 4), patch.at(0, 3)),
            (Some(RED), Some(BLUE), None, None)
        );
        assert_eq!(patch.iter().collect::<Vec<_>>(), [(-2, 3, RED), (1, 4, BLUE)]);
        assert_eq!((patch.count(), patch.fits_8_bits()), (2, false));
    }

    #[test]
    fn colour_without_opacity_is_paint_taken_away() {
        let patch = PaintPatch::of_pixels(&[(5, 5, [1, 2, 3, 0]), (6, 5, RED)]);
        assert_eq!((patch.at(5, 5), patch.count(), patch.erased()), (Some(ERASED), 2, 1));
    }

    #[test]
    fn of_two_patches_the_upper_one_shows_where_both_have_paint() {
        let below = PaintPatch::of_pixels(&[(0, 0, RED), (1, 0, RED)]);
        let both = below.under(&PaintPatch::of_pixels(&[(1, 0, BLUE), (4, 2, BLUE)]));
        assert_eq!(both.iter().map(|p| p.2).collect::<Vec<_>>(), [RED, BLUE, BLUE]);
        assert_eq!(both.rect(), PixelRect::of_size(5, 3));
        let nothing = PaintPatch::of_pixels(&[]);
        assert_eq!(nothing.under(&below), below);
        assert_eq!(below.under(&nothing), below);
    }

    #[test]
    fn what_is_picked_has_the_smallest_rectangle() {
        let patch = PaintPatch::of_pixels(&[(0, 0, RED), (7, 9, BLUE)]);
        let picked = patch.picked(|_, _, colour| colour == BLUE);
        assert_eq!(picked.rect(), PixelRect { x: 7, y: 9, w: 1, h: 1 });
        assert!(patch.picked(|_, _, _| false).is_empty());
    }
}
