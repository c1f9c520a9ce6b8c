//! How near the pixels of a layered depth image are to the outlines of what is before them. Beside an outline a photo mixes both, and
//! a model that ends a few pixels beside what it stands for puts pixels of the one onto the other.

use super::layout::Level;
use crate::raster::nearest::{Nearest, nearest};

/// The inverse depth that counts as clearly farther than another one, as a share of it.
pub const CLEARLY_FARTHER: f64 = 0.95;

/// The width of the ramp beside outlines, in pixels of the image's frame. docs/quality.md has the figures of 8 to 24.
const RAMP_PX: f64 = 16.0;

/// The least confidence: half a pixel from an outline.
const LEAST: f64 = 0.5 / RAMP_PX;

/// Where nearer surfaces end before farther ones, as the reference camera sees them.
pub struct Occluders {
    /// The number of columns of the level.
    width: usize,
    /// Pixels of the level along one of the image.
    reduced: f64,
    /// The inverse depths of the nearest depth pixels, row by row; 0 where there is none.
    inverse_depths: Vec<f32>,
    /// For each pixel the nearest one beside which something clearly nearer ends.
    beside: Vec<Nearest>,
}

impl Occluders {
    /// Finds them in a level of an image whose frame is `frame_width` pixels wide.
    pub fn new(level: &Level, frame_width: u32) -> Self {
        let (width, height) = (level.camera.width as usize, level.camera.height as usize);
        let (mut inverse_depths, mut surfaces) = (vec![0.0; width * height], vec![0; width * height]);
        for y in 0..level.camera.height {
            for pixel in level.row(y).rev() {
                // Nearer depth pixels of a column come first, so that they are written last.
                let at = y as usize * width + usize::from(level.columns[pixel]);
                (inverse_depths[at], surfaces[at]) = (level.inverse_depths[pixel], level.surfaces[pixel]);
            }
        }
        let is_before = |other: usize, at: usize| {
            let (near, far) = (f64::from(inverse_depths[other]), f64::from(inverse_depths[at]));
            far < CLEARLY_FARTHER * near && (surfaces[at] == 0 || surfaces[at] != surfaces[other])
        };
        let is_beside = |at: usize| {
            let (x, y) = (at % width, at / width);
            (x > 0 && is_before(at - 1, at))
                || (x + 1 < width && is_before(at + 1, at))
                || (y > 0 && is_before(at - width, at))
                || (y + 1 < height && is_before(at + width, at))
        };
        let marked: Vec<bool> = (0..width * height).map(is_beside).collect();
        let reduced = f64::from(level.camera.width) / f64::from(frame_width);
        Self { width, reduced, beside: nearest(&marked, width), inverse_depths }
    }

    /// Returns the confidence in what the camera shows of a surface at a position in its frame, up to 1: it rises over
    /// [`RAMP_PX`] beside what hides the surface there.
    pub fn confidence(&self, [x, y]: [f64; 2], inverse_depth: f64) -> f64 {
        let at = |position: f64, side: usize| ((position * self.reduced) as usize).min(side - 1);
        let height = self.beside.len() / self.width;
        let found = self.beside[at(y, height) * self.width + at(x, self.width)];
        let Some(beside) = found.index() else { return 1.0 };
        let behind = f64::from(self.inverse_depths[beside]);
        // What is clearly nearer than what is hidden there is what hides it.
        if behind < CLEARLY_FARTHER * inverse_depth {
            return 1.0;
        }
        let px = (f64::from(found.distance_px()) + 0.5) / self.reduced;
        (px / RAMP_PX).clamp(LEAST, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ldi::layout::{DepthPixel, DepthPixelOrigin, Splat};
    use crate::scene::synthetic::centred;

    /// A wall, and from column 40 on something at half its distance before it, in an image of twice these columns and rows.
    fn level(hidden: bool) -> Level {
        let pixel = |column: u16, inverse_depth: f32, surface: u16| {
            let splat = Splat::new(0, DepthPixelOrigin::Photo);
            (column, DepthPixel { inverse_depth, colour: [9, 9, 9, 255], surface, splat })
        };
        let row = |_| {
            let of = |column: u16| {
                let front = (column >= 40).then(|| pixel(column, 0.2, 2));
                let wall = (column < 40 || hidden).then(|| pixel(column, 0.1, 1));
                front.into_iter().chain(wall)
            };
            (0..64).flat_map(of).collect::<Vec<_>>()
        };
        Level::of_rows(centred(64, 48, 64.0), (0..48).map(row))
    }

    #[test]
    fn confidence_rises_beside_what_hides_a_surface_and_what_hides_it_keeps_its_own() {
        for hidden in [false, true] {
            let occluders = Occluders::new(&level(hidden), 128);
            let of = |x: f64, inverse_depth: f64| occluders.confidence([x, 40.0], inverse_depth);
            // Column 39 of the level, which is 78 and 79 of the frame, is beside the outline.
            assert_eq!((of(79.0, 0.1), of(77.0, 0.1)), (1.0 / 16.0, 3.0 / 16.0));
            let rising: Vec<f64> = (50..80).rev().map(|x| of(f64::from(x), 0.1)).collect();
            assert!(rising.windows(2).all(|w| w[0] <= w[1] && w[1] - w[0] <= 0.13), "{rising:?}");
            assert_eq!([of(60.0, 0.1), of(10.0, 0.1)], [1.0; 2]);
            assert_eq!([of(80.0, 0.2), of(90.0, 0.2)], [1.0; 2], "what is in front");
            // The wall goes on behind, where it is hidden: no photo shows it there.
            assert_eq!(of(82.0, 0.1), 5.0 / 16.0);
        }
    }

    #[test]
    fn one_plane_hides_nothing_however_fast_its_depth_changes() {
        let pixel = |column: u16, row: u32| DepthPixel {
            inverse_depth: 0.01 * (row + 1) as f32,
            colour: [9, 9, 9, 255],
            surface: 1 + column / 64,
            splat: Splat::new(0, DepthPixelOrigin::Photo),
        };
        let row = |y| (0..64).map(|column| (column, pixel(column, y))).collect::<Vec<_>>();
        let occluders = Occluders::new(&Level::of_rows(centred(64, 48, 64.0), (0..48).map(row)), 64);
        assert_eq!(occluders.confidence([20.0, 3.0], 0.04), 1.0);
    }
}
