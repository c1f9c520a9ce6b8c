//! What stands in one photo alone: people, cars, cables, and whatever else the model does not have.
//!
//! At a surface point the photos that show it agree, but for one who shows something that stands before the surface.
//! So each photo is asked, pixel by pixel and at a size at which models are right to a pixel or two, how far its colour
//! is from all that the others show around the same place ([`disagreement()`]); where they agree among themselves and
//! it differs, a region of that is a suspect ([`regions`]). A window that mirrors another sky in every photo is none,
//! because the others do not agree either. Suspects are suggestions: somebody looks at them.

pub mod disagreement;
pub mod look;
pub mod regions;

pub use disagreement::{Witnesses, disagreement};
pub use look::Look;
pub use regions::{Suspect, suspects};

/// How strangers are looked for. Sizes are in pixels of the reduced photos.
#[derive(Debug, Clone, PartialEq)]
pub struct StrangerOptions {
    /// Photos are reduced to this many pixels along their longer side: models are wrong by a few pixels of photos of
    /// three thousand, and one of these is three of them.
    pub longest_side: u32,
    /// The others are asked so far around a place: what relief leaves of the model's errors.
    pub reach: i32,
    /// A suspect differs by this somewhere: a natural logarithm, and a third of light.
    pub strong: f32,
    /// And by this everywhere.
    pub weak: f32,
    /// Witnesses that are this far apart among themselves halve what they say.
    pub quarrel: f32,
    /// A suspect of fewer pixels is none.
    pub least_pixels: u64,
    /// On average a suspect differs by this at least: where light plays on a surface, little differs much.
    pub least_score: f32,
    /// A suspect has this weight at least ([`Suspect::weight`]).
    pub least_weight: f32,
    /// A suspect of a larger share of the photo is no thing before it, but a model that is wrong.
    pub most_share: f64,
    /// What is masked reaches so far beyond what was found: rims are mixed of both.
    pub margin: i32,
}

impl Default for StrangerOptions {
    fn default() -> Self {
        Self {
            longest_side: 1024,
            reach: 2,
            strong: 0.45,
            weak: 0.2,
            quarrel: 0.3,
            least_pixels: 60,
            least_score: 0.5,
            least_weight: 12.0,
            most_share: 0.1,
            margin: 2,
        }
    }
}
