//! sRGB, 8 bits, to linear light and back (IEC 61966-2-1), by table.

use std::sync::LazyLock;

/// Steps of the way back: fine enough that every 8-bit value comes back as it was.
const STEPS: usize = 1 << 16;

static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|i| decoded(i as f64 / 255.0) as f32));

static ENCODED: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let step = |i: usize| (encoded(i as f64 / (STEPS - 1) as f64) * 255.0).round() as u8;
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
        Self { linear: &LINEAR, encoded: &ENCODED }
    }

    /// Linear light, 0..1, of an 8-bit value.
    pub fn linear(&self, value: u8) -> f32 {
        self.linear[usize::from(value)]
    }

    /// The nearest 8-bit value; linear light below 0 and above 1 is clipped.
    pub fn encoded(&self, linear: f32) -> u8 {
        self.encoded[((linear.clamp(0.0, 1.0) * (STEPS - 1) as f32) + 0.5) as usize]
    }
}

fn decoded(value: f64) -> f64 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

fn encoded(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
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
