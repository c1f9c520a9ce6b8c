//! What the 3D view shows.

use crate::command::Commands;
use crate::state::State;
use crate::state::model_suggestions::ModelSuggestions;
use crate::state::panes::KeyOwner;
use crate::state::panes::Pane;
use crate::state::quality::colour::ColourSession;
use crate::state::running::Running;
use crate::state::selection::SelectionState;
use crate::state::settings::Navigation;
use crate::state::space::scene::ShownScene;
use quadratura_base::scene::PhotoId;

/// What the 3D view shows.
pub struct SpacePaneView<'a> {
    /// The commands that the view offers.
    pub commands: Commands<'a>,
    /// The scene.
    pub scene: ShownScene<'a>,
    /// What is selected.
    pub selection: &'a SelectionState,
    /// The photo that commands on a photo apply to.
    pub photo: Option<PhotoId>,
    /// The running jobs.
    pub running: &'a Running,
    /// The exposures of photos.
    pub colour: &'a ColourSession,
    /// What is suggested to complete the model, while it is shown.
    pub suggested: Option<&'a ModelSuggestions>,
    /// What the mouse does.
    pub navigation: Navigation,
    /// Whether hints are wanted.
    pub hints: bool,
    /// Whether the project has paint.
    pub is_painted: bool,
    /// Whether keys belong to the view.
    pub has_keys: bool,
    /// The time of this frame by the window's clock, in seconds.
    pub now_s: f64,
}

impl<'a> SpacePaneView<'a> {
    /// Borrows what the view shows; none without a project.
    pub fn new(state: &'a State) -> Option<Self> {
        Some(Self {
            commands: Commands::of(state),
            scene: state.scene()?,
            selection: &state.selection,
            photo: state.selected_photo(),
            running: &state.running,
            colour: &state.quality.colour,
            suggested: state.suggested_model.visible(),
            navigation: state.settings.navigation,
            hints: state.settings.hints,
            is_painted: !state.round_trip.painted.is_empty(),
            has_keys: state.panes.key_owner() == KeyOwner::View(Pane::Space),
            now_s: state.window.now_s,
        })
    }
}
