//! The quality of the result: how hidden parts are filled, and how photos are brought to one exposure.

pub mod colour;
pub mod filling;
pub mod lookup;

use self::colour::ColourDesk;
use self::filling::FillDesk;

/// What is known and being decided about it.
#[derive(Default)]
pub struct Quality {
    /// Exposures.
    pub colour: ColourDesk,
    /// Fillings.
    pub fill: FillDesk,
}

impl Quality {
    /// Fillings or paint are other ones now.
    pub fn forget_fillings(&mut self) {
        self.fill.forget_fillings();
    }

    /// Stacks are other ones now.
    pub fn forget_stacks(&mut self) {
        self.fill.forget_stacks();
        self.colour = ColourDesk::default();
    }
}
