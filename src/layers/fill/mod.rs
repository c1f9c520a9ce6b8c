//! Filling of the texels that a photo does not show, from the most to the least reliable source.
//!
//! Every occluded texel of an image layer lies on a surface whose position is known. Its colour comes
//!
//! 1. from other photos ([`ranked_donors`]): from paint on the same surface ([`painted`]), else from photos whose
//!    own pixel at that point shows the same surface and lies well inside the area that they show of it;
//! 2. by example ([`exemplar`]): the parts of a surface that no photo shows are synthesised from the parts
//!    that some photo shows, in the plane of the surface ([`plate`]), once for all photos;
//! 3. by diffusion ([`push_pull`]) where the known part is too small to take examples from, in the last
//!    resort from the few pixels that the photo itself has of the surface ([`remnant`]).
//!
//! Pixels close behind the outline of something nearer are no examples, and those of backdrops are not used at all
//! (`silhouettes`): there photos show what the model lacks of the nearer one.
//!
//! A smooth factor on the filling closes the seam to the pixels that the photo shows ([`seam`]); pixels of
//! the photo never change. [`fill_photo`] carries out the steps for one photo. [`Donors`] is the interface
//! through which the photos are read.
//!
//! On request, paint of one photo also replaces the pixels that other photos show of the surface (`propagated`).

mod behind;
pub mod cells;
pub mod donor;
pub mod exemplar;
pub mod near;
pub mod options;
pub mod painted;
mod photo;
pub mod plate;
mod propagated;
pub mod propagation;
pub mod push_pull;
mod queries;
pub mod ranked_donors;
pub mod region;
pub mod remnant;
pub mod seam;
pub mod see_through;
mod silhouettes;
pub mod surfaces;
pub mod surroundings;

pub use behind::{PredictedColour, predicted_colours};
pub use donor::{Donor, DonorContent, Donors};
pub use options::{FillOptions, Invent};
pub use painted::PaintedSurface;
pub use photo::{
    FillContext, FilledRegion, FilledTexel, KeptTexels, MOST_DONORS, PhotoFilling, fill_photo,
    paint_chooses_donors, photos_asked,
};
pub use plate::RectifiedTextures;
pub use propagated::{PropagatedPaint, PropagationStatistics, propagate_paint};
pub use propagation::{OnlyHere, PaintPlace, Propagation};
use quadratura_base::scene::PhotoId;
pub use region::{HiddenSpan, Region, Regions};
pub use surfaces::{FillSurfaceId, FillSurfaces};

/// The source of a filled texel's colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FillOrigin {
    /// Synthesised by example from other parts of the surface.
    Exemplar,
    /// A smooth mean of the surrounding colours.
    Diffused,
    /// Taken from this photo, which shows the point.
    Photo(PhotoId),
    /// Taken from paint on this photo.
    Painted(PhotoId),
}

/// The highest confidence of a colour from another photo, in 0..1: the photo saw the surface from another
/// direction.
pub const MOST_CONFIDENCE: f32 = 0.5;

/// The confidence of a texel synthesised by example, in 0..1: lower than that of any photo that shows the
/// point.
pub const INVENTED_CONFIDENCE: f32 = 0.1;

/// The confidence of a texel filled by diffusion, in 0..1.
pub const DIFFUSED_CONFIDENCE: f32 = 0.04;
