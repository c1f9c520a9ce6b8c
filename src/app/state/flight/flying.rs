//! Methods of the whole state for bookmarks and the flight: keeping views, keyframes, and playing.

use crate::state::State;
use quadratura_document::bookmark::BookmarkIndex;
use quadratura_document::camera_path::KeyframeIndex;
use quadratura_document::{Bookmark, CameraPath, Project};
use quadratura_view::flight::{Flight, FrameLens};
use quadratura_view::navigation::Viewpoint;

/// The time between the last keyframe and one that is added at the end, in seconds.
const LEG_S: f64 = 2.0;
/// The default size of videos, in pixels.
const USUAL_SIZE: [u32; 2] = [1920, 1080];

impl State {
    /// Returns a copy of the open project with all decisions so far.
    pub fn project(&self) -> Option<Project> {
        Some(Project::clone(self.session.as_ref()?.history.present()))
    }

    /// Adds a bookmark of the view.
    pub fn keep_view(&mut self) {
        let Some(mut project) = self.project() else { return };
        let name = (1..).map(|number| format!("View {number}"));
        let mut free = name.filter(|name| project.views.iter().all(|view| view.name != *name));
        let Some(name) = free.next() else { return };
        project.views.push(Bookmark::new(name.clone(), &self.space.viewpoint));
        self.flights.shown = true;
        self.edit(format!("bookmark {name}"), project, None);
    }

    /// Adds a keyframe of the view at the current time, or after the last one when the time is at the end.
    pub fn add_keyframe(&mut self) {
        let Some(mut project) = self.project() else { return };
        let mut path = project.flight.take().unwrap_or_else(|| CameraPath::empty(USUAL_SIZE));
        let at_end = !path.keyframes.is_empty() && self.flights.time_s >= path.end_s();
        let time_s = if at_end { path.end_s() + LEG_S } else { self.flights.time_s };
        path.set(time_s, &self.space.viewpoint);
        self.flights.keyframe = path.keyframes.iter().position(|frame| frame.t == time_s).map(KeyframeIndex);
        self.flights.time_s = time_s;
        self.flights.shown = true;
        project.flight = Some(path);
        self.edit("keyframe", project, None);
    }

    /// Removes the selected keyframe from the flight.
    pub fn remove_keyframe(&mut self) {
        let (Some(mut project), Some(index)) = (self.project(), self.flights.keyframe.take()) else { return };
        if let Some(path) = &mut project.flight {
            path.remove(index);
        }
        self.edit("removal of a keyframe", project, None);
    }

    /// Returns whether a keyframe is selected.
    pub fn has_keyframe(&self) -> bool {
        self.flights.keyframe.is_some()
    }

    /// Returns whether the project has a flight of at least two keyframes.
    pub fn can_fly(&self) -> bool {
        let path = self.session.as_ref().and_then(|session| session.opened.project.flight.as_ref());
        path.is_some_and(|path| path.keyframes.len() > 1)
    }

    /// Plays the flight from the current time, from the start when it is at the end; or pauses it.
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

    /// Returns whether the flight plays.
    pub fn plays(&self) -> bool {
        self.flights.playing.is_some()
    }

    /// Advances the flight while it plays.
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

    /// Shows the flight at a time, in seconds.
    pub fn go_to(&mut self, time_s: f64) {
        self.flights.time_s = time_s;
        let pivot = self.space.viewpoint.pivot;
        let Some(flight) = self.flight() else { return };
        let (camera, pose) = flight.at(time_s);
        let view = Viewpoint { pose, lens: FrameLens::from_camera(&camera), pivot };
        let now_s = self.window.now_s;
        self.space.show_from(view, now_s);
    }

    fn flight(&mut self) -> Option<&Flight> {
        let session = self.session.as_ref()?;
        let path = session.opened.project.flight.as_ref()?;
        if self.flights.made.as_ref().is_none_or(|(made, _)| made != path) {
            self.flights.made = Some((path.clone(), path.flight(session.scene_frame.up).ok()));
        }
        self.flights.made.as_ref()?.1.as_ref()
    }

    /// Flies to a bookmark.
    pub fn fly_to_view(&mut self, BookmarkIndex(index): BookmarkIndex) {
        let Some(session) = &self.session else { return };
        let Some(view) = session.opened.project.views.get(index).map(Bookmark::viewpoint) else { return };
        self.fly_to_viewpoint(view);
    }
}
