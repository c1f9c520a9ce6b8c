//! What the pages of the inspector show.

use crate::command::Commands;
use crate::state::State;
use crate::state::flat::FlatViews;
use crate::state::masking::Masking;
use crate::state::quality::filling::FillSession;
use crate::state::selection::SelectionState;
use crate::state::session::Session;
use crate::state::trees::TreesState;
use quadratura_base::scene::PhotoId;

/// What the inspector shows.
pub struct InspectorView<'a> {
    /// The commands that the panel offers.
    pub commands: Commands<'a>,
    /// The open project.
    pub session: Option<&'a Session>,
    /// What is selected.
    pub selection: &'a SelectionState,
    /// The facts about fillings.
    pub fill: &'a FillSession,
    /// Masks of photos.
    pub masking: &'a Masking,
    /// The flat views.
    pub flat: &'a FlatViews,
    /// The trees of the project.
    pub trees: &'a TreesState,
    /// The photo that commands on a photo apply to.
    pub photo: Option<PhotoId>,
}

impl<'a> InspectorView<'a> {
    /// Borrows what the panel shows.
    pub fn new(state: &'a State) -> Self {
        Self {
            commands: Commands::of(state),
            session: state.session.as_ref(),
            selection: &state.selection,
            fill: &state.quality.fill,
            masking: &state.masking,
            flat: &state.flat,
            trees: &state.trees,
            photo: state.selected_photo(),
        }
    }
}
