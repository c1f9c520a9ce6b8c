//! Images of one sample per pixel: masks of layers.

use super::depth::Depth;
use quadratura_base::scene::Samples;

/// An image of one sample per pixel; rows from the top, pixels from the left.
#[derive(Debug, Clone, PartialEq)]
pub struct Grey {
    width: u32,
    height: u32,
    samples: Samples,
}

impl Grey {
    /// Takes `width * height` samples.
    ///
    /// # Panics
    /// When there are fewer or more.
    pub fn new(width: u32, height: u32, samples: Samples) -> Self {
        assert_eq!(samples.len(), width as usize * height as usize, "one sample per pixel");
        Self { width, height, samples }
    }

    /// Returns the width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns the bit depth.
    pub fn depth(&self) -> Depth {
        Depth::from_samples(&self.samples)
    }

    /// Returns the samples in the order of [`Grey`].
    pub fn samples(&self) -> &Samples {
        &self.samples
    }

    /// Returns the sample in column `x`, row `y`, scaled to 0..=1.
    pub fn at(&self, x: u32, y: u32) -> f32 {
        let index = y as usize * self.width as usize + x as usize;
        match &self.samples {
            Samples::U8(s) => f32::from(s[index]) / 255.0,
            Samples::U16(s) => f32::from(s[index]) / 65535.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_is_read_as_a_share_of_the_full_range() {
        let eight = Grey::new(2, 2, Samples::U8(vec![0, 255, 51, 1]));
        assert_eq!((eight.at(1, 0), eight.at(0, 1)), (1.0, 0.2));
        let sixteen = Grey::new(1, 2, Samples::U16(vec![0, 65535]));
        assert_eq!((sixteen.at(0, 1), sixteen.depth()), (1.0, Depth::Sixteen));
    }
}
