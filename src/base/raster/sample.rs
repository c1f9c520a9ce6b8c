//! Samples of 8 and of 16 bits: their range, and how numbers become samples.

/// A sample of an image: `u8` or `u16`, its full range 0 to [`Sample::FULL`].
pub trait Sample: Copy + PartialEq + PartialOrd + Default + Send + Sync + 'static {
    /// The largest value: white, or opaque.
    const FULL: Self;

    /// Returns the sample as a number, 0 to full.
    fn value(self) -> f32;

    /// Returns the sample as a number, 0 to full.
    fn number(self) -> f64;

    /// Returns the sample as a whole number, 0 to full.
    fn whole(self) -> u64;

    /// Rounds a number to the nearest sample; numbers beyond either end of the range become that end.
    fn nearest(value: f32) -> Self;

    /// Rounds a number to the nearest sample; numbers beyond either end of the range become that end.
    fn rounded(number: f64) -> Self;

    /// Converts a whole number of the sample's range; the highest bits of larger ones are lost.
    fn narrowed(whole: u64) -> Self;

    /// Converts to 16 bits: 8 bits are scaled to the full range, which loses nothing.
    fn in_16_bits(self) -> u16;

    /// Rounds a 16-bit sample to the nearest one.
    fn of_16_bits(sample: u16) -> Self;
}

impl Sample for u8 {
    const FULL: Self = Self::MAX;

    #[inline]
    fn value(self) -> f32 {
        self.into()
    }

    #[inline]
    fn number(self) -> f64 {
        self.into()
    }

    #[inline]
    fn whole(self) -> u64 {
        self.into()
    }

    #[inline]
    fn nearest(value: f32) -> Self {
        (value + 0.5) as Self
    }

    #[inline]
    fn rounded(number: f64) -> Self {
        number.round() as Self
    }

    #[inline]
    fn narrowed(whole: u64) -> Self {
        whole as Self
    }

    #[inline]
    fn in_16_bits(self) -> u16 {
        u16::from(self) * 257
    }

    #[inline]
    fn of_16_bits(sample: u16) -> Self {
        in_8_bits(sample)
    }
}

impl Sample for u16 {
    const FULL: Self = Self::MAX;

    #[inline]
    fn value(self) -> f32 {
        self.into()
    }

    #[inline]
    fn number(self) -> f64 {
        self.into()
    }

    #[inline]
    fn whole(self) -> u64 {
        self.into()
    }

    #[inline]
    fn nearest(value: f32) -> Self {
        (value + 0.5) as Self
    }

    #[inline]
    fn rounded(number: f64) -> Self {
        number.round() as Self
    }

    #[inline]
    fn narrowed(whole: u64) -> Self {
        whole as Self
    }

    #[inline]
    fn in_16_bits(self) -> u16 {
        self
    }

    #[inline]
    fn of_16_bits(sample: u16) -> Self {
        sample
    }
}

/// Rounds a 16-bit sample to the nearest 8-bit one, by their full ranges: 257 steps of 16 bits are one of 8.
#[inline]
pub fn in_8_bits(sample: u16) -> u8 {
    ((u32::from(sample) + 128) / 257) as u8
}

/// Adds full alpha to the samples of RGB pixels.
pub fn with_alpha<T: Sample>(rgb: &[T]) -> Vec<T> {
    let (pixels, _) = rgb.as_chunks::<3>();
    pixels.iter().map(|&[r, g, b]| [r, g, b, T::FULL]).collect::<Vec<_>>().into_flattened()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_of_16_bits_becomes_the_nearest_of_8_and_every_one_of_8_comes_back() {
        for sample in 0..=u16::MAX {
            // The exact share of the range, in whole numbers: 255 / 65535 = 1 / 257, never half a step.
            assert_eq!(u32::from(in_8_bits(sample)), (2 * u32::from(sample) + 257) / 514, "{sample}");
        }
        assert!((0..=u8::MAX).all(|sample| u8::of_16_bits(sample.in_16_bits()) == sample));
        assert_eq!((u16::of_16_bits(513), 513_u16.in_16_bits()), (513, 513));
    }

    #[test]
    fn numbers_beyond_the_range_become_its_ends() {
        assert_eq!([-3.0, 0.4, 0.6, 254.6, 300.0].map(u8::nearest), [0, 0, 1, 255, 255]);
        assert_eq!([-3.0, 0.4, 0.5, 65534.6, 7e4].map(u16::rounded), [0, 0, 1, 65535, 65535]);
    }

    #[test]
    fn what_has_no_alpha_is_opaque() {
        assert_eq!(with_alpha(&[1_u16, 2, 3, 4, 5, 6]), [1, 2, 3, 65535, 4, 5, 6, 65535]);
    }
}
