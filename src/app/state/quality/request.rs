//! Requests about fillings, paint in other photos, and exposures.

use quadratura_base::scene::PhotoId;
use quadratura_layers::fill::FillOptions;
use quadratura_stacks::fill::seen::SeenEdit;
use quadratura_stacks::fill::viewpoints::Viewpoints;
use quadratura_stacks::surroundings::SiteSurroundings;
use quadratura_views::colour::ColourEdit;

/// Requests about filling and exposures.
pub enum QualityRequest {
    /// Sets the fill options.
    Fill(FillOptions),
    /// Keeps the names of excluded objects while they are being typed; none when that ends.
    TypeWithout(Option<String>),
    /// Sets the viewpoints from which visibility is judged.
    SeeFrom(Viewpoints),
    /// Ranks layers by the visibility of their occluded areas, unless that is known.
    WantWorst,
    /// Computes the provenance of a photo's layers, unless it is known.
    WantShares(PhotoId),
    /// Finds the photos that have paint, unless they are known.
    WantPainters,
    /// Estimates the exposures, unless they are known or could not be estimated.
    WantEstimate,
    /// Drops an estimate that failed.
    EstimateAgain,
    /// Edits the photos' exposures.
    Colour {
        /// The edits, in order.
        edits: Vec<ColourEdit>,
        /// Whether the gesture continues.
        goes_on: bool,
    },
    /// Computes which paint would be projected to which photos.
    LookAtPropagation,
    /// Edits where paint is seen.
    See(SeenEdit),
    /// Makes the pictures of the question whether paint is seen from everywhere, unless they are made.
    WantBothWays,
    /// Leaves that question open until the project is opened again.
    ChooseLater,
    /// Finds the photos whose fillings are out of date, unless that is known.
    WantStale,
    /// Projects paint to other photos.
    Propagate,
    /// Removes paint from other photos.
    TakePropagatedOff,
    /// Applies new gains to the 3D view.
    ShowGains,
    /// Applies surroundings, made from the present gains and paint, to the 3D view.
    ShowSurroundings(Box<SiteSurroundings>),
}
