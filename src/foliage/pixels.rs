//! Pictures of leaves and bark, with ever coarser copies of their light.

use glam::{DVec2, Vec3, Vec4};

use quadratura_base::raster::halving::{OddSide, halved};
use quadratura_base::scene::light::LINEAR_FROM_BYTE;

/// How a picture goes on beyond its sides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wrap {
    /// The pixels of its border go on.
    #[default]
    Held,
    /// It is repeated.
    Repeated,
    /// It is repeated, every other time mirrored.
    Mirrored,
}

impl Wrap {
    /// Returns the pixel of a side that an index before, in or after it stands for.
    #[inline]
    fn index(self, index: i64, side: usize) -> usize {
        let side = side as i64;
        let index = match self {
            Self::Held => index.clamp(0, side - 1),
            Self::Repeated => index.rem_euclid(side),
            Self::Mirrored => {
                let index = index.rem_euclid(2 * side);
                index.min(2 * side - 1 - index)
            }
        };
        index as usize
    }
}

/// A picture of a leaf or of bark.
#[derive(Debug, Clone, PartialEq)]
pub struct Pixels {
    /// Columns and rows, at least 1.
    size: [usize; 2],
    rgba: Vec<[u8; 4]>,
    /// The copies, each of half the size of the one before, down to a single pixel.
    coarser: Vec<Coarser>,
}

/// A copy of half the size.
#[derive(Debug, Clone, PartialEq)]
struct Coarser {
    size: [usize; 2],
    /// Linear R, G, B times the weight, and the weight.
    light: Vec<Vec4>,
}

/// The weight of the light of a pixel without alpha: it has none beside others.
const LEAST_WEIGHT: f32 = 1e-5;

/// Returns the weighted light of a pixel. What is cut out has next to no weight, so that it does not colour what stays.
#[inline]
fn weighted([r, g, b, a]: [u8; 4]) -> Vec4 {
    let weight = (f32::from(a) / 255.0).max(LEAST_WEIGHT);
    let [r, g, b] = [r, g, b].map(|byte| LINEAR_FROM_BYTE[usize::from(byte)]);
    weight * Vec4::new(r, g, b, 1.0)
}

impl Pixels {
    /// Makes a picture of sRGB and straight alpha, 8 bits each, row by row from the top.
    ///
    /// # Panics
    /// Where a side is 0, or there are not `width * height` pixels.
    pub fn new(width: u32, height: u32, rgba: Vec<[u8; 4]>) -> Self {
        let size = [width as usize, height as usize];
        assert!(
            size[0] > 0 && size[0] * size[1] == rgba.len(),
            "a picture has as many pixels as its size says"
        );
        let mut coarser: Vec<Coarser> = Vec::new();
        let mut last = size;
        while last != [1, 1] {
            let count = |of: &[usize]| (of.len() as f32).recip();
            let light = match coarser.last() {
                Some(Coarser { light, .. }) => {
                    halved(last, OddSide::Alone, |of| count(of) * of.iter().map(|i| light[*i]).sum::<Vec4>())
                }
                None => halved(last, OddSide::Alone, |of| {
                    count(of) * of.iter().map(|i| weighted(rgba[*i])).sum::<Vec4>()
                }),
            };
            last = OddSide::Alone.half_size(last);
            coarser.push(Coarser { size: last, light });
        }
        Self { size, rgba, coarser }
    }

    /// Returns width and height in pixels.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Returns the pixels: sRGB and straight alpha, row by row from the top.
    pub fn rgba(&self) -> &[[u8; 4]] {
        &self.rgba
    }

    /// Returns linear R, G, B times the weight, and the weight, of the picture and of copies of half the size each, down to a
    /// single pixel, with the size of each: columns and rows, halves of odd numbers rounded down, as devices have them.
    pub fn halves(&self) -> Vec<([usize; 2], Vec<Vec4>)> {
        let mut copies =
            vec![(self.size, self.rgba.iter().map(|pixel| weighted(*pixel)).collect::<Vec<_>>())];
        while copies[copies.len() - 1].0 != [1, 1] {
            let (size, light) = &copies[copies.len() - 1];
            copies.push(half_for_devices(*size, light));
        }
        copies
    }

    /// Returns alpha, 0..=1, at a texture coordinate ((0, 0) is the top left corner, (1, 1) the bottom right one), between
    /// the middles of pixels by bilinear interpolation. It is always that of the picture itself: coarser copies would make
    /// what is cut out by a threshold larger or smaller.
    #[inline]
    pub fn alpha(&self, texture: DVec2, wrap: [Wrap; 2]) -> f32 {
        let [width, height] = self.size;
        let px = texture * DVec2::new(width as f64, height as f64);
        let row = |y: usize| y * width;
        mixed(px, self.size, wrap, |x, y| f32::from(self.rgba[row(y) + x][3])) / 255.0
    }

    /// Returns linear R, G, B at a texture coordinate, averaged over about `area` pixels of the picture: between pixels and
    /// between the two copies whose pixels are nearest to that size by linear interpolation.
    pub fn light(&self, texture: DVec2, wrap: [Wrap; 2], area: f64) -> Vec3 {
        let most = self.coarser.len() as f64;
        // Each copy has a fourth of the pixels. What is not a number, of a triangle without area, gives the picture itself.
        let level = (0.5 * area.max(1.0).log2()).min(most);
        let (finer, share) = (level as usize, level.fract() as f32);
        let mut light = self.level(finer, texture, wrap);
        if share > 0.0 {
            light = light.lerp(self.level(finer + 1, texture, wrap), share);
        }
        light.truncate() / light.w
    }

    /// Returns the weighted light in the picture (0) or in a copy.
    fn level(&self, level: usize, texture: DVec2, wrap: [Wrap; 2]) -> Vec4 {
        let [width, height] = self.size.map(|side| side as f64);
        let px = texture * DVec2::new(width, height) / f64::from(1u32 << level);
        match level.checked_sub(1).map(|copy| &self.coarser[copy]) {
            None => mixed(px, self.size, wrap, |x, y| weighted(self.rgba[y * self.size[0] + x])),
            Some(Coarser { size, light }) => mixed(px, *size, wrap, |x, y| light[y * size[0] + x]),
        }
    }
}

/// Halves a picture, rounding halves of odd sides down: a pixel of the half is the mean of all that it touches.
fn half_for_devices([width, height]: [usize; 2], light: &[Vec4]) -> ([usize; 2], Vec<Vec4>) {
    let half = [(width / 2).max(1), (height / 2).max(1)];
    let touched = |at: usize, half: usize, whole: usize| at * whole / half..((at + 1) * whole).div_ceil(half);
    let mean = |x: usize, y: usize| {
        let (columns, rows) = (touched(x, half[0], width), touched(y, half[1], height));
        let count = columns.len() * rows.len();
        rows.flat_map(|y| &light[y * width..][columns.clone()]).sum::<Vec4>() / count as f32
    };
    (half, (0..half[1]).flat_map(|y| (0..half[0]).map(move |x| (x, y))).map(|(x, y)| mean(x, y)).collect())
}

/// Interpolates between the values of four pixels about a position in pixels.
#[inline]
fn mixed<T>(px: DVec2, size: [usize; 2], wrap: [Wrap; 2], value: impl Fn(usize, usize) -> T) -> T
where
    T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>,
{
    let at = px - 0.5;
    let first = at.floor();
    let (x, y) = (first.x as i64, first.y as i64);
    let (sx, sy) = ((at.x - first.x) as f32, (at.y - first.y) as f32);
    let (x0, x1) = (wrap[0].index(x, size[0]), wrap[0].index(x.saturating_add(1), size[0]));
    let (y0, y1) = (wrap[1].index(y, size[1]), wrap[1].index(y.saturating_add(1), size[1]));
    let above = value(x0, y0) * (1.0 - sx) + value(x1, y0) * sx;
    let below = value(x0, y1) * (1.0 - sx) + value(x1, y1) * sx;
    above * (1.0 - sy) + below * sy
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    const HELD: [Wrap; 2] = [Wrap::Held; 2];

    fn alphas(width: u32, alphas: &[u8]) -> Pixels {
        let rgba: Vec<[u8; 4]> = alphas.iter().map(|alpha| [0, 0, 0, *alpha]).collect();
        Pixels::new(width, rgba.len() as u32 / width, rgba)
    }

    #[test]
    fn alpha_is_that_of_a_pixel_in_its_middle_and_goes_on_as_the_wrap_says() {
        let pixels = alphas(4, &[0, 51, 102, 255]);
        let at = |column: f64, wrap: Wrap| {
            let alpha = pixels.alpha(DVec2::new((column + 0.5) / 4.0, 0.5), [wrap, Wrap::Held]);
            (255.0 * alpha).round() as u8
        };
        for wrap in [Wrap::Held, Wrap::Repeated, Wrap::Mirrored] {
            assert_eq!([0.0, 1.0, 2.0, 3.0, 1.5].map(|x| at(x, wrap)), [0, 51, 102, 255, 77]);
        }
        assert_eq!([-1.0, -2.0, 4.0, 9.0].map(|x| at(x, Wrap::Held)), [0, 0, 255, 255]);
        assert_eq!([-1.0, -2.0, 4.0, 9.0].map(|x| at(x, Wrap::Repeated)), [255, 102, 0, 51]);
        assert_eq!([-1.0, -2.0, 4.0, 9.0].map(|x| at(x, Wrap::Mirrored)), [0, 51, 255, 51]);
        assert_eq!(at(1e300, Wrap::Held), 255);
    }

    #[test]
    fn the_coarsest_light_is_the_mean_of_what_is_not_cut_out() {
        let mut rng = Rng::new(8);
        for [width, height] in [[8, 8], [16, 4], [1, 1]] {
            let byte = |rng: &mut Rng| rng.bits() as u8;
            let rgba: Vec<[u8; 4]> = (0..width * height)
                .map(|i| [byte(&mut rng), byte(&mut rng), byte(&mut rng), if i % 3 == 0 { 255 } else { 0 }])
                .collect();
            let kept = rgba.iter().filter(|pixel| pixel[3] > 0).map(|p| weighted(*p)).collect::<Vec<_>>();
            let mean = kept.iter().sum::<Vec4>() / kept.len() as f32;
            let pixels = Pixels::new(width, height, rgba);
            let light = pixels.light(DVec2::new(0.3, 0.8), [Wrap::Repeated; 2], 1e9);
            // Pixels that are cut out have a weight of 1e-5 each.
            assert!((light - mean.truncate()).abs().max_element() < 1e-4, "{light} {mean}");
        }
    }

    #[test]
    fn halves_have_the_sizes_that_devices_have_and_keep_the_mean() {
        let rgba = (0..7 * 4).map(|i| [i as u8 * 9; 4].map(|byte| byte.max(128))).collect();
        let halves = Pixels::new(7, 4, rgba).halves();
        let sizes: Vec<[usize; 2]> = halves.iter().map(|(size, _)| *size).collect();
        assert_eq!(sizes, [[7, 4], [3, 2], [1, 1]]);
        assert!(halves.iter().all(|([width, height], light)| light.len() == width * height));
        let even = Pixels::new(4, 2, (0..8).map(|i| [30 * i as u8, 0, 0, 255]).collect()).halves();
        let mean = |light: &[Vec4]| light.iter().sum::<Vec4>() / light.len() as f32;
        assert!((mean(&even[0].1) - even[2].1[0]).abs().max_element() < 1e-6);
    }

    #[test]
    fn light_over_some_pixels_is_between_the_sharp_and_the_coarse_one() {
        // Columns of black and white.
        let rgba = (0..64 * 64).map(|i| if i % 2 == 0 { [0, 0, 0, 255] } else { [255; 4] }).collect();
        let pixels = Pixels::new(64, 64, rgba);
        let at = |column: f64, area: f64| pixels.light(DVec2::new((column + 0.5) / 64.0, 0.5), HELD, area).x;
        assert_eq!([at(20.0, 0.01), at(21.0, 1.0)], [0.0, 1.0]);
        assert_eq!([at(20.0, 4.0), at(21.0, 4.0), at(20.0, 1e6)], [0.5; 3]);
        // Half way between two copies by the logarithm.
        assert!((at(20.0, 2.0) - 0.25).abs() < 1e-6 && (at(21.0, 2.0) - 0.75).abs() < 1e-6);
        assert_eq!(at(21.0, f64::NAN), 1.0);
    }
}
