//! What a photo shows: its pixels, without what is masked.

use super::read_photo;
use crate::error::Result;
use crate::geometry::Spans;
use crate::io::mask_file::read_mask;
use crate::scene::{Photo, PhotoPixels};

/// The pixels of a photo, valid where it shows the site: what its masks cover is not valid, whatever it has been
/// before. All that is made of a photo begins here; whoever wants to look at the photo itself reads its file.
///
/// # Errors
/// As [`read_photo`], and [`crate::Error::Input`] for a mask of another size.
pub fn read_shown(photo: &Photo) -> Result<PhotoPixels> {
    let (width, height) = (photo.camera.width, photo.camera.height);
    let masked = masked_pixels(photo)?;
    Ok(read_photo(&photo.file, width, height)?.without(&masked))
}

/// What is masked in a photo, by all of its masks together; in its own pixels.
///
/// # Errors
/// [`crate::Error::Input`] and [`crate::Error::Io`] for a mask that cannot be read.
pub fn masked_pixels(photo: &Photo) -> Result<Spans> {
    let size = [photo.camera.width, photo.camera.height];
    let all = photo.masks.iter().map(|mask| read_mask(mask, size));
    all.reduce(|a, b| Ok(a?.union(&b?))).unwrap_or_else(|| Ok(Spans::default()))
}
