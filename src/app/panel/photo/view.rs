//! What the photo view shows.

use crate::command::Commands;
use crate::state::State;
use crate::state::flat::FlatViews;
use crate::state::masking::Masking;
use crate::state::model_suggestions::ModelSuggestions;
use crate::state::running::Running;
use crate::state::selection::SelectionState;
use crate::state::session::Session;
use quadratura_base::scene::PhotoId;
use quadratura_document::Stack;

/// What the photo view shows.
pub struct PhotoView<'a> {
    /// The commands that the panel offers.
    pub commands: Commands<'a>,
    /// The open project.
    pub session: Option<&'a Session>,
    /// The photo that commands on a photo apply to.
    pub photo: Option<PhotoId>,
    /// What is selected.
    pub selection: &'a SelectionState,
    /// The flat views.
    pub flat: &'a FlatViews,
    /// Masks of photos.
    pub masking: &'a Masking,
    /// The running jobs.
    pub running: &'a Running,
    /// The factors of the photos' linear light that match their exposures, in the order of the site.
    pub factors: &'a [[f64; 3]],
    /// What is suggested to complete the model, while it is shown.
    pub suggested: Option<&'a ModelSuggestions>,
    /// Whether layers are updated without a click.
    pub keeps_up: bool,
}

impl<'a> PhotoView<'a> {
    /// Borrows what the panel shows.
    pub fn new(state: &'a State) -> Self {
        Self {
            commands: Commands::of(state),
            session: state.session.as_ref(),
            photo: state.selected_photo(),
            selection: &state.selection,
            flat: &state.flat,
            masking: &state.masking,
            running: &state.running,
            factors: &state.quality.colour.factors,
            suggested: state.suggested_model.visible(),
            keeps_up: state.settings.keep_up_to_date,
        }
    }

    /// Returns the stack of the photo.
    pub fn stack(&self) -> Option<&'a Stack> {
        self.session?.stack_of(self.photo?).map(|stack| &**stack)
    }

    /// Returns the size of the photo, in pixels.
    pub fn photo_size(&self) -> Option<[u32; 2]> {
        let camera = &self.session?.opened.site.photo(self.photo?).camera;
        Some([camera.width, camera.height])
    }
}
