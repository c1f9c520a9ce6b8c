//! The true outline of what a photo shows: where the model's edge lies beyond the building's, the photo shows the sky, or what is far
//! away, within the outline of the model. Views that leave the photo's own camera see through such pixels.
//!
//! A pixel is of the sky where its colour is nearer to that of the sky beyond the outline than to that of the face within it, and
//! where such pixels connect it with the sky. What has no clear colour of its own, such as a white wall before white clouds, stays
//! with the face, and so does everything before a background with detail, which no single colour stands for.

use rayon::prelude::*;

use super::beside;
use super::connected::around;
use crate::fill::Donor;
use quadratura_base::raster::steps::steps_inside;
use quadratura_base::scene::{FaceId, PhotoPixels};
use quadratura_projection::skirts::BAND;
use quadratura_view::agreement::{ContradictedPixel, NO_FACE, PhotoAgreement};

/// The radius of the squares over which colours of sky and faces are averaged, as a multiple of the width of the band along
/// outlines in which the true one is searched.
const REACH: usize = 3;

/// The least number of pixels of sky, and of the face, around a pixel.
const LEAST_COUNT: f64 = 20.0;

/// The least difference between the colours of sky and face, of 1: the largest channel's range in sRGB.
const LEAST_CONTRAST: f64 = 0.15;

/// The same as a multiple of the standard deviation of the sky's colour.
const LEAST_CLEARNESS: f64 = 4.0;

/// The distance of a pixel's colour from that of the sky, as a share of the contrast, up to which the pixel is sky, and from which on
/// it is none. With wider limits, light trims and copper in the sun were taken for sky.
const SKY: [f64; 2] = [0.15, 0.4];

/// The distance from the outline, in pixels, within which the sky begins from which pixels within it are reached.
const BESIDE_PX: u16 = 2;

/// What a pixel of a reduced photo shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PixelContent {
    /// A face of the model.
    Face,
    /// Surroundings.
    Around,
    /// What is masked.
    Nothing,
}

/// Returns how much of each pixel of a photo shows its face: 1, but for what is sky within the outlines of the model. `is_far` tells
/// of each face whether views show it as surroundings.
pub fn outlines(donor: &Donor, pixels: &PhotoPixels, is_far: impl Fn(FaceId) -> bool) -> PhotoAgreement {
    let width = donor.camera.width;
    let places = || (0..donor.camera.height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let face = |(x, y): (u32, u32)| donor.owner(x, y).map(|item| donor.seen(item).face);
    let shows = |(x, y): (u32, u32)| match face((x, y)) {
        _ if !pixels.is_valid(x, y) => PixelContent::Nothing,
        Some(face) if !is_far(face) => PixelContent::Face,
        _ => PixelContent::Around,
    };
    let shows: Vec<PixelContent> = places().map(shows).collect();
    let colour = |(x, y): (u32, u32)| {
        let [r, g, b, _] = pixels.rgba16(x, y);
        [r, g, b].map(|value| f32::from(value) / f32::from(u16::MAX))
    };
    let colours: Vec<[f32; 3]> = places().map(colour).collect();
    let mut values = vec![1.0; shows.len()];
    for (at, sky) in sky_along([width, donor.camera.height].map(|side| side as usize), &shows, &colours) {
        values[at] = 1.0 - sky;
    }
    let contradicted = places().zip(&values).zip(&shows).filter_map(|(((x, y), value), shows)| {
        let agreement = ((value * 255.0).round() as u8).max(1);
        let face = face((x, y)).filter(|_| *shows == PixelContent::Face).unwrap_or(NO_FACE);
        (agreement < u8::MAX).then_some(ContradictedPixel { at: [x as u16, y as u16], face, agreement })
    });
    let contradicted = contradicted.collect();
    PhotoAgreement { size: [width, donor.camera.height], contradicted, beside: beside(donor, &values) }
}

/// Returns the pixels of faces that are sky, and those of sky within the same distance beyond outlines, with the share of sky in them.
/// Colours are sRGB, 0 to 1.
fn sky_along(size: [usize; 2], shows: &[PixelContent], colours: &[[f32; 3]]) -> Vec<(usize, f32)> {
    let band = (BAND * size[0].max(size[1]) as f64).ceil() as u16;
    let steps_to = |what: PixelContent| {
        steps_inside(&shows.iter().map(|shows| *shows != what).collect::<Vec<bool>>(), size)
    };
    let (within, beyond) = (steps_to(PixelContent::Around), steps_to(PixelContent::Face));
    let is_sky = |at: usize| shows[at] == PixelContent::Around && beyond[at] >= band;
    let is_face = |at: usize| shows[at] == PixelContent::Face && within[at] >= band;
    let (skies, faces) =
        (SummedAreaTable::new(size, colours, is_sky), SummedAreaTable::new(size, colours, is_face));
    let radius = REACH * usize::from(band);
    let share = |at: usize| -> f32 {
        let (Some(sky), Some(face)) = (skies.colour(at, radius), faces.colour(at, radius)) else {
            return 0.0;
        };
        let contrast = distance(sky.mean, face.mean);
        if contrast < LEAST_CONTRAST.max(LEAST_CLEARNESS * sky.deviation) {
            return 0.0;
        }
        let t = (distance(colours[at].map(f64::from), sky.mean) / contrast - SKY[0]) / (SKY[1] - SKY[0]);
        let t = t.clamp(0.0, 1.0);
        (1.0 - t * t * (3.0 - 2.0 * t)) as f32
    };
    let is_near = |at: usize| match shows[at] {
        PixelContent::Face => within[at] < band,
        PixelContent::Around => beyond[at] < band,
        PixelContent::Nothing => false,
    };
    let shares: Vec<f32> =
        (0..shows.len()).into_par_iter().map(|at| if is_near(at) { share(at) } else { 0.0 }).collect();
    // From the sky beside the outline inwards, and one pixel farther, where sky and face are mixed.
    let is_around = |at: usize| shows[at] == PixelContent::Around;
    let is_beside = |at: usize| is_around(at) && beyond[at] <= BESIDE_PX && shares[at] > 0.5;
    let mut reached: Vec<bool> = (0..shows.len()).map(is_beside).collect();
    let mut open: Vec<usize> = (0..shows.len()).filter(|at| reached[*at]).collect();
    while let Some(at) = open.pop() {
        for next in around(size, at, 1) {
            let is_open = shows[next] == PixelContent::Face && shares[next] > 0.0;
            if is_open && !std::mem::replace(&mut reached[next], true) && shares[next] > 0.5 {
                open.push(next);
            }
        }
    }
    let is_found = |at: &usize| shares[*at] > 0.0 && (reached[*at] || is_around(*at));
    (0..shows.len()).filter(is_found).map(|at| (at, shares[at])).collect()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
}

/// The colours around a pixel.
struct ColourSpread {
    mean: [f64; 3],
    /// The standard deviation, over all channels.
    deviation: f64,
}

/// Sums of the colours of some pixels over all rectangles that begin at the first pixel (Crow, *Summed-area tables for texture mapping*,
/// SIGGRAPH 1984).
struct SummedAreaTable {
    size: [usize; 2],
    /// R, G, B, their squares, and the number of pixels, in rows one longer than those of the picture.
    sums: Vec<[f64; 5]>,
}

impl SummedAreaTable {
    fn new(size: [usize; 2], colours: &[[f32; 3]], is_summed: impl Fn(usize) -> bool) -> Self {
        let row = size[0] + 1;
        let mut sums = vec![[0.0; 5]; row * (size[1] + 1)];
        for (y, x) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (y, x))) {
            let at = y * size[0] + x;
            let [r, g, b] = colours[at].map(f64::from);
            let own = if is_summed(at) { [r, g, b, r * r + g * g + b * b, 1.0] } else { [0.0; 5] };
            let (above, end) = (y * row + x, (y + 1) * row + x + 1);
            sums[end] =
                std::array::from_fn(|i| own[i] + sums[end - 1][i] + sums[above + 1][i] - sums[above][i]);
        }
        Self { size, sums }
    }

    /// Returns the colours within a square around a pixel; `None` where there are too few.
    fn colour(&self, at: usize, radius: usize) -> Option<ColourSpread> {
        let (x, y) = (at % self.size[0], at / self.size[0]);
        let row = self.size[0] + 1;
        let [left, top] = [x, y].map(|low| low.saturating_sub(radius));
        let (right, bottom) = ((x + radius + 1).min(self.size[0]), (y + radius + 1).min(self.size[1]));
        let corner = |y: usize, x: usize| self.sums[y * row + x];
        let corners = [corner(bottom, right), corner(top, left), corner(top, right), corner(bottom, left)];
        let sum: [f64; 5] =
            std::array::from_fn(|i| corners[0][i] + corners[1][i] - corners[2][i] - corners[3][i]);
        let count = sum[4];
        (count >= LEAST_COUNT).then(|| {
            let mean = [0, 1, 2].map(|c| sum[c] / count);
            let square = mean.iter().map(|mean| mean * mean).sum::<f64>();
            ColourSpread { mean, deviation: (sum[3] / count - square).max(0.0).sqrt() }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [400, 80];

    /// A picture with a model below row 40 of which the photo's building fills what is below row `built`.
    fn found(sky: [f32; 3], wall: [f32; 3], built: usize, detail: f32) -> Vec<(usize, f32)> {
        let shows: Vec<PixelContent> = (0..400 * 80)
            .map(|at| if at / 400 >= 40 { PixelContent::Face } else { PixelContent::Around })
            .collect();
        let colour = |at: usize| {
            let (x, y) = (at % 400, at / 400);
            let noise = detail * (((x * 7 + y * 13) % 5) as f32 - 2.0) / 2.0;
            if y >= built { wall } else { sky.map(|sky| sky + noise) }
        };
        let found = sky_along(SIZE, &shows, &(0..400 * 80).map(colour).collect::<Vec<_>>());
        found.into_iter().filter(|(at, _)| *at >= 40 * 400).collect()
    }

    #[test]
    fn sky_within_the_outline_is_found_down_to_where_the_building_begins() {
        let (sky, wall) = ([0.7, 0.8, 0.95], [0.4, 0.3, 0.25]);
        let shares = found(sky, wall, 42, 0.0);
        assert_eq!(shares.len(), 2 * 400, "two rows of sky lie within the model");
        assert!(shares.iter().all(|(at, share)| (40..42).contains(&(at / 400)) && *share == 1.0));
        assert!(found(sky, wall, 40, 0.0).is_empty(), "the building ends where the model does");
        assert!(found(sky, wall, 37, 0.0).is_empty(), "the building rises above the model");
        assert!(found([0.95; 3], [0.9; 3], 42, 0.0).is_empty(), "white walls before white clouds stay");
        assert!(found(sky, wall, 42, 0.3).is_empty(), "before a background with detail nothing is known");
    }

    #[test]
    fn windows_that_mirror_the_sky_stay_with_their_wall() {
        let sky = [0.7, 0.8, 0.95];
        let shows: Vec<PixelContent> = (0..400 * 80)
            .map(|at| if at / 400 >= 40 { PixelContent::Face } else { PixelContent::Around })
            .collect();
        let window = |at: usize| (41..43).contains(&(at / 400)) && (100..140).contains(&(at % 400));
        let colour = |at: usize| if at / 400 < 40 || window(at) { sky } else { [0.4, 0.3, 0.25] };
        let colours: Vec<[f32; 3]> = (0..400 * 80).map(colour).collect();
        let found = sky_along(SIZE, &shows, &colours);
        assert!(found.iter().all(|(at, share)| at / 400 < 40 && *share == 1.0), "nothing connects them");
        assert_eq!(found.len(), 2 * 400, "beyond the outline the sky is told from what stands on it");
    }
}
