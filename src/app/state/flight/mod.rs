//! Bookmarks, the flight between keyframes, and the dialog for pictures and videos of them.

pub mod export;
mod flying;
mod views;

use self::export::Export;
use quadratura_document::CameraPath;
use quadratura_document::camera_path::KeyframeIndex;
use quadratura_view::flight::Flight;

/// The state of the panel of flights.
#[derive(Default)]
pub struct Flights {
    /// Whether the panel is shown.
    pub shown: bool,
    /// The current time in the flight, in seconds.
    pub time_s: f64,
    /// The start of playback by the window's clock and in the flight, in seconds; none while paused.
    playing: Option<(f64, f64)>,
    /// The index of the selected keyframe.
    pub keyframe: Option<KeyframeIndex>,
    /// The flight of a camera path, cached.
    made: Option<(CameraPath, Option<Flight>)>,
    /// The open export dialog.
    pub export: Option<Export>,
}

impl Flights {
    /// Returns whether an export dialog is open.
    pub fn is_asking(&self) -> bool {
        self.export.is_some()
    }

    /// Pauses the flight.
    pub fn pause(&mut self) {
        self.playing = None;
    }

    /// Resets the state that belongs to a project.
    pub fn forget(&mut self) {
        *self = Self { shown: self.shown, ..Self::default() };
    }
}
