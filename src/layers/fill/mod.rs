//! Filling what a photo did not show, in order of trust.
//!
//! Every hidden texel of an image layer lies on a surface whose place is known. It gets its colour
//!
//! 1. from other photos ([`givers`]): from paint on the same surface ([`painted`]), else from those whose own
//!    pixel there shows the same surface, well inside of what they show of it;
//! 2. by example ([`exemplar`]): what no photo shows of a surface is made of what some photo shows of it,
//!    in its own plane ([`plate`]), once for all photos;
//! 3. by diffusion ([`push_pull`]) where there is too little to take examples from, if need be from the few
//!    pixels that the photo itself has of the surface ([`remnant`]).
//!
//! The seam to what the photo shows is closed by a smooth factor ([`seam`]); pixels of the photo never
//! change. [`fill_photo`] is the recipe. What filling needs of the photos is told by [`Donors`].
//!
//! Where it is wished, paint of one photo also takes the place of what others show of the surface (`spread`).

mod asker;
pub mod cells;
pub mod donor;
pub mod exemplar;
pub mod givers;
pub mod options;
pub mod painted;
mod photo;
pub mod plate;
pub mod push_pull;
pub mod region;
pub mod remnant;
pub mod seam;
mod spread;
pub mod surfaces;

pub use donor::{Donor, Donors};
pub use options::{FillOptions, Invent};
pub use painted::PaintedSurface;
pub use photo::{Filled, FilledRegion, Ground, Texel, fill_photo};
pub use plate::Plates;
pub use region::{HiddenSpan, Region, Regions};
pub use spread::{Offer, Spread, spread_paint};
pub use surfaces::{SurfaceId, Surfaces};

use crate::projection::PhotoId;

/// Where the colour of a texel comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Origin {
    /// Made of what photos show elsewhere on the surface.
    Exemplar,
    /// A smooth mean of what is around it.
    Diffused,
    /// This photo shows the place.
    Photo(PhotoId),
    /// Somebody painted the place in this photo.
    Painted(PhotoId),
}

/// What another photo gives is trusted so far at most: it was seen under another angle.
pub const MOST_CONFIDENCE: f32 = 0.5;

/// What was invented is trusted so far: any photo that shows the place comes first.
pub const INVENTED_CONFIDENCE: f32 = 0.1;

/// The same where there was nothing to take examples from.
pub const DIFFUSED_CONFIDENCE: f32 = 0.04;
