//! Questions about fillings and exposures, which the whole state answers.

use crate::state::State;
use crate::state::session::Session;
use quadratura_base::scene::PhotoId;

impl State {
    /// Returns the factors of a photo's linear light that match the others, R, G, B; none until they are known.
    pub fn even_factors(&self, photo: PhotoId) -> Option<[f64; 3]> {
        self.quality.colour.factors.get(photo.index()).copied()
    }

    /// Returns whether the project has paint, nobody has chosen where it is seen, and the question is not put off.
    pub fn asks_where_paint_is_seen(&self) -> bool {
        let undecided = |session: &Session| session.opened.project.fill.propagate.is_undecided();
        let painted = !self.round_trip.painted.is_empty();
        painted && !self.quality.fill.chooses_later && self.session.as_ref().is_some_and(undecided)
    }
}

impl Session {
    /// Returns whether paint of some photo is projected to another one, or a decision asks for it.
    pub fn has_propagated(&self) -> bool {
        let fills = self.photos.iter().filter_map(|photo| photo.stack.as_ref()?.fill.as_ref());
        let laid = fills.flat_map(|fill| &fill.propagated).any(|paint| paint.texels > 0);
        laid || !self.opened.project.fill.propagate.patterns().is_empty()
    }
}
