//! Sample types of an XCF, and their conversion to 8 or 16 bits with a tone curve.

use std::sync::LazyLock;

use half::f16;

use crate::{Depth, Rounding};
use quadratura_base::scene::light::srgb_from_linear;

/// The encoding of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Precision {
    pub kind: SampleKind,
    /// Whether samples are linear light instead of having a tone curve.
    pub linear: bool,
    /// Whether samples are big-endian. Older versions stored the machine's own order, which is little-endian
    /// on all machines that matter.
    pub big_endian: bool,
}

/// The type of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampleKind {
    U8,
    U16,
    U32,
    F16,
    F32,
    F64,
}

impl Precision {
    /// Returns the precision for the number in the file, whose meaning changed with the version; `None` when
    /// it is unknown.
    pub fn new(version: u32, number: Option<u32>) -> Option<Self> {
        use SampleKind::{F16, F32, F64, U8, U16, U32};
        let (kind, linear) = match (version, number) {
            (_, None) | (4, Some(0)) => (U8, false),
            (4, Some(1)) => (U16, false),
            (4, Some(2)) => (U32, true),
            (4, Some(3)) => (F16, true),
            (4, Some(4)) => (F32, true),
            (4, _) => return None,
            (_, Some(number)) => {
                let kind = match (version, number / 100) {
                    (_, 1) => U8,
                    (_, 2) => U16,
                    (_, 3) => U32,
                    (5 | 6, 4) | (7.., 5) => F16,
                    (5 | 6, 5) | (7.., 6) => F32,
                    (7.., 7) => F64,
                    _ => return None,
                };
                // 50: the curve of the colour profile; 75: always that of sRGB.
                let linear = match number % 100 {
                    0 => true,
                    50 | 75 => false,
                    _ => return None,
                };
                (kind, linear)
            }
        };
        Some(Self { kind, linear, big_endian: version >= 12 })
    }

    /// Returns bytes per sample.
    pub fn bytes(self) -> usize {
        match self.kind {
            SampleKind::U8 => 1,
            SampleKind::U16 | SampleKind::F16 => 2,
            SampleKind::U32 | SampleKind::F32 => 4,
            SampleKind::F64 => 8,
        }
    }

    /// Returns the depth to convert to: linear light in 8 bits would lose the shadows with a tone curve.
    pub fn depth(self) -> Depth {
        if self.kind == SampleKind::U8 && !self.linear { Depth::Eight } else { Depth::Sixteen }
    }

    /// Returns how coarsely colours are stored, where that differs from the depth to convert to.
    pub fn rounding(self) -> Option<Rounding> {
        let (step, is_float) = match self.kind {
            SampleKind::U8 => (1.0 / 255.0, false),
            SampleKind::U16 => (1.0 / 65535.0, false),
            SampleKind::F16 => (f64::from(f16::EPSILON), true),
            SampleKind::U32 | SampleKind::F32 | SampleKind::F64 => (0.0, false),
        };
        let is_plain = !self.linear && !is_float;
        (!is_plain).then_some(Rounding { linear: self.linear, step, is_float })
    }

    /// Returns a note for the user about the conversion; `None` if nothing is lost.
    pub fn note(self) -> Option<String> {
        let kind = match self.kind {
            SampleKind::U8 | SampleKind::U16 => "",
            SampleKind::U32 => "32-bit",
            SampleKind::F16 | SampleKind::F32 | SampleKind::F64 => "floating-point",
        };
        let light = if self.linear { "linear-light" } else { "" };
        let what = [kind, light].into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>();
        (!what.is_empty()).then(|| {
            let few = match self.kind == SampleKind::U8 {
                true => "; 8 bits of linear light have few dark shades, so dark paint is coarse: use perceptual gamma",
                false => "",
            };
            format!("the {} pixels are converted to 16 bits with a tone curve and rounded{few}", what.join(" "))
        })
    }

    /// Converts a sample to 16 bits. Linear light (`linear`) gets the tone curve of sRGB.
    pub fn sample16(self, bytes: &[u8], linear: bool) -> u16 {
        match self.kind {
            SampleKind::U8 => curved(u16::from(bytes[0]) * 257, linear),
            SampleKind::U16 => curved(u16::from_be_bytes(self.ordered(bytes)), linear),
            SampleKind::U32 => {
                rounded(f64::from(u32::from_be_bytes(self.ordered(bytes))) / f64::from(u32::MAX), linear)
            }
            SampleKind::F16 => rounded(f16::from_be_bytes(self.ordered(bytes)).to_f64(), linear),
            SampleKind::F32 => rounded(f32::from_be_bytes(self.ordered(bytes)).into(), linear),
            SampleKind::F64 => rounded(f64::from_be_bytes(self.ordered(bytes)), linear),
        }
    }

    fn ordered<const N: usize>(self, bytes: &[u8]) -> [u8; N] {
        let mut ordered = [0; N];
        ordered.copy_from_slice(bytes);
        if !self.big_endian {
            ordered.reverse();
        }
        ordered
    }
}

/// Every 16-bit value with the tone curve applied.
static CURVED: LazyLock<Vec<u16>> =
    LazyLock::new(|| (0..=u16::MAX).map(|value| rounded(f64::from(value) / 65535.0, true)).collect());

fn curved(value: u16, linear: bool) -> u16 {
    if linear { CURVED[usize::from(value)] } else { value }
}

/// Rounds to 16 bits. Values beyond black and white are clipped; what is not a number becomes black.
fn rounded(value: f64, linear: bool) -> u16 {
    let value = value.clamp(0.0, 1.0);
    ((if linear { srgb_from_linear(value) } else { value }) * 65535.0).round() as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    fn precision(version: u32, number: u32) -> Precision {
        Precision::new(version, Some(number)).unwrap()
    }

    #[test]
    fn the_same_number_means_other_things_in_other_versions() {
        assert_eq!(Precision::new(3, None).unwrap().depth(), Depth::Eight);
        assert_eq!((precision(4, 1).kind, precision(4, 1).linear), (SampleKind::U16, false));
        assert_eq!((precision(6, 500).kind, precision(7, 500).kind), (SampleKind::F32, SampleKind::F16));
        assert_eq!((precision(14, 275).kind, precision(14, 275).linear), (SampleKind::U16, false));
        for (version, number) in [(4, 5), (4, 150), (6, 750), (7, 450), (12, 210), (12, 0), (12, u32::MAX)] {
            assert_eq!(Precision::new(version, Some(number)), None, "{number} in version {version}");
        }
    }

    #[test]
    fn colours_that_differ_by_the_rounding_of_the_file_only_are_the_same() {
        for (number, steps) in [(100, 255.0), (200, 65535.0), (500, 0.0), (600, 0.0)] {
            let precision = precision(12, number);
            let rounding = precision.rounding().unwrap();
            for value in (0..=255u16).map(|value| value * 257) {
                let light = quadratura_base::scene::light::linear_of_srgb(f64::from(value) / 65535.0);
                let bytes = match number {
                    100 => vec![(light * steps) as u8],
                    200 => ((light * steps) as u16).to_be_bytes().to_vec(),
                    500 => f16::from_f64(light).to_be_bytes().to_vec(),
                    _ => (light as f32).to_be_bytes().to_vec(),
                };
                let found = precision.sample16(&bytes, true);
                let colour = |value: u16| [value, value, value, u16::MAX];
                assert!(rounding.is_same(colour(value), colour(found)), "{number}: {value} as {found}");
                assert!(
                    !rounding.is_same(colour(value), colour(found.wrapping_add(12_000))),
                    "{number}: {value}"
                );
            }
        }
        assert_eq!((precision(12, 150).rounding(), precision(12, 250).rounding()), (None, None));
    }

    #[test]
    fn bytes_are_turned_in_old_versions() {
        assert_eq!(precision(12, 250).sample16(&[1, 2], false), 0x0102);
        assert_eq!(precision(11, 250).sample16(&[1, 2], false), 0x0201);
    }

    #[test]
    fn floating_point_and_32_bits_become_the_nearest_16() {
        assert_eq!(precision(12, 650).sample16(&0.5f32.to_be_bytes(), false), 32768);
        assert_eq!(precision(12, 650).sample16(&f32::NAN.to_be_bytes(), false), 0);
        assert_eq!(precision(12, 750).sample16(&7f64.to_be_bytes(), false), 65535);
        assert_eq!(precision(7, 550).sample16(&f16::from_f32(0.25).to_le_bytes(), false), 16384);
        assert_eq!(precision(12, 350).sample16(&u32::MAX.to_be_bytes(), false), 65535);
    }

    #[test]
    fn linear_light_gets_the_tone_curve_and_alpha_does_not() {
        // 0.2140 is the light of half the sRGB range.
        assert_eq!(precision(12, 600).sample16(&0.214_041_14f32.to_be_bytes(), true) / 64, 32768 / 64);
        assert_eq!(precision(12, 100).sample16(&[55], true), CURVED[55 * 257]);
        assert_eq!(precision(12, 200).sample16(&[0x80, 0], false), 0x8000);
        assert_eq!((CURVED[0], CURVED[65535]), (0, 65535));
    }
}
