//! Paint on see-through layers: its alpha is their matte.

use crate::layer_pixels::shown;
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::in_8_bits;
use quadratura_document::paint::PaintPatch;
use quadratura_projection::sources::{BLEED, COVERED};

/// Puts paint on texels of a see-through layer: known like the photo where faces cover them, and as solid as it was
/// painted; elsewhere only its colour is kept, for filtering.
pub(super) fn lay_see_through_paint(
    rgba: &mut [u8],
    needed: &mut [u8],
    matte: &mut [u8],
    rect: PixelRect,
    paint: &PaintPatch,
) {
    for (x, y, colour) in paint.iter() {
        let Some(at) = rect.index(x, y) else { continue };
        let [r, g, b, alpha] = shown(colour).map(in_8_bits);
        let covered = needed[at] & COVERED != 0;
        let texel = &mut rgba[4 * at..4 * at + 4];
        if alpha > 0 {
            texel[..3].copy_from_slice(&[r, g, b]);
        }
        texel[3] = if covered { u8::MAX } else { 0 };
        matte[at] = alpha;
        needed[at] = if covered || alpha == 0 { needed[at] & COVERED } else { BLEED };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_document::paint::ERASED;
    use quadratura_projection::sources::FILLED;

    #[test]
    fn what_is_erased_is_known_to_be_empty_and_soft_paint_is_half_see_through() {
        let rect = PixelRect { x: 3, y: 0, w: 4, h: 1 };
        let mut rgba = [[9, 9, 9, 255], [9, 9, 9, 40], [9, 9, 9, 255], [9, 9, 9, 0]].concat();
        let mut needed = [COVERED, COVERED | FILLED, COVERED, 0];
        let mut matte = [255, 70, 255, 255];
        let soft = [65535, 0, 0, 128 * 257];
        let paint = PaintPatch::of_pixels(&[(3, 0, ERASED), (4, 0, soft), (6, 0, soft), (9, 0, soft)]);
        lay_see_through_paint(&mut rgba, &mut needed, &mut matte, rect, &paint);
        assert_eq!(rgba, [[9, 9, 9, 255], [255, 0, 0, 255], [9, 9, 9, 255], [255, 0, 0, 0]].concat());
        assert_eq!((needed, matte), ([COVERED, COVERED, COVERED, BLEED], [0, 128, 255, 128]));
    }
}
