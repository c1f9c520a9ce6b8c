//! Layered depth images of a project: made of the stacks of its photos, kept in `cache/ldi/` or written to a file, and
//! rendered.

mod build;
mod controller;
mod cover;
mod depth_fit;
#[cfg(test)]
mod depth_tests;
pub mod export;
mod face_depths;
mod figures;
mod inputs;
pub mod live;
mod maker;
mod nearest;
mod of_cube;
mod of_depth;
mod of_photos;
mod of_site;
mod of_stack;
mod planes;
pub mod set;
mod shapes;
mod site;
mod site_origins;
pub mod site_view;
mod standing;
mod stereo;
#[cfg(test)]
mod tests;
mod texels;
pub mod view;
pub mod viewer;

use std::collections::BTreeMap;

pub use self::build::{
    BuildFrom, BuildRequest, BuiltLdi, DepthRequest, LdiState, build_ldis, build_of_depth_images,
    cached_file, ldi_state,
};
pub use self::maker::{BuildCamera, Maker};
pub use self::of_cube::{CubeRequest, build_cube};
pub use self::of_depth::{DepthImageOptions, depth_images};
pub use self::of_photos::{PhotosOptions, Reference, ldi_of_photos};
pub use self::of_site::SiteLdiOptions;
pub use self::of_stack::ldi_of_stack;
pub use self::set::{BuiltSet, ImageOfSet, SetRequest, build_set};
pub use self::site::LdiSite;
pub use self::stereo::COMFORTABLE;
use quadratura_ldi::LdiKind;

/// The options of a layered depth image of a stack.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StackLdiOptions {
    /// Whether points are moved to the relief that the photos tell; otherwise they lie on the model's faces.
    pub relief: bool,
    /// Whether fillings of hidden texels are in it.
    pub filled: bool,
    /// Whether what the photo shows where no face is, is in it, infinitely far away.
    pub surroundings: bool,
}

impl StackLdiOptions {
    /// Returns the options by their names on the command line.
    fn described(&self, from: LdiKind) -> BTreeMap<String, String> {
        let Self { relief, filled, surroundings } = *self;
        let background = if surroundings { "surroundings" } else { "none" };
        let words = [
            ("from", from.name().to_owned()),
            ("flat", (!relief).to_string()),
            ("unfilled", (!filled).to_string()),
            ("background", background.to_owned()),
        ];
        words.map(|(name, value)| (name.to_owned(), value)).into()
    }
}

impl Default for StackLdiOptions {
    fn default() -> Self {
        Self { relief: true, filled: true, surroundings: true }
    }
}
