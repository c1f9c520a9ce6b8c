//! A photo made small, as one that is asked and as one that answers.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::layers::fill::Donor;
use crate::projection::exposure::Optics;
use crate::projection::exposure::optics::radius2;

/// Black is no darker than this, of white: below, noise and haze decide what a logarithm says.
const BLACK: f32 = 0.01;

/// How much more a difference of hue weighs than one of brightness: shadows move, and hues stay.
const HUE: f32 = 2.0;

/// A colour as it is compared: logarithm of the brightness, and of red and blue against green, each weighed.
pub type Tint = [f32; 3];

/// A small photo.
pub struct Look {
    /// What it shows where.
    pub donor: Donor,
    /// By pixel, row by row, in the common exposure; not a number where nothing of the model is shown.
    tints: Vec<Tint>,
}

impl Look {
    /// Of a donor that was made of the small photo; `gain` takes it to the common exposure (natural logarithms).
    pub fn new(donor: Donor, gain: [f64; 3], optics: &Optics) -> Self {
        let (width, height) = (donor.camera.width, donor.camera.height);
        let tint = |x: u32, y: u32| {
            if !donor.shows_any(x, y) {
                return [f32::NAN; 3];
            }
            let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let light = optics.undone(donor.pixel(x, y).map(f64::from), radius2(&donor.camera, px));
            tint_of([0, 1, 2].map(|c| (light[c] * (-gain[c]).exp()) as f32))
        };
        let row = |y: u32| (0..width).map(move |x| (x, y));
        let tints = (0..height).into_par_iter().flat_map_iter(row).map(|(x, y)| tint(x, y)).collect();
        Self { donor, tints }
    }

    /// The colour at a pixel.
    pub fn tint(&self, x: u32, y: u32) -> Tint {
        self.tints[y as usize * self.donor.camera.width as usize + x as usize]
    }

    /// Where a point of the world lies on it, if within.
    pub fn place(&self, point: DVec3) -> Option<DVec2> {
        let camera = &self.donor.camera;
        let px = camera.image_from_camera(self.donor.pose.camera_from_world(point))?;
        camera.rect().contains_position(px).then_some(px)
    }

    /// How far a colour is from all that lie between those of the pixels at most `reach` rows and columns away.
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

/// Of linear light, full range 1.
fn tint_of(light: [f32; 3]) -> Tint {
    let [r, g, b] = light.map(|light| light.max(BLACK).ln());
    [(r + g + b) / 3.0, HUE * (r - g), HUE * (b - g)]
}

/// How far apart two colours are.
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
