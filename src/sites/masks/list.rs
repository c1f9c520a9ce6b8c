//! Listing of masks.

use serde::Serialize;

use quadratura_base::error::Result;
use quadratura_base::scene::{Photo, Site};
use quadratura_document::Masks;
use quadratura_io::unmasked::masked_pixels;

/// The masks of one photo.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MaskedPhoto {
    /// The photo's name.
    pub photo: String,
    /// The number of pixels that any mask covers.
    pub pixels: u64,
    /// The masked share of the photo's pixels, 0..=1.
    pub share: f64,
    /// The masks, one of each origin.
    pub masks: Vec<MaskShare>,
}

/// A mask of a photo.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MaskShare {
    /// The origin in words.
    pub from: String,
    /// The number of masked pixels.
    pub pixels: u64,
    /// The file below `masks/`.
    pub file: String,
}

/// Returns the photos of the site that have masks, in its order.
///
/// # Errors
/// Returns [`quadratura_base::Error::Input`] and [`quadratura_base::Error::Io`] for a mask that cannot be read.
pub fn masked_photos(site: &Site, masks: &Masks) -> Result<Vec<MaskedPhoto>> {
    let masked = site.photos.iter().filter(|photo| !photo.masks.is_empty());
    masked.map(|photo| masked_photo(photo, masks)).collect()
}

/// Lists the masks of one photo.
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
