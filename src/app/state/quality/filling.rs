//! The filling of occluded areas: where it is most visible, its provenance, and the options.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::lookup::ComputedValue;
use crate::app::state::State;
use crate::app::state::panes::Pane;
use crate::document::{Bookmark, CameraPath, Project};
use crate::layers::fill::FillOptions;
use crate::projection::navigation::Viewpoint;
use crate::recipe::fill::lookouts::{LookoutView, Viewpoints};
use crate::recipe::fill::propagation::{PaintedPhoto, PropagationToPhoto};
use crate::recipe::fill::shares::LayerShares;
use crate::recipe::fill::worst::HiddenLayer;

/// The cached facts about fillings.
#[derive(Default)]
pub struct FillSession {
    /// The viewpoints chosen by the user; otherwise the default of the project is used.
    pub lookouts: Option<Viewpoints>,
    /// Layers ranked by how much of their occluded areas is visible.
    pub worst: ComputedValue<Worst>,
    /// The views that the ranking was requested for.
    pub asked: Option<LookoutInputs>,
    /// The provenance of hidden texels of a photo's layers, by index of the photo.
    pub shares: BTreeMap<usize, ComputedValue<Vec<LayerShares>>>,
    /// The photos that have paint.
    pub painters: ComputedValue<Vec<PaintedPhoto>>,
    /// The paint that would be projected to other photos, with the options that it was computed for.
    pub offered: ComputedValue<(FillOptions, Vec<PropagationToPhoto>)>,
    /// The names of excluded objects, while they are being typed.
    pub without: Option<String>,
}

/// Layers ranked by how much of their occluded areas is visible, with the views that see it.
pub struct Worst {
    /// The layers, the most visible area first.
    pub layers: Vec<HiddenLayer>,
    /// The views, indexed by [`HiddenLayer::view`].
    pub views: Arc<Vec<LookoutView>>,
}

/// The inputs of the views.
#[derive(Debug, Clone, PartialEq)]
pub struct LookoutInputs {
    lookouts: Viewpoints,
    kept: Vec<Bookmark>,
    flight: Option<CameraPath>,
}

impl LookoutInputs {
    /// Returns those of a project.
    pub fn new(lookouts: Viewpoints, project: &Project) -> Self {
        Self { lookouts, kept: project.views.clone(), flight: project.flight.clone() }
    }

    /// Returns whether both have the same views: the photos' cameras depend on nothing else.
    pub fn has_views_of(&self, other: &Self) -> bool {
        self.lookouts == other.lookouts && (self.lookouts == Viewpoints::Photos || self == other)
    }
}

impl FillSession {
    /// Drops facts that depend on fillings or paint.
    pub fn forget_fillings(&mut self) {
        self.shares.clear();
        (self.painters, self.offered) = Default::default();
    }

    /// Drops facts that depend on stacks; the user's choices are kept.
    pub fn forget_stacks(&mut self) {
        *self = Self { lookouts: self.lookouts, without: self.without.take(), ..Self::default() };
    }
}

impl State {
    /// Returns the viewpoints from which visibility is judged.
    pub fn lookouts(&self) -> Viewpoints {
        let usual =
            self.session.as_ref().map_or(Viewpoints::Photos, |s| Viewpoints::usual(&s.opened.project));
        self.quality.fill.lookouts.unwrap_or(usual)
    }

    /// Flies to the viewpoint of a view; the selection is kept.
    pub fn look_from(&mut self, view: &LookoutView) {
        let Some(session) = &self.session else { return };
        let ahead = view.pose.rotation.transpose() * glam::DVec3::Z;
        let eye = view.pose.center_in_world();
        let near =
            session.solid.nearest(eye, ahead).map_or(session.scene_frame.center, |hit| eye + ahead * hit.t);
        let there = Viewpoint::of_camera(&view.camera, &view.pose, near);
        self.panes.show(Pane::Space);
        self.fly_to_viewpoint(there);
    }

    /// Returns whether paint of some photo is projected to another one, or a decision asks for it.
    pub fn has_propagated(&self) -> bool {
        self.session.as_ref().is_some_and(|session| {
            let fills = session.photos.iter().filter_map(|photo| photo.stack.as_ref()?.fill.as_ref());
            let laid = fills.flat_map(|fill| &fill.propagated).any(|paint| paint.texels > 0);
            laid || !session.opened.project.fill.propagate.is_empty()
        })
    }

    /// Sets the fill options, which apply to the next filling.
    pub fn edit_fill(&mut self, options: FillOptions) {
        let Some(session) = &self.session else { return };
        let before = session.history.present();
        let step = match before.fill.propagate == options.propagate {
            true => "options of filling",
            false => "which paint is laid over other photos",
        };
        let project = Project { fill: options, ..Project::clone(before) };
        self.edit(step, project, None);
    }
}
