//! Pictures of confidence: the weight of each texel, and how far it is known.

use glam::DVec2;

use quadratura_base::geometry::{Pinhole, PixelRect};
use quadratura_projection::LayerTexturePixels;
use quadratura_projection::confidence::ConfidenceRamp;
use quadratura_projection::pyramid::runs_where;
use quadratura_projection::sources::FILLED;
use quadratura_view::weights::border;

/// The side in pixels of the blocks of which one value is kept.
const BLOCK: u32 = 8;

/// The weights of a layer's texels, one of each block, for choosing photos.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerConfidence {
    rect: PixelRect,
    columns: usize,
    values: Vec<u8>,
}

impl LayerConfidence {
    /// Returns the weight near a position in the photo, in pixels; 0 outside of the layer.
    pub fn at(&self, px: DVec2) -> f64 {
        let (x, y) = (px.x - f64::from(self.rect.x), px.y - f64::from(self.rect.y));
        if x < 0.0 || y < 0.0 || x >= f64::from(self.rect.w) || y >= f64::from(self.rect.h) {
            return 0.0;
        }
        let [x, y] = [x, y].map(|at| (at / f64::from(BLOCK)) as usize);
        self.values.get(y * self.columns + x).map_or(0.0, |value| f64::from(*value) / 255.0)
    }
}

/// Returns the picture of confidence of a layer whose rectangle is `rect`, RGB by rows: red is the weight, confidence with its ramps
/// towards borders of what the photo shows and of the photo, and how far other photos confirm it (`agreement`, of a position in the photo);
/// green is how far the texel is known. Blue is not used. A texel with
/// content has at least 1 in both, because a surface that only this photo shows has to be textured all the same.
pub fn confidence_of(
    pixels: &LayerTexturePixels,
    rect: PixelRect,
    camera: &Pinhole,
    agreement: impl Fn(DVec2) -> f64,
) -> (Vec<u8>, LayerConfidence) {
    let known = pixels.rgba.as_chunks::<4>().0;
    let content = runs_where(pixels.rect, known, |texel| texel[3] != 0);
    let filled = runs_where(pixels.rect, &pixels.needed, |flags| flags & FILLED != 0);
    let mut trust = vec![1.0f32; known.len()];
    ConfidenceRamp::default().each(&content.minus(&filled), |x, y, value| {
        if let Some(at) = pixels.rect.index(x, y) {
            trust[at] = value;
        }
    });
    let mut rgb = vec![0u8; 3 * rect.area() as usize];
    for (y, run) in content.iter() {
        for x in run.clone() {
            let (Some(from), Some(to)) = (pixels.rect.index(x, y), rect.index(x, y)) else { continue };
            let known = known[from][3];
            let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            // The penalty is divided by the agreement, and weights fall with its square; contradicted photos are also taken for
            // ones that are farther away (`quadratura_view::weights::Claim`), which the higher power stands for.
            let weight =
                f64::from(known) * f64::from(trust[from]) * border(camera, px) * agreement(px).powi(4);
            rgb[3 * to] = (weight + 0.5).clamp(1.0, 255.0) as u8;
            rgb[3 * to + 1] = known;
        }
    }
    let reduced = reduced(&rgb, rect);
    (rgb, reduced)
}

/// Keeps the weight in the middle of each block.
fn reduced(rgb: &[u8], rect: PixelRect) -> LayerConfidence {
    let columns = rect.w.div_ceil(BLOCK);
    let middle = |block: u32, side: u32| (block * BLOCK + BLOCK / 2).min(side - 1) as usize;
    let mut values = Vec::new();
    for row in 0..rect.h.div_ceil(BLOCK) {
        let y = middle(row, rect.h) * rect.w as usize;
        values.extend((0..columns).map(|column| rgb[3 * (y + middle(column, rect.w))]));
    }
    LayerConfidence { rect, columns: columns as usize, values }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_rise_from_the_border_and_texels_with_content_have_some() {
        let camera = Pinhole { width: 400, height: 400, fx: 300.0, fy: 300.0, cx: 200.0, cy: 200.0 };
        let (rect, inner) =
            (PixelRect { x: 100, y: 100, w: 64, h: 64 }, PixelRect { x: 110, y: 110, w: 40, h: 40 });
        let mut rgba = vec![255; 4 * inner.area() as usize];
        rgba[3] = 0;
        let pixels =
            LayerTexturePixels { rect: inner, rgba, needed: vec![1; inner.area() as usize], matte: None };
        let (rgb, reduced) = confidence_of(&pixels, rect, &camera, |_| 1.0);
        let red = |x: i32, y: i32| rgb[3 * rect.index(x, y).unwrap()];
        assert_eq!([red(105, 105), red(110, 110)], [0, 0], "nothing is there");
        assert!(red(111, 110) >= 1 && red(112, 130) < red(116, 130), "the ramp is 8 texels wide");
        assert_eq!((red(130, 130), reduced.at(DVec2::new(130.0, 130.0))), (255, 1.0));
        assert_eq!(reduced.at(DVec2::new(99.0, 130.0)), 0.0);
    }
}
