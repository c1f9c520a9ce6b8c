//! Everything that the window shows and that can be decided in it, without the window: no toolkit, no threads.
//!
//! `action` changes it, `panel` shows it, `work` brings results as closures on it. It is made and asked in tests as any
//! other value.

pub mod ask;
pub mod life;
pub mod notes;
pub mod panes;
pub mod running;
pub mod selection;
pub mod session;
pub mod settings;

use self::life::Life;
use self::notes::{Note, Notes, Weight};
use self::panes::Panes;
use self::running::Running;
use self::selection::Selection;
use self::session::Session;
use self::settings::Settings;
use super::check::Checks;
use super::flat::Flat;
use super::flight::Flights;
use super::inspect::Inspect;
use super::lists::Lists;
use super::masking::Masking;
use super::opening::Opening;
use super::panel::palette::Palette;
use super::quality::Quality;
use super::space::Space;
use super::trip::Trip;

/// The state of the window.
#[derive(Default)]
pub struct State {
    /// The project that is open.
    pub session: Option<Session>,
    /// The jobs that run.
    pub running: Running,
    /// What was said.
    pub notes: Notes,
    /// Kept from run to run.
    pub settings: Settings,
    /// What is selected.
    pub selection: Selection,
    /// The photo that was selected last: the one that commands on a photo mean.
    pub photo: Option<usize>,
    /// Image layers that are selected beside the one of `selection`: photo and place in its stack.
    pub more_layers: Vec<(usize, usize)>,
    /// The lists of layers and objects.
    pub lists: Lists,
    /// What was found out about the selection.
    pub inspect: Inspect,
    /// The 3D view.
    pub space: Space,
    /// The device that draws the 3D view; none while no renderer runs.
    pub device: Option<String>,
    /// Kept views and the flight.
    pub flights: Flights,
    /// The views of the centre.
    pub panes: Panes,
    /// The photo with its layers, and one image layer.
    pub flat: Flat,
    /// The command palette.
    pub palette: Palette,
    /// What keys and mouse do is shown.
    pub help_shown: bool,
    /// The settings are shown.
    pub settings_shown: bool,
    /// The options of layers are shown.
    pub layer_options_shown: bool,
    /// Dialogs around opening and making projects.
    pub opening: Opening,
    /// How the project may end, and what was found of the last time.
    pub life: Life,
    /// Out to image editors, and home.
    pub trip: Trip,
    /// Fillings and colour.
    pub quality: Quality,
    /// Masks of photos.
    pub masking: Masking,
    /// What is known from comparing cameras, photos and model.
    pub checks: Checks,
    /// The window.
    pub window: Window,
}

/// What is known of the window, and what is wanted of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// Seconds of its clock, in this frame.
    pub now_s: f64,
    /// Pixels of the screen per point.
    pub density: f32,
    /// The window is to close; nothing is asked any more.
    pub closes: bool,
    /// Panels are to be laid out as at first.
    pub resets: bool,
    /// A frame is wanted within so many seconds.
    pub next_frame_s: Option<f64>,
}

impl Default for Window {
    fn default() -> Self {
        Self { now_s: 0.0, density: 1.0, closes: false, resets: false, next_frame_s: None }
    }
}

impl Window {
    /// A frame is wanted within so many seconds.
    pub fn wake_within(&mut self, seconds: f64) {
        self.next_frame_s = Some(self.next_frame_s.map_or(seconds, |known| known.min(seconds)));
    }
}

impl State {
    /// Says something.
    pub fn tell(&mut self, note: Note) {
        // What helps is to be seen, too.
        if note.weight == Weight::Problem || !note.remedies.is_empty() {
            self.settings.notes_shown = true;
        }
        self.notes.add(note);
    }

    /// Changes what is selected.
    pub fn select(&mut self, selection: Selection) {
        self.selection = selection;
        self.more_layers.clear();
        self.photo = selection.photo().or(self.photo);
        self.flat.layer.follow(selection);
    }

    /// The photo that commands on a photo mean.
    pub fn selected_photo(&self) -> Option<usize> {
        self.photo.filter(|photo| self.session.as_ref().is_some_and(|session| *photo < session.photos.len()))
    }

    /// Its name.
    pub fn selected_photo_name(&self) -> Option<String> {
        let session = self.session.as_ref()?;
        Some(session.opened.site.photos[self.selected_photo()?].name.clone())
    }

    /// A dialog is open, or is drawn from the next frame on.
    pub fn has_dialog(&self) -> bool {
        self.palette.is_open()
            || self.settings_shown
            || self.asks()
            || self.life.asks_about_writing()
            || self.opening.is_asking()
            || self.flights.asks()
            || self.trip.asks()
    }

    /// A question waits for an answer: keys and files are for it.
    pub fn asks(&self) -> bool {
        self.life.asks() || self.lists.asks()
    }
}
