//! The quality of the result: the filling of occluded areas, and matched exposure of the photos.

pub mod colour;
pub mod filling;
pub mod lookup;

use self::colour::ColourDesk;
use self::filling::FillDesk;

/// The state of filling and exposures.
#[derive(Default)]
pub struct QualityState {
    /// Exposures.
    pub colour: ColourDesk,
    /// Fillings.
    pub fill: FillDesk,
}

impl QualityState {
    /// Drops facts that depend on fillings or paint.
    pub fn forget_fillings(&mut self) {
        self.fill.forget_fillings();
    }

    /// Drops facts that depend on stacks.
    pub fn forget_stacks(&mut self) {
        self.fill.forget_stacks();
        self.colour = ColourDesk::default();
    }
}
