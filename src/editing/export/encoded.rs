//! How much darker or lighter see-through layers are in editors that lay layers over each other in encoded values, not in
//! linear light.

use std::sync::Arc;

use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::light::{linear_of_srgb, srgb_from_linear};
use quadratura_layered_files::Raster;

/// A layer of a document.
pub struct LaidLayer {
    /// The rectangle of its pixels, in photo pixels.
    pub rect: PixelRect,
    /// The pixels.
    pub pixels: Arc<Raster>,
    /// Whether it is meant to be laid over others in linear light.
    pub linear_light: bool,
}

/// A pixel of both pictures, each encoded, 0 to 1.
#[derive(Debug, Clone, Copy, Default)]
struct BothPictures {
    in_light: [f32; 3],
    encoded: [f32; 3],
}

/// Returns the largest difference of both pictures within `rect`, as a share of the full range; `layers` are from the
/// farthest to the nearest.
///
/// # Errors
/// Those of the layers.
pub fn largest_difference(rect: PixelRect, layers: impl Iterator<Item = Result<LaidLayer>>) -> Result<f64> {
    let mut pictures = vec![BothPictures::default(); rect.area() as usize];
    for layer in layers {
        let LaidLayer { rect: of_layer, pixels, linear_light } = layer?;
        for (x, y) in of_layer.intersection(&rect).pixels() {
            let [r, g, b, a] = pixels.rgba16((x - of_layer.x) as u32, (y - of_layer.y) as u32);
            if a == 0 {
                continue;
            }
            let alpha = f32::from(a) / 65535.0;
            let above = [r, g, b].map(|sample| f32::from(sample) / 65535.0);
            let pixel = &mut pictures[rect.offset(x, y)];
            let BothPictures { in_light: light, encoded } = pixel;
            for (above, (light, encoded)) in above.iter().zip(light.iter_mut().zip(encoded)) {
                let mix = |below: f32| above * alpha + below * (1.0 - alpha);
                *light = match linear_light && a < u16::MAX {
                    true => in_light(*above, alpha, *light),
                    false => mix(*light),
                };
                *encoded = mix(*encoded);
            }
        }
    }
    let off = |pixel: &BothPictures| {
        (0..3).map(|c| f64::from((pixel.in_light[c] - pixel.encoded[c]).abs())).fold(0.0, f64::max)
    };
    Ok(pictures.iter().map(off).fold(0.0, f64::max))
}

/// Mixes encoded samples in linear light.
fn in_light(above: f32, alpha: f32, below: f32) -> f32 {
    let light = |sample: f32| linear_of_srgb(f64::from(sample));
    let alpha = f64::from(alpha);
    srgb_from_linear(light(above) * alpha + light(below) * (1.0 - alpha)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::Samples;

    fn layer(texels: &[[u8; 4]], linear_light: bool) -> LaidLayer {
        let rect = PixelRect::of_size(texels.len() as u32, 1);
        let pixels = Raster::new(rect.w, 1, Samples::U8(texels.as_flattened().to_vec()));
        LaidLayer { rect, pixels: Arc::new(pixels), linear_light }
    }

    #[test]
    fn half_of_black_over_white_is_darker_in_encoded_values() {
        let rect = PixelRect::of_size(2, 1);
        let of = |linear_light| {
            let layers = [layer(&[[255; 4]; 2], false), layer(&[[0, 0, 0, 128], [0; 4]], linear_light)];
            largest_difference(rect, layers.into_iter().map(Ok)).unwrap()
        };
        // Half the light is 188 of 255, half the value 127.
        assert!((of(true) * 255.0 - 60.5).abs() < 1.0, "{}", of(true) * 255.0);
        assert_eq!(of(false), 0.0);
    }

    #[test]
    fn solid_layers_are_the_same_in_both() {
        let layers =
            [layer(&[[9, 80, 200, 255]; 3], false), layer(&[[70, 3, 9, 255], [1, 2, 3, 0], [0; 4]], true)];
        assert_eq!(largest_difference(PixelRect::of_size(3, 1), layers.into_iter().map(Ok)).unwrap(), 0.0);
    }
}
