//! The photo of the view, and where it is drawn.

use crate::panel::flat::placement::PlacedPicture;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::PhotoId;

/// The photo of the view, and where it is drawn.
pub struct PlacedPhoto {
    /// The photo, by its index.
    pub photo: PhotoId,
    /// The rectangle of its pixels.
    pub bounds: PixelRect,
    /// Its placement in the view.
    pub seen: PlacedPicture,
}
