//! sRGB, 8 bits, to linear light and back, by table: for many texels.

use std::sync::LazyLock;

use crate::scene::light::{LINEAR_OF_BYTE, srgb_of_linear};

/// Steps of the way back: fine enough that every 8-bit value comes back as it was.
const STEPS: usize = 1 << 16;

static ENCODED: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let step = |i: usize| (srgb_of_linear(i as f64 / (STEPS - 1) as f64) * 255.0).round() as u8;
    (0..STEPS).map(step).collect()
});

/// Both tables, looked up once.
#[derive(Debug, Clone, Copy)]
pub struct Srgb {
    linear: &'static [f32; 256],
    encoded: &'static [u8],
}

impl Srgb {
    /// The tables; made at the first call.
    pub fn tables() -> Self {
        Self { linear: &LINEAR_OF_BYTE, encoded: &ENCODED }
    }

    /// Linear light, 0..1, of an 8-bit value.
    pub fn linear(&self, value: u8) -> f32 {
        self.linear[usize::from(value)]
    }

    /// The nearest 8-bit value; linear light below 0 and above 1 is clipped.
    pub fn encoded(&self, linear: f32) -> u8 {
        // Adding 2^23 leaves the rounded number in the lowest bits: several times as fast as a cast.
        let step = linear.clamp(0.0, 1.0) * (STEPS - 1) as f32 + 8_388_608.0;
        self.encoded[step.to_bits() as usize % STEPS]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_comes_back() {
        let srgb = Srgb::tables();
        for value in 0..=255 {
            assert_eq!(srgb.encoded(srgb.linear(value)), value);
        }
        assert_eq!((srgb.encoded(-1.0), srgb.encoded(2.0), srgb.encoded(f32::NAN)), (0, 255, 0));
    }

    #[test]
    fn half_the_light_is_188() {
        assert_eq!(Srgb::tables().encoded(0.5), 188);
    }
}
