//! The whole state of the window, without the window itself: no toolkit, no threads.
//!
//! `action` changes the state, `panel` shows it, `work` delivers results as closures on it. Tests use it like any other
//! value.

pub mod checks;
mod diagnostics;
pub mod dialogs;
pub mod editing;
pub mod facts;
pub mod first_steps;
pub mod flat;
pub mod flight;
pub mod guide;
pub mod inspect;
pub mod life;
pub mod lists;
pub mod masking;
pub mod model_suggestions;
pub mod next_steps;
pub mod notes;
pub mod numbers;
pub mod objects;
pub mod opening;
pub mod orthophoto;
pub mod palette;
pub mod panels;
pub mod panes;
pub mod pending;
pub mod progress;
pub mod publish;
pub mod quality;
pub mod request;
pub mod round_trip;
pub mod running;
pub mod save_image;
pub mod selection;
pub mod session;
pub mod settings;
pub mod site_frame;
pub mod space;
pub mod trees;
pub mod updating;

use self::checks::Checks;
use self::dialogs::Dialogs;
use self::flat::FlatViews;
use self::flight::Flights;
use self::life::Life;
use self::lists::ListsState;
use self::masking::Masking;
use self::model_suggestions::SuggestedModelState;
use self::notes::{Note, NoteLog, Weight};
use self::opening::Opening;
use self::panes::Panes;
use self::quality::QualityState;
use self::round_trip::RoundTrip;
use self::running::Running;
use self::selection::{Selection, SelectionState};
use self::session::Session;
use self::settings::Settings;
use self::space::SpaceView;
use self::trees::TreesState;
use self::updating::Updating;
use quadratura_base::scene::PhotoId;
use quadratura_layers::LayerIndex;

/// The state of the window.
#[derive(Default)]
pub struct State {
    /// The open project.
    pub session: Option<Session>,
    /// The running jobs.
    pub running: Running,
    /// The messages.
    pub notes: NoteLog,
    /// The settings, which are stored from run to run.
    pub settings: Settings,
    /// What is selected.
    pub selection: SelectionState,
    /// The lists of layers and objects.
    pub lists: ListsState,
    /// The 3D view.
    pub space: SpaceView,
    /// Bookmarks and the flight.
    pub flights: Flights,
    /// The views of the centre.
    pub panes: Panes,
    /// The flat views: the photo with its layers, and one image layer.
    pub flat: FlatViews,
    /// The dialogs that belong to no other part.
    pub dialogs: Dialogs,
    /// The dialogs for opening and creating projects.
    pub opening: Opening,
    /// The life cycle of the project, and unsaved changes found from an earlier run.
    pub life: Life,
    /// The round trip to image editors.
    pub round_trip: RoundTrip,
    /// Filling and exposures.
    pub quality: QualityState,
    /// The updates in the background.
    pub updating: Updating,
    /// Masks of photos.
    pub masking: Masking,
    /// The trees of the project.
    pub trees: TreesState,
    /// The results of checks.
    pub checks: Checks,
    /// What is suggested to complete the model.
    pub suggested_model: SuggestedModelState,
    /// The window's clock, and requests to it.
    pub window: WindowState,
}

/// The facts about the window that the state depends on, and requests to it.
#[derive(Debug, Clone, PartialEq)]
pub struct WindowState {
    /// The time of this frame by the window's clock, in seconds.
    pub now_s: f64,
    /// Screen pixels per point.
    pub density: f32,
    /// Whether the window is to close without any further question.
    pub closes: bool,
    /// Whether the layout is to be reset.
    pub resets: bool,
    /// The time until the next requested frame, in seconds.
    pub next_frame_s: Option<f64>,
    /// The text that is to be copied to the clipboard.
    pub copies: Option<String>,
}

impl Default for WindowState {
    fn default() -> Self {
        Self { now_s: 0.0, density: 1.0, closes: false, resets: false, next_frame_s: None, copies: None }
    }
}

impl WindowState {
    /// Requests a frame within this time, in seconds.
    pub fn wake_within(&mut self, seconds: f64) {
        self.next_frame_s = Some(self.next_frame_s.map_or(seconds, |known| known.min(seconds)));
    }
}

impl State {
    /// Adds a note.
    pub fn notify(&mut self, note: Note) {
        // A note with remedies opens the panel of messages, too.
        if note.weight == Weight::Problem || !note.remedies.is_empty() {
            self.settings.notes_shown = true;
        }
        self.notes.add(note);
    }

    /// Changes the selection. Image layers that are linked with the selected one are selected with it.
    pub fn select(&mut self, selection: Selection) {
        self.selection.main = selection;
        self.selection.more_layers = self.linked_layers(selection);
        self.selection.photo = selection.photo().or(self.selection.photo);
        self.flat.layer.follow(selection);
        self.keep_tree_name();
    }

    /// Returns the image layers that are linked with the selected one.
    fn linked_layers(&self, selection: Selection) -> Vec<(PhotoId, LayerIndex)> {
        let Selection::Layer { photo, layer } = selection else { return Vec::new() };
        let stack = self.session.as_ref().and_then(|session| session.stack_of(photo));
        let linked = stack.map(|stack| stack.linked_with(layer)).unwrap_or_default();
        linked.into_iter().map(|layer| (photo, layer)).collect()
    }

    /// Returns the photo that commands on a photo apply to.
    pub fn selected_photo(&self) -> Option<PhotoId> {
        self.selection
            .photo
            .filter(|photo| self.session.as_ref().is_some_and(|session| photo.index() < session.photos.len()))
    }

    /// Returns the name of the selected photo.
    pub fn selected_photo_name(&self) -> Option<String> {
        let session = self.session.as_ref()?;
        Some(session.opened.site.photo(self.selected_photo()?).name.clone())
    }

    /// Returns whether a dialog is open, or will be drawn from the next frame on.
    pub fn has_dialog(&self) -> bool {
        self.dialogs.take_keys()
            || self.is_asking()
            || self.life.asks_about_writing()
            || self.opening.is_asking()
            || self.flights.is_asking()
            || self.round_trip.is_asking()
    }

    /// Returns whether a question is open, which keys and dropped files belong to.
    pub fn is_asking(&self) -> bool {
        self.life.is_asking() || self.lists.is_asking()
    }
}
