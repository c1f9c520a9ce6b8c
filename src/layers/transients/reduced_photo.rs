//! A reduced photo with its colours prepared for comparison.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::layers::fill::Donor;
use crate::projection::exposure::Optics;
use crate::projection::exposure::optics::squared_radius;

/// The least value of linear light that enters a logarithm, white being 1; below it, noise and haze decide.
const BLACK: f32 = 0.01;

/// The weight of a difference of hue relative to one of brightness: shadows change brightness more than hue.
const HUE: f32 = 2.0;

/// A colour prepared for comparison: the logarithm of the brightness, and those of red and of blue over
/// green, each weighted.
pub type Tint = [f32; 3];

/// A reduced photo.
pub struct ReducedPhoto {
    /// The photo's camera, and the surface that each pixel shows.
    pub donor: Donor,
    /// The colour of each pixel, row by row, in the common exposure; NaN where no surface of the model is
    /// shown.
    tints: Vec<Tint>,
}

impl ReducedPhoto {
    /// Builds the colours of a donor that was made from the reduced photo. `gain` is the photo's exposure
    /// relative to the common one (natural logarithms).
    pub fn new(donor: Donor, gain: [f64; 3], optics: &Optics) -> Self {
        let (width, height) = (donor.camera.width, donor.camera.height);
        let tint = |x: u32, y: u32| {
            if !donor.shows_any(x, y) {
                return [f32::NAN; 3];
            }
            let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let light = optics.undone(donor.pixel(x, y).map(f64::from), squared_radius(&donor.camera, px));
            tint_of([0, 1, 2].map(|c| (light[c] * (-gain[c]).exp()) as f32))
        };
        let row = |y: u32| (0..width).map(move |x| (x, y));
        let tints = (0..height).into_par_iter().flat_map_iter(row).map(|(x, y)| tint(x, y)).collect();
        Self { donor, tints }
    }

    /// Returns the colour at a pixel.
    pub fn tint(&self, x: u32, y: u32) -> Tint {
        self.tints[y as usize * self.donor.camera.width as usize + x as usize]
    }

    /// Projects a world point to pixel coordinates; `None` outside of the photo.
    pub fn place(&self, point: DVec3) -> Option<DVec2> {
        let camera = &self.donor.camera;
        let px = camera.image_from_camera(self.donor.pose.camera_from_world(point))?;
        camera.rect().contains_position(px).then_some(px)
    }

    /// Computes the distance of a colour from the bounding box of the colours of all pixels at most `reach`
    /// rows and columns from `px`.
    pub fn distance(&self, tint: Tint, px: DVec2, reach: i32) -> f32 {
        let (width, height) = (self.donor.camera.width as i32, self.donor.camera.height as i32);
        let (x, y) = (px.x as i32, px.y as i32);
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for v in (y - reach).max(0)..(y + reach + 1).min(height) {
            let row = v as usize * width as usize;
            for u in (x - reach).max(0)..(x + reach + 1).min(width) {
                let found = self.tints[row + u as usize];
                for c in 0..3 {
                    low[c] = low[c].min(found[c]);
                    high[c] = high[c].max(found[c]);
                }
            }
        }
        length([0, 1, 2].map(|c| (low[c] - tint[c]).max(tint[c] - high[c]).max(0.0)))
    }
}

/// Converts linear light, full range 1.
fn tint_of(light: [f32; 3]) -> Tint {
    let [r, g, b] = light.map(|light| light.max(BLACK).ln());
    [(r + g + b) / 3.0, HUE * (r - g), HUE * (b - g)]
}

/// Returns the Euclidean length of the difference between two tints.
pub fn length(difference: Tint) -> f32 {
    difference.iter().map(|d| d * d).sum::<f32>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_the_light_is_a_logarithm_away_and_another_hue_counts_more() {
        let apart = |a: [f32; 3], b: [f32; 3]| {
            let (a, b) = (tint_of(a), tint_of(b));
            length([0, 1, 2].map(|c| a[c] - b[c]))
        };
        assert!((apart([0.4; 3], [0.2; 3]) - 2.0_f32.ln()).abs() < 1e-6);
        assert!(apart([0.4, 0.2, 0.2], [0.2; 3]) > apart([0.4; 3], [0.2; 3]));
        assert!(apart([0.001; 3], [0.009; 3]) < 1e-6, "both are black");
    }
}
