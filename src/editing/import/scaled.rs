//! Import of scaled documents: their paint is resampled to the photo's size.
//!
//! No pixel of a scaled image is as it was, and the filter is unknown. So a pixel counts as paint only where it is
//! outside the range of all colours that its neighbourhood had before: filters mix neighbours, and overshoot a
//! little. Faint paint is lost by this, which is why it is done on request only.

use glam::DVec2;

use super::compare::PlacedRaster;
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::bilinear::BilinearCorner;
use quadratura_document::paint::{ERASED, PaintColour, PaintPatch};
use quadratura_layered_files::Raster;

/// The distance from the neighbourhood's range, of 65535, from which on a colour counts as paint: sharpening
/// filters overshoot by a tenth of a step in brightness, which is rarely more than half of the range.
const BEYOND: u16 = 20 * 257;

/// Resamples a raster of the canvas to the photo's size, bilinearly, which suits doubled and halved images. Returns
/// it with its rectangle in photo pixels. Alpha is not premultiplied.
pub fn unscaled(pixels: &Raster, rect: PixelRect, scale: f64) -> (Raster, PixelRect) {
    let low = |edge: i32| (f64::from(edge) / scale).floor() as i32;
    let high = |edge: i32| (f64::from(edge) / scale).ceil() as i32;
    let at = PixelRect::from_edges(low(rect.x), low(rect.y), high(rect.right()), high(rect.bottom()));
    let mut out = Raster::blank(at.w, at.h, pixels.depth());
    for y in 0..at.h {
        for x in 0..at.w {
            let u = (f64::from(at.x) + f64::from(x) + 0.5) * scale - f64::from(rect.x);
            let v = (f64::from(at.y) + f64::from(y) + 0.5) * scale - f64::from(rect.y);
            out.set_rgba16(x, y, between(pixels, DVec2::new(u, v)));
        }
    }
    (out, at)
}

/// Interpolates the colour at a position; transparent outside.
fn between(pixels: &Raster, px: DVec2) -> PaintColour {
    let whole = PixelRect::of_size(pixels.width(), pixels.height());
    let mut sum = [0.0; 3];
    let mut alpha = 0.0;
    for (x, y, weight) in
        BilinearCorner::from_px(px).taps().into_iter().filter(|(x, y, _)| whole.contains(*x, *y))
    {
        let colour = pixels.rgba16(x as u32, y as u32);
        let weight = weight * f64::from(colour[3]);
        (0..3).for_each(|i| sum[i] += weight * f64::from(colour[i]));
        alpha += weight;
    }
    let colour = |i: usize| if alpha > 0.0 { (sum[i] / alpha).round() as u16 } else { 0 };
    [colour(0), colour(1), colour(2), alpha.round() as u16]
}

/// Returns the paint on a layer that was scaled by `scale` and is resampled to the photo's size.
pub fn repainted(base: PlacedRaster, found: PlacedRaster, scale: f64) -> PaintPatch {
    // Filters with three lobes reach three pixels of the coarser image.
    let reach = (3.0 / scale.min(1.0)).ceil() as i32;
    let rect = if base.rect.is_empty() { found.rect } else { base.rect.union(&found.rect) };
    let mut painted = Vec::new();
    for (x, y) in rect.pixels() {
        let colour = found.at(x, y);
        if colour != base.at(x, y) && is_paint(base, colour, x, y, reach) {
            painted.push((x, y, if colour[3] == 0 { ERASED } else { colour }));
        }
    }
    PaintPatch::of_pixels(&painted)
}

/// Returns true when a colour is outside the range of its neighbourhood before.
fn is_paint(base: PlacedRaster, colour: PaintColour, x: i32, y: i32, reach: i32) -> bool {
    let (mut low, mut high): (PaintColour, PaintColour) = ([u16::MAX; 4], [0; 4]);
    for v in y - reach..=y + reach {
        for u in x - reach..=x + reach {
            let near = base.at(u, v);
            (low[3], high[3]) = (low[3].min(near[3]), high[3].max(near[3]));
            if near[3] > 0 {
                (0..3).for_each(|i| (low[i], high[i]) = (low[i].min(near[i]), high[i].max(near[i])));
            }
        }
    }
    let outside =
        |i: usize| colour[i] < low[i].saturating_sub(BEYOND) || colour[i] > high[i].saturating_add(BEYOND);
    outside(3) || (colour[3] > BEYOND && high[3] > 0 && (0..3).any(outside))
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_layered_files::Depth;

    fn gradient(side: u32) -> Raster {
        let mut raster = Raster::blank(side, side, Depth::Eight);
        let shade = |x: u32, y: u32| (x * 40000 / side + y * 20000 / side) as u16;
        for y in 0..side {
            (0..side).for_each(|x| raster.set_rgba16(x, y, [shade(x, y), shade(x, y), 0, 65535]));
        }
        raster
    }

    fn square(side: u32) -> PixelRect {
        PixelRect::of_size(side, side)
    }

    #[test]
    fn an_image_scaled_to_twice_or_half_its_size_comes_back_without_paint() {
        let base = gradient(40);
        for side in [80, 20] {
            let (scaled, _) = unscaled(&base, square(40), 40.0 / f64::from(side));
            assert_eq!(scaled.width(), side);
            let scale = f64::from(side) / 40.0;
            let (back, at) = unscaled(&scaled, square(side), scale);
            let placed = PlacedRaster { rect: square(40), pixels: &base };
            let painted = repainted(placed, PlacedRaster { rect: at, pixels: &back }, scale);
            assert_eq!(painted.count(), 0, "{side}");
        }
    }

    #[test]
    fn a_red_square_painted_on_the_scaled_image_comes_back_red_in_its_place() {
        let base = gradient(40);
        let (mut scaled, _) = unscaled(&base, square(40), 0.5);
        (20..40).for_each(|y| (20..40).for_each(|x| scaled.set_rgba16(x, y, [65535, 0, 65535, 65535])));
        let (back, at) = unscaled(&scaled, square(80), 2.0);
        let placed = PlacedRaster { rect: square(40), pixels: &base };
        let painted = repainted(placed, PlacedRaster { rect: at, pixels: &back }, 2.0);
        assert_eq!(painted.rect(), PixelRect { x: 10, y: 10, w: 10, h: 10 });
        assert_eq!((painted.count(), painted.at(15, 15)), (100, Some([65535, 0, 65535, 65535])));
    }
}
