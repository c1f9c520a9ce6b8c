//! What is known of a view before it is drawn.

use super::Renderer;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_projection::exposure::ViewExposure;
use quadratura_view::{DisplayMode, Shot};

/// What is drawn of a view's surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DrawnSurfaces {
    /// The nearest ones.
    Nearest,
    /// The nearest ones, if memory holds all texels that they need; else nothing ([`Prepared::is_short`]).
    NearestIfTheyFit,
    /// All, layer by layer.
    All,
}

/// What the tables of a view say about its passes.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Prepared {
    /// Whether there are optics to undo.
    pub(super) undoes_optics: bool,
    /// Whether the surroundings may be seen.
    pub(super) has_surroundings: bool,
    /// The number of corners of skirts.
    pub(super) skirts: u32,
    /// The number of corners of see-through faces.
    pub(super) see_through: u32,
    /// The factor on linear colours in the common exposure.
    pub(super) of_common: [f64; 3],
    /// Whether see-through faces are left out.
    pub(super) opaque_alone: bool,
    /// Whether memory did not hold all texels that are needed.
    pub(super) is_short: bool,
}

impl Renderer {
    /// Prepares the image of a view, or of a band of an image whose exposure is given.
    pub(super) fn prepare_picture(
        &mut self,
        shot: &Shot,
        side_px: u32,
        exposure: Option<&ViewExposure>,
        shown: DrawnSurfaces,
        task: &Task,
    ) -> Result<Prepared> {
        if shot.display == DisplayMode::Provenance && self.origins.is_none() {
            return Err(Error::Request("the renderer was given no source of texels".into()));
        }
        let gpu = self.gpu.clone();
        gpu.guarded("preparing a picture", || self.prepare(shot, side_px, exposure, shown, task))
    }
}
