//! All that pictures of a site are made of, for those who draw it elsewhere.

use std::sync::Arc;

use quadratura_projection::agreement::Agreement;
use quadratura_projection::continuation::Continuation;
use quadratura_projection::dome::Dome;
use quadratura_projection::relief::Relief;
use quadratura_projection::skirts::Skirts;
use quadratura_projection::{Gains, Texels};

/// All that pictures of a site are made of, for those who draw it elsewhere.
pub struct SiteParts {
    /// The model with the skirts on its outlines, which are its last faces.
    pub skirts: Skirts,
    /// The photos' exposures.
    pub gains: Gains,
    /// The depth detail of surfaces, where pictures show it.
    pub relief: Arc<Relief>,
    /// How far photos confirm each other.
    pub agreement: Agreement,
    /// The texels of image layers; those of skirts are made of them.
    pub texels: Arc<dyn Texels>,
    /// What is around in every direction.
    pub dome: Option<Arc<Dome>>,
    /// The colours with which surfaces continue.
    pub continuation: Continuation,
}
