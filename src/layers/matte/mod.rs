//! Mattes: how much of a see-through surface each pixel of a photo shows.
//!
//! A pixel shows `alpha F + (1 - alpha) B` in linear light: the foreground F as far as the surface covers it, and the
//! background B behind. Where both are certain alpha is 1 or 0; the band between is solved from the photo's colours
//! (`closed_form`), and the foreground's own colours follow (`foreground`).

pub mod closed_form;
pub mod foreground;

pub use closed_form::{ClosedForm, closed_form};
pub use foreground::{Foreground, foreground};

use crate::raster::Image;

/// The matte of an object in a photo, and the object's own colours.
#[derive(Debug, Clone, PartialEq)]
pub struct Matte {
    /// The unique name of the object.
    pub object: String,
    /// For the part of the photo that the object covers, in photo pixels: its own colour (sRGB) and the matte, in 255ths.
    /// Where the matte is 255 the colour is the photo's.
    pub texels: Image<[u8; 4]>,
}
