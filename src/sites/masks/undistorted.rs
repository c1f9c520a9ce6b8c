//! Conversion of a mask of the photo as taken to one of its pinhole image.

use std::path::Path;

use glam::DVec2;

use quadratura_base::error::Result;
use quadratura_base::geometry::{PixelRect, Spans, Undistortion};
use quadratura_base::raster::bilinear::BilinearCorner;
use quadratura_import::cameras::CameraPhoto;
use quadratura_io::mask_file::read_mask;

/// Reads a mask of the photo as taken and returns the masked pixels of the pinhole image.
///
/// # Errors
/// Returns the errors of [`read_mask`]. A lens without a valid range is reported when the photo is imported.
pub(super) fn read_undistorted(file: &Path, photo: &CameraPhoto) -> Result<Spans> {
    let masked = read_mask(file, [photo.camera.width, photo.camera.height])?;
    if photo.is_pinhole() {
        return Ok(masked);
    }
    let undistortion = photo.undistortion();
    Ok(undistortion.map_or_else(Spans::default, |to| undistorted(&masked, &to)))
}

/// Masks a pixel where one of the four pixels around its position in the photo is masked, because resampling mixes
/// them.
fn undistorted(masked: &Spans, undistortion: &Undistortion) -> Spans {
    let (w, h) = (undistortion.pinhole.width, undistortion.pinhole.height);
    let is_masked = |x: i32, y: i32| {
        let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let Some(at) = undistortion.photo_from_pinhole(centre) else { return false };
        BilinearCorner::from_px(at).taps().iter().any(|(x, y, _)| masked.holds(*x, *y))
    };
    Spans::of_pixels(PixelRect::of_size(w, h), is_masked)
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::geometry::{Lens, Pinhole};

    #[test]
    fn a_mask_bends_with_its_photo() {
        let photo = Pinhole { width: 200, height: 120, fx: 150.0, fy: 150.0, cx: 100.0, cy: 60.0 };
        let to = Undistortion::new(&photo, Lens::Division { k: -0.2 }).unwrap();
        let block = PixelRect { x: 20, y: 15, w: 12, h: 9 };
        let bent = undistorted(&Spans::of_pixels(block, |_, _| true), &to);
        for (x, y) in [(26, 19), (21, 16), (30, 22)] {
            let at = to.pinhole_from_photo(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)).unwrap();
            assert!(bent.holds(at.x as i32, at.y as i32), "{x} {y}");
        }
        for (x, y) in [(17, 19), (26, 12), (35, 19), (26, 27)] {
            let at = to.pinhole_from_photo(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)).unwrap();
            assert!(!bent.holds(at.x as i32, at.y as i32), "{x} {y}");
        }
    }
}
