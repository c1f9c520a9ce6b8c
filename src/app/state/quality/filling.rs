//! The filling of occluded areas: where it is most visible, its provenance, and the options.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::lookup::ComputedValue;
use quadratura_base::scene::PhotoId;
use quadratura_document::{Bookmark, CameraPath, Project};
use quadratura_layers::fill::FillOptions;
use quadratura_stacks::fill::both_ways::BothWays;
use quadratura_stacks::fill::propagation::{PaintedPhoto, PropagationToPhoto};
use quadratura_stacks::fill::shares::LayerShares;
use quadratura_stacks::fill::viewpoints::{RankedViewpoint, Viewpoints};
use quadratura_stacks::fill::worst::HiddenLayer;

/// The cached facts about fillings.
#[derive(Default)]
pub struct FillSession {
    /// The viewpoints chosen by the user; otherwise the default of the project is used.
    pub viewpoints: Option<Viewpoints>,
    /// Layers ranked by how much of their occluded areas is visible.
    pub worst: ComputedValue<Worst>,
    /// The views that the ranking was requested for.
    pub asked: Option<RankingInputs>,
    /// The provenance of hidden texels of a photo's layers.
    pub shares: BTreeMap<PhotoId, ComputedValue<Vec<LayerShares>>>,
    /// The photos that have paint.
    pub painters: ComputedValue<Vec<PaintedPhoto>>,
    /// The paint that would be projected to other photos, with the options that it was computed for.
    pub offered: ComputedValue<(FillOptions, Vec<PropagationToPhoto>)>,
    /// A photo without and with paint of others, for the question whether paint is seen from everywhere; none where no
    /// photo would change.
    pub both_ways: ComputedValue<Option<Arc<BothWays>>>,
    /// Whether the user left that question open.
    pub chooses_later: bool,
    /// The photos whose fillings are out of date.
    pub stale: ComputedValue<Vec<PhotoId>>,
    /// The names of excluded objects, while they are being typed.
    pub without: Option<String>,
}

/// Layers ranked by how much of their occluded areas is visible, with the views that see it.
pub struct Worst {
    /// The layers, the most visible area first.
    pub layers: Vec<HiddenLayer>,
    /// The views, indexed by [`HiddenLayer::view`].
    pub views: Arc<Vec<RankedViewpoint>>,
}

/// The inputs of the views.
#[derive(Debug, Clone, PartialEq)]
pub struct RankingInputs {
    viewpoints: Viewpoints,
    kept: Vec<Bookmark>,
    flight: Option<CameraPath>,
}

impl RankingInputs {
    /// Returns those of a project.
    pub fn new(viewpoints: Viewpoints, project: &Project) -> Self {
        Self { viewpoints, kept: project.views.clone(), flight: project.flight.clone() }
    }

    /// Returns whether both have the same views: the photos' cameras depend on nothing else.
    pub fn has_views_of(&self, other: &Self) -> bool {
        self.viewpoints == other.viewpoints && (self.viewpoints == Viewpoints::Photos || self == other)
    }
}

impl FillSession {
    /// Returns the viewpoints from which visibility is judged in a project.
    pub fn seen_from(&self, project: &Project) -> Viewpoints {
        self.viewpoints.unwrap_or_else(|| Viewpoints::usual(project))
    }

    /// Returns the confidence of the filling of each layer of a photo, 0 to 1, where it is known.
    pub fn layer_trust(&self, photo: PhotoId) -> Vec<Option<f64>> {
        let shares = self.shares.get(&photo).and_then(|shares| shares.found());
        let trust = |shares: &LayerShares| (shares.filled() > 0).then_some(shares.confidence);
        shares.map(|shares| shares.iter().map(trust).collect()).unwrap_or_default()
    }

    /// Drops facts that depend on fillings or paint.
    pub fn forget_fillings(&mut self) {
        self.shares.clear();
        (self.painters, self.offered, self.both_ways, self.stale) = Default::default();
    }

    /// Drops facts about fillings that were made again, from the same layers and paint. While further ones follow, what
    /// takes long to find out is kept (`is_all` is false).
    pub fn forget_made(&mut self, is_all: bool) {
        self.shares.clear();
        self.stale = ComputedValue::default();
        if is_all {
            (self.worst, self.asked) = Default::default();
        }
    }

    /// Drops facts that depend on stacks; the user's choices are kept.
    pub fn forget_stacks(&mut self) {
        let (viewpoints, chooses_later) = (self.viewpoints, self.chooses_later);
        *self = Self { viewpoints, chooses_later, without: self.without.take(), ..Self::default() };
    }
}
