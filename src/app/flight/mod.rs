//! Views that are kept, the flight between them, and the pictures and films that come of them.

pub mod export;
pub mod timeline;

pub use self::export::Export;
pub use self::timeline::timeline_ui;

use crate::app::state::State;
use crate::app::state::ask::{Ask, DecideAsk};
use crate::document::{Bookmark, CameraPath, Project};
use crate::projection::flight::{Flight, FrameLens};
use crate::projection::navigation::Viewpoint;

/// A new keyframe at the end comes so long after the one before.
const LEG_S: f64 = 2.0;
/// Films have this size until another one is chosen.
const USUAL_SIZE: [u32; 2] = [1920, 1080];

/// The panel of flights.
#[derive(Default)]
pub struct Flights {
    /// It is shown.
    pub shown: bool,
    /// Where in the flight one is.
    time_s: f64,
    /// It plays: when it began by the window's clock, and at which time.
    playing: Option<(f64, f64)>,
    /// The keyframe that is selected.
    keyframe: Option<usize>,
    /// The flight of a path, made once.
    made: Option<(CameraPath, Option<Flight>)>,
    /// A picture or film that is about to be made.
    export: Option<Export>,
}

impl Flights {
    /// How a picture or film is to be is being asked.
    pub fn asks(&self) -> bool {
        self.export.is_some()
    }

    /// Forgets what belonged to a project.
    pub fn forget(&mut self) {
        *self = Self { shown: self.shown, ..Self::default() };
    }
}

impl State {
    pub fn project(&self) -> Option<Project> {
        Some(Project::clone(self.session.as_ref()?.history.present()))
    }

    /// Keeps the view as it is, to come back to it.
    pub fn keep_view(&mut self) {
        let Some(mut project) = self.project() else { return };
        let name = (1..).map(|number| format!("View {number}"));
        let mut free = name.filter(|name| project.views.iter().all(|view| view.name != *name));
        let Some(name) = free.next() else { return };
        project.views.push(Bookmark::of(name.clone(), &self.space.viewpoint));
        self.flights.shown = true;
        self.edit(format!("keeping of {name}"), project, None);
    }

    /// Makes the view a keyframe: at the time where one is, or after the last one when one is at the end.
    pub fn add_keyframe(&mut self) {
        let Some(mut project) = self.project() else { return };
        let mut path = project.flight.take().unwrap_or_else(|| CameraPath::empty(USUAL_SIZE));
        let at_end = !path.keyframes.is_empty() && self.flights.time_s >= path.end_s();
        let time_s = if at_end { path.end_s() + LEG_S } else { self.flights.time_s };
        path.set(time_s, &self.space.viewpoint);
        self.flights.keyframe = path.keyframes.iter().position(|frame| frame.t == time_s);
        self.flights.time_s = time_s;
        self.flights.shown = true;
        project.flight = Some(path);
        self.edit("keyframe", project, None);
    }

    /// Takes the selected keyframe out of the flight.
    pub fn remove_keyframe(&mut self) {
        let (Some(mut project), Some(place)) = (self.project(), self.flights.keyframe.take()) else { return };
        if let Some(path) = &mut project.flight {
            path.remove(place);
        }
        self.edit("removal of a keyframe", project, None);
    }

    /// A keyframe is selected.
    pub fn has_keyframe(&self) -> bool {
        self.flights.keyframe.is_some()
    }

    /// The project has a flight of two keyframes at least.
    pub fn can_fly(&self) -> bool {
        let path = self.session.as_ref().and_then(|session| session.opened.project.flight.as_ref());
        path.is_some_and(|path| path.keyframes.len() > 1)
    }

    /// Plays the flight from where one is, from the start when one is at the end; or pauses.
    pub fn play(&mut self) {
        if self.flights.playing.take().is_some() {
            return;
        }
        let Some(end_s) = self.session.as_ref().and_then(|s| Some(s.opened.project.flight.as_ref()?.end_s()))
        else {
            return;
        };
        let from_s = if self.flights.time_s >= end_s { 0.0 } else { self.flights.time_s };
        self.flights.shown = true;
        self.flights.playing = Some((self.window.now_s, from_s));
    }

    /// The flight plays.
    pub fn plays(&self) -> bool {
        self.flights.playing.is_some()
    }

    /// Goes on with the flight that plays.
    pub fn fly_on(&mut self) {
        let Some((since_s, from_s)) = self.flights.playing else { return };
        let time_s = from_s + self.window.now_s - since_s;
        let end_s = self.flight().map_or(0.0, |flight| flight.span_s()[1]);
        self.go_to(time_s.min(end_s));
        if time_s >= end_s {
            self.flights.playing = None;
        }
        self.window.wake_within(0.0);
    }

    /// Shows the flight at a time.
    pub fn go_to(&mut self, time_s: f64) {
        self.flights.time_s = time_s;
        let pivot = self.space.viewpoint.pivot;
        let Some(flight) = self.flight() else { return };
        let (camera, pose) = flight.at(time_s);
        let view = Viewpoint { pose, lens: FrameLens::of(&camera), pivot };
        let now_s = self.window.now_s;
        self.space.show_from(view, now_s);
    }

    fn flight(&mut self) -> Option<&Flight> {
        let session = self.session.as_ref()?;
        let path = session.opened.project.flight.as_ref()?;
        if self.flights.made.as_ref().is_none_or(|(made, _)| made != path) {
            self.flights.made = Some((path.clone(), path.flight(session.ground.up).ok()));
        }
        self.flights.made.as_ref()?.1.as_ref()
    }

    /// Flies to a view that was kept.
    pub fn fly_to_view(&mut self, place: usize) {
        let Some(session) = &self.session else { return };
        let Some(view) = session.opened.project.views.get(place).map(Bookmark::viewpoint) else { return };
        self.fly_to_viewpoint(view);
    }
}

/// Asks for an edit of the project.
fn ask_edit(state: &State, asks: &mut Vec<Ask>, name: &str, edit: impl FnOnce(&mut Project)) {
    if let Some(mut project) = state.project() {
        edit(&mut project);
        asks.push(Ask::Decide(DecideAsk::Edit(name.to_owned(), Box::new(project), None)));
    }
}
