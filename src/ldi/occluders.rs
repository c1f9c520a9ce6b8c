//! How near the pixels of a layered depth image are to the outlines of what is before them. Beside an outline a photo mixes both, and
//! a model that ends a few pixels beside what it stands for puts pixels of the one onto the other.

use glam::DVec3;
use rayon::prelude::*;

use super::layout::{Ldi, ResolutionLevel};

/// The inverse depth that counts as clearly farther than another one, as a share of it.
pub const CLEARLY_FARTHER: f64 = 0.95;

/// The width of the ramp beside outlines, in pixels of the image's frame. docs/quality.md has the figures of 8 to 24.
const RAMP_PX: f64 = 16.0;

/// The least confidence: half a pixel from an outline.
const LEAST: f64 = 0.5 / RAMP_PX;

/// The least opacity, of 255, of a depth pixel that hides what is behind it.
const OPAQUE: u8 = 128;

/// No outline is near.
const NONE: u8 = u8::MAX;

/// Where nearer surfaces end before farther ones, as the reference camera sees them.
pub struct Occluders {
    size: [usize; 2],
    /// Pixels of the level along one of the image.
    reduced: f64,
    /// For each pixel how far away the nearest pixel is beside which something clearly nearer ends, in thirds of a pixel of the level, and the
    /// inverse depth there. Only the nearest one counts.
    beside: Vec<(u8, f32)>,
}

impl Occluders {
    /// Finds them in a level of an image.
    pub fn new(ldi: &Ldi, level: &ResolutionLevel) -> Self {
        let size = [level.camera.width as usize, level.camera.height as usize];
        let [width, height] = size;
        let reduced = level.camera.fx / ldi.camera.fx;
        // The nearest depth pixel of each pixel that hides what is behind it.
        let mut nearest: Vec<Option<u32>> = vec![None; width * height];
        nearest.par_chunks_exact_mut(width.max(1)).enumerate().for_each(|(y, row)| {
            for pixel in level.row(y as u32).rev().filter(|pixel| level.colours[*pixel][3] >= OPAQUE) {
                row[usize::from(level.columns[pixel])] = Some(pixel as u32);
            }
        });
        let depth = |pixel: u32| f64::from(level.inverse_depths[pixel as usize]);
        let is_before = |other: usize, at: usize| {
            let (Some(other), Some(own)) = (nearest[other], nearest[at]) else { return false };
            // A surface goes on at the pixel beside it, so that what is on one plane, or meets, hides nothing.
            let surface = usize::from(level.surfaces[other as usize]).checked_sub(1);
            let centre = [at % width, at / width].map(|at| (at as f64 + 0.5) / reduced);
            let goes_on = surface.and_then(|surface| ldi.surfaces.get(surface));
            let goes_on = goes_on.map_or(depth(other), |of| of.nu.dot(DVec3::new(centre[0], centre[1], 1.0)));
            depth(own) < CLEARLY_FARTHER * depth(other).min(goes_on.max(0.0))
        };
        let mut beside: Vec<(u8, f32)> = vec![(NONE, 0.0); width * height];
        beside.par_chunks_exact_mut(width.max(1)).enumerate().for_each(|(y, row)| {
            for (x, beside) in row.iter_mut().enumerate() {
                let at = y * width + x;
                let is_beside = (x > 0 && is_before(at - 1, at))
                    || (x + 1 < width && is_before(at + 1, at))
                    || (y > 0 && is_before(at - width, at))
                    || (y + 1 < height && is_before(at + width, at));
                if let Some(own) = nearest[at].filter(|_| is_beside) {
                    *beside = (0, level.inverse_depths[own as usize]);
                }
            }
        });
        spread(&mut beside, size);
        Self { size, reduced, beside }
    }

    /// Returns the confidence in what the camera shows of a surface at a position in its frame, up to 1: it rises over
    /// [`RAMP_PX`] beside what hides the surface there.
    pub fn confidence(&self, position: [f64; 2], inverse_depth: f64) -> f64 {
        let [width, height] = self.size;
        let [x, y] = position.map(|position| (position * self.reduced) as usize);
        let at = y.min(height.saturating_sub(1)) * width + x.min(width.saturating_sub(1));
        let Some((thirds, behind)) = self.beside.get(at).filter(|(thirds, _)| *thirds < NONE) else {
            return 1.0;
        };
        // What is clearly nearer than what is hidden there is what hides it.
        if f64::from(*behind) < CLEARLY_FARTHER * inverse_depth {
            return 1.0;
        }
        let px = (f64::from(*thirds) / 3.0 + 0.5) / self.reduced;
        (px / RAMP_PX).clamp(LEAST, 1.0)
    }
}

/// Spreads marks to the pixels around them, by two passes over the neighbours (Borgefors 1986, weights 3 and 4).
fn spread(beside: &mut [(u8, f32)], [width, height]: [usize; 2]) {
    let mut pass = |order: &mut dyn Iterator<Item = (usize, usize)>, back: isize| {
        for (x, y) in order {
            let mut own = beside[y * width + x];
            for (dx, dy, step) in [(back, 0, 3), (-1, back, 4), (0, back, 3), (1, back, 4)] {
                let place = (x.checked_add_signed(dx), y.checked_add_signed(dy));
                let (Some(at_x), Some(at_y)) = place else { continue };
                if at_x < width && at_y < height {
                    let (thirds, depth) = beside[at_y * width + at_x];
                    if thirds.saturating_add(step) < own.0 {
                        own = (thirds + step, depth);
                    }
                }
            }
            beside[y * width + x] = own;
        }
    };
    pass(&mut (0..height).flat_map(|y| (0..width).map(move |x| (x, y))), -1);
    pass(&mut (0..height).rev().flat_map(|y| (0..width).rev().map(move |x| (x, y))), 1);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{DepthPixel, DepthPixelOrigin, LdiKind, LdiSurface, Splat};
    use crate::report::LdiReport;
    use quadratura_base::scene::synthetic::{centred, look_at};

    /// An image of 128 x 96 pixels with these surfaces.
    fn image(surfaces: &[DVec3]) -> Ldi {
        let surface = |nu: &DVec3| LdiSurface { nu: *nu, object: "of the test".into(), face: None };
        Ldi {
            kind: LdiKind::Stack,
            inputs: String::new(),
            camera: centred(128, 96, 128.0),
            pose: look_at(DVec3::ZERO, DVec3::Y),
            photo_rect: None,
            gain: [0.0; 3],
            surfaces: surfaces.iter().map(surface).collect(),
            sources: Vec::new(),
            levels: Vec::new(),
            report: LdiReport::default(),
        }
    }

    fn pixel(inverse_depth: f64, surface: u16, alpha: u8) -> DepthPixel {
        let splat = Splat::new(0, DepthPixelOrigin::Photo);
        DepthPixel { inverse_depth: inverse_depth as f32, colour: [9, 9, 9, alpha], surface, splat }
    }

    /// A level of half the image's size, of what is at each column and row, nearest first.
    fn level(at: impl Fn(u16, u32) -> Vec<DepthPixel>) -> ResolutionLevel {
        let row = |y| (0..64).flat_map(|x| at(x, y).into_iter().map(move |pixel| (x, pixel))).collect();
        ResolutionLevel::of_rows(centred(64, 48, 64.0), (0..48).map(row).collect::<Vec<_>>())
    }

    const WALL: DVec3 = DVec3::new(0.0, 0.0, 0.1);
    const FRONT: DVec3 = DVec3::new(0.0, 0.0, 0.2);

    #[test]
    fn confidence_rises_beside_what_hides_a_surface_and_what_hides_it_keeps_its_own() {
        for hidden in [false, true] {
            let level = level(|x, _| match (x, hidden) {
                (..40, _) => vec![pixel(0.1, 1, 255)],
                (_, false) => vec![pixel(0.2, 2, 255)],
                (_, true) => vec![pixel(0.2, 2, 255), pixel(0.1, 1, 255)],
            });
            let occluders = Occluders::new(&image(&[WALL, FRONT]), &level);
            let of = |x: f64, inverse_depth: f64| occluders.confidence([x, 40.0], inverse_depth);
            // Column 39 of the level, which is 78 and 79 of the image, is beside the outline.
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
    fn planes_that_go_on_holes_and_what_one_sees_through_hide_nothing() {
        // Half of the ground is another face of one plane, whose inverse depth doubles within a row near the horizon.
        let ground = DVec3::new(0.0, 0.005, -0.01);
        let at = |x: u16, y: u32| {
            let depth = ground.dot(DVec3::new(2.0 * f64::from(x) + 1.0, 2.0 * f64::from(y) + 1.0, 1.0));
            if depth > 0.0 { vec![pixel(depth, 1 + x % 2, 255)] } else { Vec::new() }
        };
        let occluders = Occluders::new(&image(&[ground, ground]), &level(at));
        let depth = |y: f64| ground.dot(DVec3::new(0.0, y, 1.0));
        assert!((4..90).all(|y| occluders.confidence([33.0, f64::from(y)], depth(f64::from(y))) == 1.0));
        let before = |front: Vec<DepthPixel>| {
            let at = move |x: u16, _: u32| if x < 40 { vec![pixel(0.1, 1, 255)] } else { front.clone() };
            Occluders::new(&image(&[WALL, FRONT]), &level(at)).confidence([79.0, 40.0], 0.1)
        };
        assert_eq!(before(vec![pixel(0.2, 2, 255)]), 1.0 / 16.0);
        assert_eq!(before(Vec::new()), 1.0);
        assert_eq!(before(vec![pixel(0.2, 2, 40), pixel(0.1, 1, 255)]), 1.0);
        assert_eq!(
            Occluders::new(&image(&[]), &ResolutionLevel::without_rows(centred(0, 0, 1.0)))
                .confidence([3.0; 2], 0.1),
            1.0
        );
    }
}
