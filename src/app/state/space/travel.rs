//! Flights of the 3D view from one viewpoint to another.

use super::SpaceView;
use crate::state::session::Session;
use quadratura_base::scene::PhotoId;
use quadratura_view::flight::{Flight, FrameLens};
use quadratura_view::navigation::Viewpoint;

/// The duration of a flight between viewpoints, in seconds: long enough to follow, short enough not to wait.
const FLIGHT_S: f64 = 0.6;

/// A flight to another viewpoint.
pub struct Travel {
    flight: Flight,
    since_s: f64,
    to: Viewpoint,
    /// The photo through which the view looks when it is there.
    pub through: Option<PhotoId>,
}

impl SpaceView {
    /// Records a movement by the user: the view leaves the photo.
    pub fn moved(&mut self, now_s: f64) {
        self.changed_s = now_s;
        self.through = None;
        self.travel = None;
    }

    /// Starts a flight to a viewpoint, maybe through a photo; the view is there at once where it is there already.
    pub fn fly(&mut self, to: Viewpoint, through: Option<PhotoId>, session: &Session, now_s: f64) {
        match self.viewpoint.flight_to(&to, FLIGHT_S, session.scene_frame.up) {
            Some(flight) => {
                self.through = None;
                self.travel = Some(Travel { flight, since_s: now_s, to, through });
            }
            None => {
                self.viewpoint = to;
                self.through = through;
            }
        }
        self.changed_s = now_s;
    }

    /// Advances a flight.
    pub fn travel(&mut self, now_s: f64) {
        let Some(travel) = &self.travel else { return };
        let since = now_s - travel.since_s;
        if since >= FLIGHT_S {
            (self.viewpoint, self.through) = (travel.to, travel.through);
            (self.travel, self.landed_s) = (None, Some(now_s));
        } else {
            let (camera, pose) = travel.flight.at(since);
            self.viewpoint =
                Viewpoint { pose, lens: FrameLens::from_camera(&camera), pivot: travel.to.pivot };
        }
        self.changed_s = now_s;
    }

    /// Returns whether the view flies in the frame at this time, of which the last one of a flight is a part.
    pub fn flies(&self, now_s: f64) -> bool {
        self.travel.is_some() || self.landed_s == Some(now_s)
    }
}
