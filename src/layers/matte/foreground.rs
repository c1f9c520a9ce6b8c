//! The colours of foreground and background where both are mixed: T. Germer, T. Uelwer, S. Conrad, S. Harmeling, *Fast
//! Multi-Level Foreground Estimation*, International Conference on Pattern Recognition 2020.
//!
//! Both colours explain the photo's, `alpha F + (1 - alpha) B`, and are smooth, the more so where alpha changes. The
//! minimum is found from coarse to fine: each level begins with the colours of the coarser one, and a few sweeps over its
//! pixels, each of which is two equations per channel, are enough.

use glam::Vec3;

use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::Image;

/// The least weight of smoothness between neighbours.
const SMOOTH: f32 = 1e-5;

/// The weight of smoothness for a difference of alpha of 1.
const ACROSS: f32 = 1.0;

/// Levels with no side above this many pixels are swept more often: they cost nothing.
const SMALL: usize = 32;
const SWEEPS_SMALL: usize = 10;
const SWEEPS: usize = 2;

/// The colours of both sides, in linear light, for the same rectangle.
#[derive(Debug, Clone, PartialEq)]
pub struct Foreground {
    /// The colour of the foreground.
    pub front: Image<Vec3>,
    /// The colour of the background.
    pub behind: Image<Vec3>,
}

/// Estimates the colours of both sides. `colours` is in linear light, 0 to 1, and `alpha` 0 to 1, for the same rectangle.
pub fn foreground(colours: &Image<Vec3>, alpha: &Image<f32>) -> Foreground {
    assert_eq!(colours.rect(), alpha.rect(), "both are of one rectangle");
    let [width, height] = colours.size();
    let levels = (width.max(height) as f32).log2().ceil().max(0.0) as u32;
    let side = |all: usize, level: u32| {
        // From one pixel to all of them, in equal ratios.
        let share = level as f32 / levels.max(1) as f32;
        (all as f32).powf(share).round().clamp(1.0, all as f32) as usize
    };
    let mean = colours.pixels().iter().sum::<Vec3>() / colours.pixels().len().max(1) as f32;
    let mut found = ForegroundLevel { size: [1, 1], front: vec![mean], behind: vec![mean] };
    for level in 0..=levels {
        let size = if level == levels { [width, height] } else { [side(width, level), side(height, level)] };
        found = found.resized(size);
        let (colours, alpha) = (nearest(colours, size), nearest(alpha, size));
        let sweeps = if size[0].max(size[1]) <= SMALL { SWEEPS_SMALL } else { SWEEPS };
        (0..sweeps).for_each(|_| found.sweep(&colours, &alpha));
    }
    let rect = colours.rect();
    Foreground { front: Image::new(rect, found.front), behind: Image::new(rect, found.behind) }
}

/// The estimate at one resolution.
struct ForegroundLevel {
    size: [usize; 2],
    front: Vec<Vec3>,
    behind: Vec<Vec3>,
}

impl ForegroundLevel {
    fn resized(self, size: [usize; 2]) -> Self {
        let image = |pixels: Vec<Vec3>| {
            Image::new(PixelRect::of_size(self.size[0] as u32, self.size[1] as u32), pixels)
        };
        let (front, behind) = (image(self.front), image(self.behind));
        Self { size, front: nearest(&front, size), behind: nearest(&behind, size) }
    }

    /// Solves each pixel for its neighbours as they are, in order.
    fn sweep(&mut self, colours: &[Vec3], alpha: &[f32]) {
        let [width, height] = self.size;
        for y in 0..height {
            for x in 0..width {
                let at = y * width + x;
                let left = (x > 0).then(|| at - 1);
                let right = (x + 1 < width).then(|| at + 1);
                let above = (y > 0).then(|| at - width);
                let below = (y + 1 < height).then(|| at + width);
                let (a, b) = (alpha[at], 1.0 - alpha[at]);
                let (mut smooth, mut front, mut behind) = (0.0, a * colours[at], b * colours[at]);
                for other in [left, right, above, below].into_iter().flatten() {
                    let weight = SMOOTH + ACROSS * (alpha[at] - alpha[other]).abs();
                    smooth += weight;
                    front += weight * self.front[other];
                    behind += weight * self.behind[other];
                }
                let (of_front, mixed, of_behind) = (a * a + smooth, a * b, b * b + smooth);
                let determinant = (of_front * of_behind - mixed * mixed).max(f32::MIN_POSITIVE);
                let solved = |own: f32, one: Vec3, other: Vec3| {
                    ((own * one - mixed * other) / determinant).clamp(Vec3::ZERO, Vec3::ONE)
                };
                self.front[at] = solved(of_behind, front, behind);
                self.behind[at] = solved(of_front, behind, front);
            }
        }
    }
}

/// Returns the pixels of an image at another size, each the nearest one.
fn nearest<P: Copy>(image: &Image<P>, size: [usize; 2]) -> Vec<P> {
    let [width, height] = image.size();
    let at = |i: usize, to: usize, from: usize| (i * from / to).min(from - 1);
    let pixel = |i: usize| {
        let (x, y) = (at(i % size[0], size[0], width), at(i / size[0], size[1], height));
        image.pixels()[y * width + x]
    };
    (0..size[0] * size[1]).map(pixel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_colours_are_found_where_they_are_mixed() {
        let rect = PixelRect::of_size(96, 64);
        let alpha = Image::from_fn(rect, |(x, _)| ((x as f32 - 30.0) / 36.0).clamp(0.0, 1.0));
        let front = |y: i32| Vec3::new(0.1, 0.3 + 0.2 * y as f32 / 64.0, 0.1);
        let behind = |x: i32| Vec3::new(0.7, 0.6, 0.2 + 0.5 * x as f32 / 96.0);
        let colours = Image::from_fn(rect, |(x, y)| {
            let a = *alpha.get(x, y).unwrap();
            front(y) * a + behind(x) * (1.0 - a)
        });
        let found = foreground(&colours, &alpha);
        let mut worst = [0.0f32; 3];
        for ((x, y), a) in alpha.iter() {
            let (f, b) = (*found.front.get(x, y).unwrap(), *found.behind.get(x, y).unwrap());
            let mixed = f * *a + b * (1.0 - a);
            worst[0] = worst[0].max((mixed - *colours.get(x, y).unwrap()).abs().max_element());
            // Of a side that is hardly seen, little can be known.
            if *a > 0.3 {
                worst[1] = worst[1].max((f - front(y)).abs().max_element());
            }
            if *a < 0.7 {
                worst[2] = worst[2].max((b - behind(x)).abs().max_element());
            }
        }
        assert!(worst[0] < 0.02 && worst[1] < 0.1 && worst[2] < 0.1, "{worst:?}");
    }
}
