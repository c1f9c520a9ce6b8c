//! Images in linear light, with depths: for compositing, where 8 bits are too few.

use super::Picture;
use quadratura_base::scene::light::{LINEAR_FROM_BYTE, srgb_from_linear};

/// An image in linear light; rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearPicture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Red, green and blue in linear light with the primaries of sRGB, and alpha: `width * height` pixels, not premultiplied.
    /// White is 1; what is brighter, because the view is exposed longer than a photo, is above. Alpha is the share of the
    /// pixel that is textured.
    pub rgba: Vec<[f32; 4]>,
    /// The depth of the nearest surface at each pixel's centre, along the camera's axis, in units of the world; infinite where
    /// no surface is. `None` where the renderer has no depths.
    pub depths: Option<Vec<f32>>,
}

impl LinearPicture {
    /// Returns an image of 8 bits in linear light, without depths.
    pub fn of(picture: &Picture) -> Self {
        let pixel = |&[r, g, b, alpha]: &[u8; 4]| {
            let [r, g, b] = [r, g, b].map(|byte| LINEAR_FROM_BYTE[usize::from(byte)]);
            [r, g, b, f32::from(alpha) / 255.0]
        };
        let rgba = picture.pixels().iter().map(pixel).collect();
        Self { width: picture.width, height: picture.height, rgba, depths: None }
    }

    /// Returns the image in sRGB with 8 bits a channel; what is brighter than white is white.
    pub fn picture(&self) -> Picture {
        let rgba = self.stored(255.0).map(|value| value as u8).collect();
        Picture { width: self.width, height: self.height, rgba }
    }

    /// Returns the image in sRGB with 16 bits a channel; what is brighter than white is white.
    pub fn srgb_16_bits(&self) -> Vec<u16> {
        self.stored(65535.0).map(|value| value as u16).collect()
    }

    /// Returns red, green, blue in sRGB and alpha of all pixels as whole numbers, of which white is the largest.
    fn stored(&self, white: f64) -> impl Iterator<Item = f64> {
        let pixel = move |&[r, g, b, alpha]: &[f32; 4]| {
            let [r, g, b] = [r, g, b].map(|light| srgb_from_linear(f64::from(light).clamp(0.0, 1.0)));
            [r, g, b, f64::from(alpha).clamp(0.0, 1.0)].map(|value| (value * white).round())
        };
        self.rgba.iter().flat_map(pixel)
    }

    /// Returns the image over a plain colour of sRGB, in linear light; it is opaque.
    pub fn on(&self, background: [u8; 3]) -> Self {
        use quadratura_base::scene::light::linear_of_srgb;

        let below = background.map(|byte| linear_of_srgb(f64::from(byte) / 255.0) as f32);
        let pixel = |&[r, g, b, alpha]: &[f32; 4]| {
            let [r, g, b] = [0, 1, 2].map(|c| [r, g, b][c] * alpha + below[c] * (1.0 - alpha));
            [r, g, b, 1.0]
        };
        Self { rgba: self.rgba.iter().map(pixel).collect(), ..self.clone() }
    }

    /// Returns the share of the image that is textured.
    pub fn textured(&self) -> f64 {
        self.rgba.iter().map(|pixel| f64::from(pixel[3])).sum::<f64>() / self.rgba.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back_and_what_is_brighter_than_white_is_white() {
        let rgba: Vec<u8> = (0..=255).flat_map(|byte| [byte, 255 - byte, byte / 2, byte]).collect();
        let picture = Picture { width: 16, height: 16, rgba };
        let mut linear = LinearPicture::of(&picture);
        assert_eq!(linear.picture(), picture);
        linear.rgba[0] = [7.5, 1.0, -0.1, 1.0];
        assert_eq!(linear.picture().pixels()[0], [255, 255, 0, 255]);
        assert_eq!(linear.srgb_16_bits()[..4], [65535, 65535, 0, 65535]);
        // Half of the light is 0.7354 in sRGB: between two bytes.
        linear.rgba[1] = [0.5, 0.0, 0.0, 0.5];
        assert_eq!(linear.srgb_16_bits()[4..8], [48192, 0, 0, 32768]);
    }

    #[test]
    fn a_background_is_added_as_light() {
        let rgba = vec![[1.0, 0.0, 0.0, 0.25]];
        let picture = LinearPicture { width: 1, height: 1, rgba, depths: Some(vec![2.0]) };
        let on = picture.on([255, 0, 255]);
        assert_eq!((on.rgba[0], on.depths), ([1.0, 0.0, 0.75, 1.0], Some(vec![2.0])));
    }
}
