//! Conversion between 8-bit values and linear ones by table, for large numbers of texels: sRGB and linear light, or mattes.

use std::sync::LazyLock;

use glam::Vec4;

use quadratura_base::scene::light::{LINEAR_FROM_BYTE, srgb_from_linear};

/// The number of steps of the table back to sRGB: enough that every 8-bit value is recovered exactly.
const STEPS: usize = 1 << 16;

static ENCODED: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let step = |i: usize| (srgb_from_linear(i as f64 / (STEPS - 1) as f64) * 255.0).round() as u8;
    (0..STEPS).map(step).collect()
});

/// The tables of values that are stored in proportion, such as mattes.
static SHARES: LazyLock<([f32; 256], Vec<u8>)> = LazyLock::new(|| {
    let step = |i: usize| (i as f64 / (STEPS - 1) as f64 * 255.0).round() as u8;
    (std::array::from_fn(|value| value as f32 / 255.0), (0..STEPS).map(step).collect())
});

/// Both conversion tables.
#[derive(Debug, Clone, Copy)]
pub struct Srgb {
    linear: &'static [f32; 256],
    encoded: &'static [u8],
}

impl Srgb {
    /// Returns the tables, which are made at the first call.
    pub fn tables() -> Self {
        Self { linear: &LINEAR_FROM_BYTE, encoded: &ENCODED }
    }

    /// Returns the tables of values that are stored in proportion: 255ths of 1.
    pub fn proportional() -> Self {
        Self { linear: &SHARES.0, encoded: &SHARES.1 }
    }

    /// Converts an 8-bit value to linear light, 0..1.
    #[inline]
    pub fn linear(&self, value: u8) -> f32 {
        self.linear[usize::from(value)]
    }

    /// Converts linear light to the nearest 8-bit value; values outside of 0..1 are clipped.
    #[inline]
    pub fn encoded(&self, linear: f32) -> u8 {
        // Adding 2^23 leaves the rounded number in the lowest bits, which is several times as fast as a cast.
        let step = linear.clamp(0.0, 1.0) * (STEPS - 1) as f32 + 8_388_608.0;
        self.encoded[step.to_bits() as usize % STEPS]
    }

    /// Converts linear light R, G, B, of which the fourth number is left out, as [`Self::encoded`] does.
    #[inline]
    pub fn encoded_colour(&self, linear: Vec4) -> [u8; 3] {
        let steps = linear.max(Vec4::ZERO).min(Vec4::ONE) * (STEPS - 1) as f32 + 8_388_608.0;
        let value = |step: f32| self.encoded[step.to_bits() as usize % STEPS];
        [value(steps.x), value(steps.y), value(steps.z)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_comes_back() {
        for tables in [Srgb::tables(), Srgb::proportional()] {
            for value in 0..=255 {
                assert_eq!(tables.encoded(tables.linear(value)), value);
            }
            assert_eq!((tables.encoded(-1.0), tables.encoded(2.0), tables.encoded(f32::NAN)), (0, 255, 0));
            assert_eq!(tables.encoded_colour(Vec4::new(-1.0, 2.0, f32::NAN, 1.0)), [0, 255, 0]);
        }
    }

    #[test]
    fn half_the_light_is_188() {
        assert_eq!(Srgb::tables().encoded(0.5), 188);
        assert_eq!(Srgb::proportional().encoded(0.5), 128);
    }
}
