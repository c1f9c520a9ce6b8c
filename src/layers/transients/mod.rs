//! Detection of transient objects, which one photo alone shows and the model lacks: people, cars, cables.
//!
//! At a surface point the photos agree, except for one that shows an object in front of the surface. So each
//! photo is compared with the others, pixel by pixel and at a reduced size at which models are accurate to a
//! pixel or two: [`disagreement()`] measures how far its colour is from all colours that the others show
//! around the same point. Where the others agree among themselves and the photo differs, the region is
//! suggested as a mask ([`regions`]). A window that mirrors another sky in every photo is not suggested,
//! because the others disagree there, too. The user reviews all suggestions.

pub mod disagreement;
pub mod reduced_photo;
pub mod regions;

pub use disagreement::{ReducedPhotos, disagreement};
pub use reduced_photo::ReducedPhoto;
pub use regions::{TransientRegion, transient_regions};

/// Options of the detection of transient objects. Sizes are in pixels of the reduced photos.
#[derive(Debug, Clone, PartialEq)]
pub struct TransientOptions {
    /// The longer side of the reduced photos: models are wrong by a few pixels of a photo three thousand
    /// pixels wide, and one reduced pixel is three of these.
    pub longest_side: u32,
    /// The radius within which colours of the other photos are accepted: it covers model errors that remain
    /// after relief.
    pub reach: i32,
    /// The disagreement that a suggested region reaches somewhere, as a natural logarithm; 0.45 corresponds
    /// to a third of the light.
    pub strong: f32,
    /// The disagreement that all pixels of a suggested region reach.
    pub weak: f32,
    /// The deviation among the other photos that halves the disagreement.
    pub dispute: f32,
    /// The least number of pixels of a suggested region.
    pub least_pixels: u64,
    /// The least mean disagreement of a suggested region; light that changes on a surface rarely reaches it.
    pub least_score: f32,
    /// The least weight of a suggested region ([`TransientRegion::weight`]).
    pub least_weight: f32,
    /// The largest share of the photo that a suggested region may take; larger ones come from errors of the
    /// model.
    pub most_share: f64,
    /// The width by which the mask is extended beyond the region, because colours at its rim are mixed.
    pub margin: i32,
}

impl Default for TransientOptions {
    fn default() -> Self {
        Self {
            longest_side: 1024,
            reach: 2,
            strong: 0.45,
            weak: 0.2,
            dispute: 0.3,
            least_pixels: 60,
            least_score: 0.5,
            least_weight: 12.0,
            most_share: 0.1,
            margin: 2,
        }
    }
}
