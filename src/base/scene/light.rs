//! Conversion between stored values and linear light: the sRGB curve (IEC 61966-2-1).

use std::sync::LazyLock;

/// Converts a stored sRGB value, 0..=1, to linear light, 0..=1.
pub fn linear_of_srgb(value: f64) -> f64 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// Converts linear light, 0..=1, to a stored sRGB value, 0..=1.
pub fn srgb_from_linear(light: f64) -> f64 {
    if light <= 0.003_130_8 { light * 12.92 } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 }
}

/// The linear light of each of the 256 byte values; see [`linear_of_srgb`].
pub static LINEAR_FROM_BYTE: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| linear_of_srgb(byte as f64 / 255.0) as f32));

/// Returns a table from each stored byte to the byte whose light is `factor` times as much, clipped at white.
pub fn bytes_of_light_times(factor: f64) -> [u8; 256] {
    let brought = |value: f64| srgb_from_linear((linear_of_srgb(value) * factor).min(1.0));
    std::array::from_fn(|byte| (brought(byte as f64 / 255.0) * 255.0).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stop_more_is_twice_the_light_and_none_changes_nothing() {
        let twice = bytes_of_light_times(2.0);
        assert_eq!([twice[0], twice[100], twice[200], twice[255]], [0, 138, 255, 255]);
        assert!(bytes_of_light_times(1.0).iter().enumerate().all(|(byte, same)| byte == usize::from(*same)));
    }

    #[test]
    fn every_byte_comes_back() {
        for byte in 0..=255u8 {
            let light = f64::from(LINEAR_FROM_BYTE[usize::from(byte)]);
            assert_eq!((srgb_from_linear(light) * 255.0).round() as u8, byte);
        }
        assert_eq!((linear_of_srgb(0.0), linear_of_srgb(1.0)), (0.0, 1.0));
        // A grey card: 18 % of the light is stored as 46 %.
        assert!((srgb_from_linear(0.18) - 0.4613).abs() < 1e-4);
    }
}
