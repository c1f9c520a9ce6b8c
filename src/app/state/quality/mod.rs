//! The quality of the result: the filling of occluded areas, and matched exposure of the photos.

pub mod colour;
pub mod filling;
pub mod lookup;
mod queries;
pub mod request;

use self::colour::ColourSession;
use self::filling::FillSession;

/// The state of filling and exposures.
#[derive(Default)]
pub struct QualityState {
    /// Exposures.
    pub colour: ColourSession,
    /// Fillings.
    pub fill: FillSession,
}

impl QualityState {
    /// Drops facts that depend on fillings or paint.
    pub fn forget_fillings(&mut self) {
        self.fill.forget_fillings();
    }

    /// Drops facts that depend on stacks.
    pub fn forget_stacks(&mut self) {
        self.fill.forget_stacks();
        self.colour = ColourSession::default();
    }
}
