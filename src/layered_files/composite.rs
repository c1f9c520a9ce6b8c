//! Composites layers: the picture that an editor shows, and the proof that a stack reproduces its photo.

use super::document::{LayeredDocument, PixelLayer};
use super::raster::Raster;
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::Sample;
use quadratura_base::raster::over::straight;
use quadratura_base::scene::Samples;

/// Composites the layers for which `wanted` holds from bottom to top over transparency, regardless of their
/// visibility. The result has the size of the canvas.
///
/// Uses the over operator of Porter and Duff (1984) on straight alpha; the result is exact, bit for bit,
/// where pixels are opaque or empty.
///
/// # Errors
/// The error of a layer's pixel source.
pub fn composite<'a>(
    document: &LayeredDocument<'a>,
    wanted: impl Fn(&PixelLayer<'a>) -> bool,
) -> Result<Raster> {
    let mut canvas = Raster::blank(document.width, document.height, document.depth);
    for layer in document.layers().filter(|layer| wanted(layer)) {
        lay_over(&mut canvas, &*document.pixels_of(layer)?, layer.rect);
    }
    Ok(canvas)
}

/// Composites `above` over `canvas` with its top-left corner at that of `rect`.
pub fn lay_over(canvas: &mut Raster, above: &Raster, rect: PixelRect) {
    let whole = PixelRect::of_size(canvas.width(), canvas.height());
    match (canvas.samples_mut(), above.samples()) {
        (Samples::U8(below), Samples::U8(above)) => over(below, whole, above, rect),
        (Samples::U16(below), Samples::U16(above)) => over(below, whole, above, rect),
        _ => unreachable!("the layers of a document have one depth"),
    }
}

fn over<T: Sample>(below: &mut [T], canvas: PixelRect, above: &[T], rect: PixelRect) {
    let (below, above) = (below.as_chunks_mut::<4>().0, above.as_chunks::<4>().0);
    let shared = rect.intersection(&canvas);
    for y in shared.y..shared.bottom() {
        let (to, from) = (canvas.offset(shared.x, y), rect.offset(shared.x, y));
        let count = shared.w as usize;
        let pairs = below[to..to + count].iter_mut().zip(&above[from..from + count]);
        pairs.for_each(|(below, above)| straight(below, above));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Depth;

    fn one(colour: [u8; 4]) -> Raster {
        Raster::new(1, 1, Samples::U8(colour.to_vec()))
    }

    fn over_each_other(below: [u8; 4], above: [u8; 4]) -> Raster {
        let mut canvas = one(below);
        lay_over(&mut canvas, &one(above), PixelRect::of_size(1, 1));
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
