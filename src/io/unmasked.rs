//! Reads the unmasked pixels of a photo.

use crate::mask_file::read_mask;
use quadratura_base::error::Result;
use quadratura_base::geometry::Spans;
use quadratura_base::scene::{Photo, PhotoPixels};
use quadratura_import::photo::read_photo;

/// Reads the pixels of a photo; masked pixels are not valid. Everything that is derived from a photo starts
/// with this function; only a view of the photo itself reads the file directly.
///
/// # Errors
/// As [`read_photo`], and [`quadratura_base::Error::Input`] for a mask of another size.
pub fn read_unmasked(photo: &Photo) -> Result<PhotoPixels> {
    let (width, height) = (photo.camera.width, photo.camera.height);
    let masked = masked_pixels(photo)?;
    Ok(read_photo(&photo.file, width, height)?.without(&masked))
}

/// Reads the pixels that any of the photo's masks covers, in photo pixels.
///
/// # Errors
/// [`quadratura_base::Error::Input`] and [`quadratura_base::Error::Io`] for a mask that cannot be read.
pub fn masked_pixels(photo: &Photo) -> Result<Spans> {
    let size = [photo.camera.width, photo.camera.height];
    let all = photo.masks.iter().map(|mask| read_mask(mask, size));
    all.reduce(|a, b| Ok(a?.union(&b?))).unwrap_or_else(|| Ok(Spans::default()))
}
