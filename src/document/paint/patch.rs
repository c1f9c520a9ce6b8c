//! A patch of paint: some pixels of a photo, each as the artist left it.

use crate::geometry::PixelRect;
use crate::raster::Image;

/// R, G, B, A in 16 bits, alpha not multiplied in; 8 bits are scaled by 257, which loses nothing.
pub type Colour = [u16; 4];

/// A pixel that was painted away: nothing of the surface is to be seen there in this photo.
pub const ERASED: Colour = [u16::MAX, u16::MAX, u16::MAX, 0];

/// Painted pixels within a rectangle of the photo.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Patch {
    /// `None` where nobody painted.
    pixels: Image<Option<Colour>>,
}

impl Patch {
    /// Nothing painted yet in `rect`, which is in photo pixels and may reach outside the photo.
    pub fn new(rect: PixelRect) -> Self {
        Self { pixels: Image::filled(rect, None) }
    }

    /// Where there may be paint.
    pub fn rect(&self) -> PixelRect {
        self.pixels.rect()
    }

    /// All pixels of the rectangle; `None` where nobody painted.
    pub fn pixels(&self) -> &Image<Option<Colour>> {
        &self.pixels
    }

    /// The paint at a pixel; none where nobody painted, and outside the rectangle.
    pub fn at(&self, x: i32, y: i32) -> Option<Colour> {
        self.pixels.get(x, y).copied().flatten()
    }

    /// Paints a pixel within the rectangle. All colours without opacity are [`ERASED`].
    pub fn put(&mut self, x: i32, y: i32, colour: Colour) {
        if let Some(pixel) = self.pixels.get_mut(x, y) {
            *pixel = Some(if colour[3] == 0 { ERASED } else { colour });
        }
    }

    /// Takes the paint off a pixel.
    pub fn clear(&mut self, x: i32, y: i32) {
        if let Some(pixel) = self.pixels.get_mut(x, y) {
            *pixel = None;
        }
    }

    /// Every painted pixel, row by row.
    pub fn iter(&self) -> impl Iterator<Item = (i32, i32, Colour)> {
        self.pixels.iter().filter_map(|((x, y), pixel)| pixel.map(|colour| (x, y, colour)))
    }

    /// Painted pixels.
    pub fn count(&self) -> u64 {
        self.painted().count() as u64
    }

    /// Those that were painted away.
    pub fn erased(&self) -> u64 {
        self.painted().filter(|colour| **colour == ERASED).count() as u64
    }

    /// Nobody painted anything.
    pub fn is_empty(&self) -> bool {
        self.painted().next().is_none()
    }

    /// Only those pixels that `wanted` picks, in the smallest rectangle that holds them.
    pub fn picked(&self, wanted: impl Fn(i32, i32, Colour) -> bool) -> Self {
        let kept: Vec<_> = self.iter().filter(|(x, y, colour)| wanted(*x, *y, *colour)).collect();
        Self::of_pixels(&kept)
    }

    /// These pixels, in the smallest rectangle that holds them.
    pub fn of_pixels(pixels: &[(i32, i32, Colour)]) -> Self {
        let one = |&(x, y, _): &(i32, i32, Colour)| PixelRect::of_pixel(x, y);
        let rect = pixels.iter().map(one).reduce(|a, b| a.union(&b));
        let mut patch = Self::new(rect.unwrap_or(PixelRect::EMPTY));
        pixels.iter().for_each(|(x, y, colour)| patch.put(*x, *y, *colour));
        patch
    }

    /// Both together, `above` on top of this one: a pixel painted twice has the colour of `above`.
    pub fn under(&self, above: &Self) -> Self {
        let mut both = Self::new(self.rect().hull(&above.rect()));
        self.iter().chain(above.iter()).for_each(|(x, y, colour)| both.put(x, y, colour));
        both
    }

    /// True when 8 bits a sample hold it exactly.
    pub fn fits_8_bits(&self) -> bool {
        self.painted().flatten().all(|sample| sample % 257 == 0)
    }

    fn painted(&self) -> impl Iterator<Item = &Colour> {
        self.pixels.pixels().iter().flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: Colour = [65535, 0, 0, 65535];
    const BLUE: Colour = [0, 0, 1000, 40000];

    #[test]
    fn a_pixel_is_found_where_it_was_put_and_nowhere_else() {
        let mut patch = Patch::new(PixelRect { x: -2, y: 3, w: 4, h: 2 });
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
        let patch = Patch::of_pixels(&[(5, 5, [1, 2, 3, 0]), (6, 5, RED)]);
        assert_eq!((patch.at(5, 5), patch.count(), patch.erased()), (Some(ERASED), 2, 1));
    }

    #[test]
    fn of_two_patches_the_upper_one_shows_where_both_have_paint() {
        let below = Patch::of_pixels(&[(0, 0, RED), (1, 0, RED)]);
        let both = below.under(&Patch::of_pixels(&[(1, 0, BLUE), (4, 2, BLUE)]));
        assert_eq!(both.iter().map(|p| p.2).collect::<Vec<_>>(), [RED, BLUE, BLUE]);
        assert_eq!(both.rect(), PixelRect::of_size(5, 3));
        let nothing = Patch::of_pixels(&[]);
        assert_eq!(nothing.under(&below), below);
        assert_eq!(below.under(&nothing), below);
    }

    #[test]
    fn what_is_picked_has_the_smallest_rectangle() {
        let patch = Patch::of_pixels(&[(0, 0, RED), (7, 9, BLUE)]);
        let picked = patch.picked(|_, _, colour| colour == BLUE);
        assert_eq!(picked.rect(), PixelRect { x: 7, y: 9, w: 1, h: 1 });
        assert!(patch.picked(|_, _, _| false).is_empty());
    }
}
