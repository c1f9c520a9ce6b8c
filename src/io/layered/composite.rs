//! Composites layers: the picture that an editor shows, and the proof that a stack reproduces its photo.

use super::document::{Layer, LayeredDocument};
use super::raster::Raster;
use crate::error::Result;
use crate::geometry::PixelRect;
use crate::scene::Samples;

/// Composites the layers for which `wanted` holds from bottom to top over transparency, regardless of their
/// visibility. The result has the size of the canvas.
///
/// Uses the over operator of Porter and Duff (1984) on straight alpha; the result is exact, bit for bit,
/// where pixels are opaque or empty.
///
/// # Errors
/// The error of a layer's pixel source.
pub fn composite<'a>(document: &LayeredDocument<'a>, wanted: impl Fn(&Layer<'a>) -> bool) -> Result<Raster> {
    let mut canvas = Raster::blank(document.width, document.height, document.depth);
    for layer in document.layers().filter(|layer| wanted(layer)) {
        lay_over(&mut canvas, &*document.pixels_of(layer)?, layer.rect);
    }
    Ok(canvas)
}

/// Composites `above` over `canvas` with its top-left corner at that of `rect`.
pub fn lay_over(canvas: &mut Raster, above: &Raster, rect: PixelRect) {
    let size = (canvas.width(), canvas.height());
    match (canvas.samples_mut(), above.samples()) {
        (Samples::U8(below), Samples::U8(above)) => over(below, size, above, rect, 255.0),
        (Samples::U16(below), Samples::U16(above)) => over(below, size, above, rect, 65535.0),
        _ => unreachable!("the layers of a document have one depth"),
    }
}

/// A sample that converts to a number and back.
trait Sample: Copy {
    fn number(self) -> f64;
    fn rounded(number: f64) -> Self;
}

impl Sample for u8 {
    fn number(self) -> f64 {
        self.into()
    }
    fn rounded(number: f64) -> Self {
        number.round() as u8
    }
}

impl Sample for u16 {
    fn number(self) -> f64 {
        self.into()
    }
    fn rounded(number: f64) -> Self {
        number.round() as u16
    }
}

fn over<T: Sample>(below: &mut [T], size: (u32, u32), above: &[T], rect: PixelRect, full: f64) {
    let canvas = PixelRect { x: 0, y: 0, w: size.0, h: size.1 };
    let shared = rect.intersection(&canvas);
    for y in shared.y..shared.bottom() {
        let from = 4 * ((y - rect.y) as usize * rect.w as usize + (shared.x - rect.x) as usize);
        let to = 4 * (y as usize * size.0 as usize + shared.x as usize);
        let count = 4 * shared.w as usize;
        let pairs = below[to..to + count].chunks_exact_mut(4).zip(above[from..from + count].chunks_exact(4));
        pairs.for_each(|(below, above)| over_pixel(below, above, full));
    }
}

fn over_pixel<T: Sample>(below: &mut [T], above: &[T], full: f64) {
    let alpha = above[3].number() / full;
    if alpha == 1.0 {
        below.copy_from_slice(above);
    } else if alpha > 0.0 {
        let under = below[3].number() / full * (1.0 - alpha);
        for (b, a) in below[..3].iter_mut().zip(above) {
            *b = T::rounded((a.number() * alpha + b.number() * under) / (alpha + under));
        }
        below[3] = T::rounded((alpha + under) * full);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::layered::Depth;

    fn one(colour: [u8; 4]) -> Raster {
        Raster::new(1, 1, Samples::U8(colour.to_vec()))
    }

    fn over_each_other(below: [u8; 4], above: [u8; 4]) -> Raster {
        let mut canvas = one(below);
        lay_over(&mut canvas, &one(above), PixelRect { x: 0, y: 0, w: 1, h: 1 });
        canvas
    }

    #[test]
    fn an_opaque_pixel_replaces_and_an_empty_one_changes_nothing() {
        assert_eq!(over_each_other([1, 2, 3, 200], [9, 8, 7, 255]), one([9, 8, 7, 255]));
        assert_eq!(over_each_other([1, 2, 3, 200], [9, 8, 7, 0]), one([1, 2, 3, 200]));
    }

    #[test]
    fn half_white_over_black_is_grey() {
        assert_eq!(over_each_other([0, 0, 0, 255], [255, 255, 255, 51]), one([51, 51, 51, 255]));
        assert_eq!(over_each_other([0, 0, 0, 0], [255, 255, 255, 51]), one([255, 255, 255, 51]));
    }

    #[test]
    fn pixels_outside_the_canvas_are_left_out() {
        let mut canvas = Raster::blank(2, 2, Depth::Sixteen);
        let layer = Raster::new(3, 3, Samples::U16(vec![65535; 36]));
        lay_over(&mut canvas, &layer, PixelRect { x: -2, y: 1, w: 3, h: 3 });
        assert_eq!(canvas.coloured_rect(), PixelRect { x: 0, y: 1, w: 1, h: 1 });
        lay_over(&mut canvas, &layer, PixelRect { x: 50, y: 50, w: 3, h: 3 });
        assert_eq!(canvas.coloured_rect(), PixelRect { x: 0, y: 1, w: 1, h: 1 });
    }
}
