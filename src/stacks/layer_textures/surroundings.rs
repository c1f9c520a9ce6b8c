//! The trust in a photo's surroundings beside outlines: there the photo shows what the model lacks, such as the rim
//! of a roof, which would be a line in the sky of other views.

use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::steps::steps_inside;
use quadratura_layers::fill::MOST_CONFIDENCE;

/// The side of the squares of texels that share a distance.
const SQUARE: usize = 4;

/// The width of the ramp beside outlines, as a share of the photo's longer side.
pub const WIDTH: f64 = 0.005;

/// The least alpha: a photo's own camera still shows it.
const LEAST: u8 = 3;

/// Lowers the alpha of opaque texels beside transparent ones, by the square of their distance as a share of the
/// ramp's width. What the photo shows through see-through surfaces is transparent and has, some pixels beside what is
/// shown of them, a confidence of filling above that of anything filled: no outline is there. `rect` are the texels' photo pixels, `longest` is the photo's longer side.
pub(super) fn lower_beside_outlines(rgba: &mut [u8], filled: Option<&[u16]>, rect: PixelRect, longest: u32) {
    let [width, height] = [rect.w as usize, rect.h as usize];
    let [columns, rows] = [width, height].map(|side| side.div_ceil(SQUARE));
    let mut shown = vec![true; columns * rows];
    let (texels, _) = rgba.as_chunks_mut::<4>();
    let seen_through =
        |at: usize| filled.is_some_and(|filled| f32::from(filled[at]) > 255.0 * MOST_CONFIDENCE);
    for (at, _) in texels.iter().enumerate().filter(|(at, texel)| texel[3] == 0 && !seen_through(*at)) {
        shown[at / width / SQUARE * columns + at % width / SQUARE] = false;
    }
    let distances = steps_inside(&shown, [columns, rows]);
    let ramp = (WIDTH * f64::from(longest)).max(1.0);
    for (at, texel) in texels.iter_mut().enumerate().filter(|(_, texel)| texel[3] == u8::MAX) {
        let squares = distances[at / width / SQUARE * columns + at % width / SQUARE];
        let share = (f64::from(squares) * SQUARE as f64 / ramp).min(1.0);
        texel[3] = ((255.0 * share * share).round() as u8).max(LEAST);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trust_rises_from_outlines_and_hidden_texels_and_the_photos_edge_are_left_alone() {
        let rect = PixelRect::of_size(400, 40);
        let alpha = |x: i32| {
            if x < 100 {
                0
            } else if x == 300 {
                90
            } else {
                255
            }
        };
        let mut rgba: Vec<u8> = rect.pixels().flat_map(|(x, _)| [1, 2, 3, alpha(x)]).collect();
        let shown = rgba.clone();
        lower_beside_outlines(&mut rgba, None, rect, 8000);
        let row: Vec<u8> = (0..400).map(|x| rgba[4 * (20 * 400 + x) + 3]).collect();
        assert!(row[..100].iter().all(|alpha| *alpha == 0));
        assert!(row[100] >= LEAST && row[100] < 10 && row[300] == 90 && row[399] == 255);
        assert!(row[100..140].windows(2).all(|pair| pair[0] <= pair[1]));
        assert!(row[120] > 50 && row[120] < 100 && row[141] == 255, "{:?}", &row[100..142]);
        // What is seen through a see-through surface has no outline; what is filled has one.
        let [mut seen_through, mut filled] = [shown.clone(), shown.clone()];
        lower_beside_outlines(&mut seen_through, Some(&[255; 16_000]), rect, 8000);
        assert_eq!(seen_through, shown);
        lower_beside_outlines(&mut filled, Some(&[127; 16_000]), rect, 8000);
        assert_eq!(filled, rgba);
    }
}
