//! A view with the exposure in which it is drawn.

use quadratura_projection::exposure::ViewExposure;
use quadratura_view::Shot;

/// A view and its exposure, which may be that of a larger view.
#[derive(Clone, Copy)]
pub struct ExposedShot<'a> {
    /// The view.
    pub shot: &'a Shot,
    /// The exposure.
    pub exposure: &'a ViewExposure,
}
