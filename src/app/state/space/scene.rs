//! The scene of the 3D view: what is shown in it, and what can be pointed at.

use super::SpaceView;
use crate::state::State;
use crate::state::flat::layer_views::LayerViews;
use crate::state::session::Session;
use crate::state::trees::TreesState;

/// What the 3D view shows. Positions in the view are answered by what is drawn there.
#[derive(Clone, Copy)]
pub struct ShownScene<'a> {
    /// The project.
    pub session: &'a Session,
    /// The view with its newest picture.
    pub space: &'a SpaceView,
    /// The trees.
    pub trees: &'a TreesState,
    /// Which image layers are shown.
    pub layer_views: &'a LayerViews,
}

impl State {
    /// Returns what the 3D view shows; none without a project.
    pub fn scene(&self) -> Option<ShownScene<'_>> {
        let Self { session, space, trees, flat, .. } = self;
        Some(ShownScene { session: session.as_ref()?, space, trees, layer_views: &flat.layer_views })
    }
}
