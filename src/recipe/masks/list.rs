//! What is masked, as people look at it.

use serde::Serialize;

use crate::document::Masks;
use crate::error::Result;
use crate::io::photo::masked_pixels;
use crate::scene::{Photo, Site};

/// The masks of one photo.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MaskedPhoto {
    /// Its name.
    pub photo: String,
    /// Pixels that some mask covers.
    pub pixels: u64,
    /// Of the photo's pixels, 0 to 1.
    pub share: f64,
    /// One of each maker.
    pub masks: Vec<MaskShare>,
}

/// One mask.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MaskShare {
    /// Who made it, in words.
    pub from: String,
    /// Masked pixels.
    pub pixels: u64,
    /// Below `masks/`.
    pub file: String,
}

/// The photos of the site that have masks, in its order.
///
/// # Errors
/// [`crate::Error::Input`] and [`crate::Error::Io`] for a mask that cannot be read.
pub fn masked_photos(site: &Site, masks: &Masks) -> Result<Vec<MaskedPhoto>> {
    let masked = site.photos.iter().filter(|photo| !photo.masks.is_empty());
    masked.map(|photo| masked_photo(photo, masks)).collect()
}

fn masked_photo(photo: &Photo, masks: &Masks) -> Result<MaskedPhoto> {
    let pixels = masked_pixels(photo)?.count();
    let all = f64::from(photo.camera.width) * f64::from(photo.camera.height);
    let of_maker = masks.of(&photo.name).iter().map(|mask| MaskShare {
        from: mask.from.words(),
        pixels: mask.pixels,
        file: mask.file.clone(),
    });
    Ok(MaskedPhoto {
        photo: photo.name.clone(),
        pixels,
        share: pixels as f64 / all,
        masks: of_maker.collect(),
    })
}
