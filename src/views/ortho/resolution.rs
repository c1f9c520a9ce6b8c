//! The size of a pixel, and the scale of a print.

use quadratura_base::error::{Error, Result};

/// How finely an orthophoto is drawn and printed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolution {
    /// The side of a pixel on the surface, in metres.
    pub pixel_m: f64,
    /// The number of the scale: 50 for 1:50.
    pub scale: f64,
    /// Pixels per inch on paper.
    pub dpi: f64,
}

/// The pixels per inch where nothing is said.
const USUAL_DPI: f64 = 300.0;
/// The scales of drawings that are chosen from.
const SCALES: [f64; 11] = [1.0, 2.0, 5.0, 10.0, 20.0, 25.0, 50.0, 100.0, 200.0, 500.0, 1000.0];
pub(super) const INCH_M: f64 = 0.0254;

impl Resolution {
    /// Returns the resolution of what is given: scale and dpi, a pixel's side in metres, or scale and pixel. Of a pixel alone the scale is
    /// the usual one of drawings with nearest to 300 pixels per inch.
    ///
    /// # Errors
    /// Returns [`Error::Usage`] when neither a scale nor a pixel is given, and for all three.
    pub fn new(scale: Option<f64>, dpi: Option<f64>, pixel_m: Option<f64>) -> Result<Self> {
        let of_dpi = |scale: f64, dpi: f64| Self { pixel_m: scale * INCH_M / dpi, scale, dpi };
        let of_pixel = |scale: f64, pixel_m: f64| Self { pixel_m, scale, dpi: scale * INCH_M / pixel_m };
        match (scale, dpi, pixel_m) {
            (Some(scale), dpi, None) => Ok(of_dpi(scale, dpi.unwrap_or(USUAL_DPI))),
            (Some(scale), None, Some(pixel_m)) => Ok(of_pixel(scale, pixel_m)),
            (None, Some(dpi), Some(pixel_m)) => Ok(of_pixel(dpi * pixel_m / INCH_M, pixel_m)),
            (None, None, Some(pixel_m)) => {
                let off = |scale: &f64| (of_pixel(*scale, pixel_m).dpi / USUAL_DPI).ln().abs();
                let nearest = SCALES.into_iter().min_by(|a, b| off(a).total_cmp(&off(b)));
                Ok(of_pixel(nearest.unwrap_or(1.0), pixel_m))
            }
            (Some(_), Some(_), Some(_)) => {
                Err(Error::Usage("--scale, --dpi and --gsd say the same twice; give two of them".into()))
            }
            (None, _, None) => {
                Err(Error::Usage("give the resolution: --scale 1:50, with --dpi 300, or --gsd 2mm".into()))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_and_dots_say_the_pixel_and_a_pixel_says_a_usual_scale() {
        let of_scale = Resolution::new(Some(50.0), None, None).unwrap();
        assert!((of_scale.pixel_m - 0.004_233_333).abs() < 1e-8 && of_scale.dpi == 300.0);
        let of_pixel = Resolution::new(None, None, Some(0.002)).unwrap();
        assert_eq!((of_pixel.scale, of_pixel.dpi.round()), (25.0, 318.0));
        let of_both = Resolution::new(Some(20.0), None, Some(0.002)).unwrap();
        assert_eq!(of_both.dpi.round(), 254.0);
        assert!(Resolution::new(None, Some(300.0), None).is_err());
        assert!(Resolution::new(Some(1.0), Some(1.0), Some(1.0)).is_err());
    }
}
